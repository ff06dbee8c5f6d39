#pragma once

#include <array>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include <tanor/forward.hpp>

#include "evaluate/coordinate_family.hpp"
#include "kinds/jet_kernel.hpp"

namespace tanor::detail {

/// Coordinates of single points without a hand-written kernel. Their definition runs on Jet<2> along (q + e q', t + e),
/// which yields r, v and psi, and on Forward, which yields the tangents.
template <class G>
class JetChart {
 public:
  using Group = G;
  static constexpr int num_coordinates = KindOf<Group>::coordinates;

  Index add(const Group& group, double t) {
    groups_.add(group);
    groups_.set_time(t);
    return static_cast<Index>(groups_.size() - 1);
  }
  void add_member(const Group& group, Index slot, std::size_t k, Vec3 r, double t) {
    const DefinitionOf<double> now(group, ClockOf<double>{t});
    const std::array<TripleOf<double>, 1> at{{{r.x, r.y, r.z}}};
    entry_.push_back(slot);
    if constexpr (has_number)
      number_.append_member(number_.add(number_of(group.*KindOf<Group>::parameter, k, now.measure(at, k))));
    chart_.push_back(chart_at(now, at[0]));
  }

  bool depends_on_time() const { return groups_.depends_on_time(); }
  void set_time(double t) {
    number_.set_time(t);
    groups_.set_time(t);
    time_ = t;
  }

  Place<num_coordinates> place(std::size_t k, const double* q, const double* q_dot) const {
    const auto& each = groups_[entry_[k]];
    NumbersOf<Group, Jet<2>> curve;
    NumbersOf<Group, Variable> variables;
    for (int j = 0; j < num_coordinates; ++j) {
      const auto i = static_cast<std::size_t>(j);
      curve[i] = Jet<2>::variable(q[j], q_dot[j]);
      variables[i] = Variable::variable(q[j], j);
    }
    const Jet<2> number = number_along(k);
    const TripleOf<Jet<2>> r = each.along->place(curve, number, chart_[k]);
    const TripleOf<Variable> around = each.around->place(variables, Variable(number.value()), chart_[k]);

    const MovingVec3 moving = make_moving({r.x, r.y, r.z});
    Place<num_coordinates> result{moving.value, moving.first, moving.second, {}};
    for (std::size_t j = 0; j < num_coordinates; ++j) result.tangent[j] = {around.x.d[j], around.y.d[j], around.z.d[j]};
    return result;
  }
  void locate(std::size_t k, Vec3 r, double* q) {
    const DefinitionOf<double> now(group_of(k), ClockOf<double>{time_});
    const TripleOf<double> at{r.x, r.y, r.z};
    chart_[k] = chart_at(now, at);
    const NumbersOf<Group, double> found = now.locate(at, number_along(k).value(), chart_[k]);
    std::ranges::copy(found, q);
  }

  bool has_charts() const { return has_chart; }
  void exchange_memory([[maybe_unused]] Memory& memory) {
    if constexpr (has_chart) memory.exchange(chart_);
  }
  void begin_recentre(double t) { time_ = t; }
  /// Evaluates the motion r(t) in the present chart, and writes its numbers in the chart of the present place.
  void recentre([[maybe_unused]] std::size_t k, [[maybe_unused]] double* q, [[maybe_unused]] double* q_dot,
                [[maybe_unused]] double* q_ddot) {
    if constexpr (has_chart) {
      const auto& each = groups_[entry_[k]];
      NumbersOf<Group, Jet<2>> curve;
      for (std::size_t j = 0; j < curve.size(); ++j) curve[j] = make_jet({q[j], q_dot[j], q_ddot[j]});
      const TripleOf<Jet<2>> r = each.along->place(curve, number_along(k), chart_[k]);
      const DefinitionOf<double> now(group_of(k), ClockOf<double>{time_});
      const Chart chart = chart_at(now, {r.x.value(), r.y.value(), r.z.value()});
      if (chart == chart_[k]) return;
      chart_[k] = chart;
      curve = each.along->locate(r, number_along(k), chart);
      for (std::size_t j = 0; j < curve.size(); ++j) {
        q[j] = curve[j].value();
        q_dot[j] = curve[j].derivative(1);
        q_ddot[j] = curve[j].derivative(2);
      }
    }
  }

 private:
  template <class T>
  using DefinitionOf = typename KindOf<Group>::template Definition<T>;
  using Variable = Forward<num_coordinates>;
  using Chart = ChartOf<Group>;
  static constexpr bool has_chart = !std::is_same_v<Chart, NoChart>;
  static constexpr bool has_number = requires { KindOf<Group>::parameter; };

  const Group& group_of(std::size_t k) const { return *groups_[entry_[k]].group; }
  Jet<2> number_along(std::size_t k) const {
    if constexpr (has_number) return make_jet(number_[k]);
    return {};
  }
  static Chart chart_at([[maybe_unused]] const DefinitionOf<double>& now, [[maybe_unused]] const TripleOf<double>& r) {
    if constexpr (has_chart)
      return now.chart_at(r);
    else
      return {};
  }

  double time_ = 0.0;
  DefinitionsNow<Group, Variable> groups_;
  std::vector<Index> entry_;  // [member] its group
  std::vector<Chart> chart_;  // [member]
  ScalarTable number_;        // [member] of kinds that have a parameter
};

}  // namespace tanor::detail
