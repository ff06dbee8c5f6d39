#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <tanor/forward.hpp>
#include <tanor/kinds.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"
#include "system/members.hpp"

namespace tanor::detail {

/// Returns true if a field of the group changes with time.
template <class Group>
bool depends_on_time(const Group& group) {
  bool result = false;
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    const Value& value = group.*field.value;
    if constexpr (std::is_same_v<Value, VectorFunction>) result = result || !value.is_constant();
    if constexpr (std::is_same_v<Value, Parameter>)
      result = result || !std::ranges::all_of(value.functions, &ScalarFunction::is_constant);
  });
  return result;
}

/// The definitions of a kind's groups at the present time: on Jet<2> along the motion, and on Variable for derivatives.
template <class Group, class Variable>
class DefinitionsNow {
 public:
  struct OfGroup {
    std::shared_ptr<const Group> group;
    bool depends_on_time;
    std::optional<typename KindOf<Group>::template Definition<Jet<2>>> along{};
    std::optional<typename KindOf<Group>::template Definition<Variable>> around{};
  };

  void add(const Group& group) {
    groups_.push_back({std::make_shared<const Group>(group), detail::depends_on_time(group)});
  }
  void set_time(double t) {
    for (OfGroup& each : groups_) {
      if (each.along && !each.depends_on_time) continue;
      each.along.emplace(*each.group, ClockOf<Jet<2>>{t});
      each.around.emplace(*each.group, ClockOf<Variable>{t});
    }
  }
  bool depends_on_time() const { return std::ranges::any_of(groups_, &OfGroup::depends_on_time); }
  std::size_t size() const { return groups_.size(); }
  const OfGroup& operator[](Index slot) const { return groups_[static_cast<std::size_t>(slot)]; }
  OfGroup& operator[](Index slot) { return groups_[static_cast<std::size_t>(slot)]; }

 private:
  std::vector<OfGroup> groups_;
};

/// A kind without a hand-written kernel. Its definition runs on Jet<2> along r + e v, t + e, which yields xi, rate and
/// phi, and on Forward, which yields the gradient.
template <class G>
class JetKernel {
 public:
  using Group = G;
  static constexpr int num_points = points_of_member<Group>(), num_rows = KindOf<Group>::rows,
                       num_blocks = num_rows * num_points;
  static constexpr bool unit_gradient = false;

  std::vector<std::array<Index, num_points>> points;
  std::vector<Index> geometry;
  std::vector<Index> member;  ///< its number in the group
  std::vector<double> size;   ///< m, of the neighbourhood, one a member

  void add(const Group& group) { groups_.add(group); }
  ScalarTable& own() requires requires { KindOf<Group>::parameter; }
  { return numbers_; }

  void set_time(double t) {
    numbers_.set_time(t);
    groups_.set_time(t);
  }
  bool depends_on_time() const { return groups_.depends_on_time(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return size[k]; }
  auto& definitions() { return groups_; }

  Local<num_rows, num_blocks> operator()(std::size_t k, const double* r, const double* v) const {
    const auto& each = groups_[geometry[k]];
    const auto own_number = static_cast<std::size_t>(member[k]);
    MovingScalar number{};
    if constexpr (requires { KindOf<Group>::parameter; }) number = numbers_[k];
    std::array<TripleOf<Jet<2>>, num_points> path;
    std::array<TripleOf<Variable>, num_points> places;
    for (int p = 0; p < num_points; ++p) {
      const auto i = static_cast<std::size_t>(p);
      const Vec3 a = load(r, points[k][i]), b = load(v, points[k][i]);
      path[i] = {Jet<2>::variable(a.x, b.x), Jet<2>::variable(a.y, b.y), Jet<2>::variable(a.z, b.z)};
      places[i] = {Variable::variable(a.x, 3 * p), Variable::variable(a.y, 3 * p + 1),
                   Variable::variable(a.z, 3 * p + 2)};
    }
    const auto curve = each.along->xi(path, make_jet(number), own_number);
    const auto slope = each.around->xi(places, Variable(number.value), own_number);

    Local<num_rows, num_blocks> local{};
    for (std::size_t m = 0; m < num_rows; ++m) {
      double square = 0.0;
      local.xi[m] = curve[m].value();
      local.rate[m] = curve[m].derivative(1);
      local.phi[m] = curve[m].derivative(2);
      for (std::size_t p = 0; p < num_points; ++p) {
        const Vec3 gradient{slope[m].d[3 * p], slope[m].d[3 * p + 1], slope[m].d[3 * p + 2]};
        local.gradient[m * num_points + p] = gradient;
        square = std::max(square, dot(gradient, gradient));
      }
      // Ratios stay finite where xi has no gradient.
      local.gradient_norm[m] = std::max(std::sqrt(square), std::numeric_limits<double>::min());
    }
    return local;
  }

 private:
  using Variable = Forward<3 * num_points>;
  DefinitionsNow<Group, Variable> groups_;
  ScalarTable numbers_;  // one a member, of kinds that have a parameter
};

}  // namespace tanor::detail
