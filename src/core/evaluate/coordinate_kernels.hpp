#pragma once

#include <array>
#include <cmath>
#include <vector>

#include <tanor/kinds/line_frame.hpp>

#include "evaluate/charts.hpp"
#include "evaluate/circle_kernels.hpp"
#include "evaluate/coordinate_family.hpp"
#include "kinds/circle_kernel.hpp"
#include "kinds/jet_kernel.hpp"
#include "kinds/tables.hpp"

/// \file Coordinates of single points, written by hand where speed asks for it; jet_chart.hpp serves the others. psi is
/// the second derivative along (q + e q', t + e).
namespace tanor::detail {

/// The two unit vectors orthogonal to a direction that may turn. They come from an axis that stays between steps, as a
/// chart does. `recentre` chooses another axis if the direction has come near it; the pair then turns by an angle
/// beta(t) in its plane.
class TurningPair {
 public:
  MovingVec3 direction{}, first{}, second{};

  TurningPair(const VectorFunction& d, double t) : function_(d) {
    helper_ = farthest_axis(t);
    set_time(t);
  }
  bool moves() const { return !function_.is_constant(); }
  void set_time(double t) {
    time_ = t;
    direction = ToUnit{}(function_(t));
    jets_ = line_frame(function_(t), helper_);
    first = make_moving(jets_[0]);
    second = make_moving(jets_[1]);
  }
  void exchange_memory(Memory& memory) {
    memory.exchange(helper_);
    if (memory.reads()) set_time(time_);
  }
  /// Returns beta, which is 0 if the pair stays.
  Jet<2> recentre(double t) {
    constexpr double near = 0.9;
    if (!moves() || std::abs(component(direction.value, helper_)) <= near) return 0.0;
    const auto before = jets_;
    helper_ = farthest_axis(t);
    set_time(t);
    const auto product = [](const std::array<Jet<2>, 3>& a, const std::array<Jet<2>, 3>& b) {
      return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    return atan2(product(jets_[0], before[1]), product(jets_[0], before[0]));
  }

 private:
  /// Returns the axis that the direction is farthest from now and does not turn into.
  LineAxis farthest_axis(double t) const {
    if (!moves()) return line_axis(function_(t));
    const MovingVec3 d = ToUnit{}(function_(t));
    const double turning = norm(d.first);
    const Vec3 along = turning > 0.0 ? (1.0 / turning) * d.first : Vec3{};
    const auto badness = [&](LineAxis axis) {
      return std::pow(component(d.value, axis), 2) + 0.5 * std::pow(component(along, axis), 2);
    };
    LineAxis best = 0;
    for (const LineAxis axis : {1, 2}) {
      if (badness(axis) < badness(best)) best = axis;
    }
    return best;
  }
  static double component(Vec3 a, LineAxis axis) { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }

  VectorFunction function_;
  double time_ = 0.0;
  LineAxis helper_;
  std::array<std::array<Jet<2>, 3>, 2> jets_{};
};

/// Writes q, q', q'' from a jet.
inline void write_jet(const Jet<2>& jet, double* value, double* first, double* second) {
  *value = jet.value();
  *first = jet.derivative(1);
  *second = jet.derivative(2);
}

/// The functions of charts of a kernel that has one chart for all places.
struct OneChart {
  bool has_charts() const { return false; }
  void exchange_memory(Memory&) {}
  void begin_recentre(double) {}
  void recentre(std::size_t, double*, double*, double*) const {}
};

/// Free points: r = q.
struct FreeKernel : OneChart {
  using Group = FreeCoordinates;
  static constexpr int num_coordinates = 3;

  Index add(const FreeCoordinates&, double) { return 0; }
  void add_member(const FreeCoordinates&, Index, std::size_t, Vec3, double) {}
  bool depends_on_time() const { return false; }
  void set_time(double) {}
  Place<3> place(std::size_t, const double* q, const double* q_dot) const {
    return {load(q, 0), load(q_dot, 0), {}, {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  }
  void locate(std::size_t, Vec3 r, double* q) const { store(q, 0, r); }
};

/// Points on a line, r = o + q e.
struct LineChartKernel : OneChart {
  using Group = LineCoordinates;
  static constexpr int num_coordinates = 1;

  std::vector<Index> entry;  ///< [member]
  VectorTable<AsGiven> origin;
  VectorTable<ToUnit> direction;

  Index add(const LineCoordinates& group, double) {
    origin.add(group.origin);
    return static_cast<Index>(direction.add(group.direction));
  }
  void add_member(const LineCoordinates&, Index slot, std::size_t, Vec3, double) { entry.push_back(slot); }

  bool depends_on_time() const { return !origin.is_constant() || !direction.is_constant(); }
  void set_time(double t) {
    origin.set_time(t);
    direction.set_time(t);
  }
  Place<1> place(std::size_t k, const double* q, const double* q_dot) const {
    const MovingVec3 &o = origin[entry[k]], &e = direction[entry[k]];
    return {o.value + *q * e.value,
            o.first + *q_dot * e.value + *q * e.first,
            o.second + 2.0 * *q_dot * e.first + *q * e.second,
            {e.value}};
  }
  void locate(std::size_t k, Vec3 r, double* q) const {
    *q = dot(direction[entry[k]].value, r - origin[entry[k]].value);
  }
};

/// Charts in frames that turn with a direction of each group.
struct TurningCharts {
  std::vector<Index> entry;  ///< [member]
  std::vector<TurningPair> axes;
  std::vector<Jet<2>> turn;  ///< [axes] of the last `recentre`

  bool has_charts() const {
    return std::ranges::any_of(axes, [](const TurningPair& pair) { return pair.moves(); });
  }
  void exchange_memory(Memory& memory) {
    for (TurningPair& pair : axes) pair.exchange_memory(memory);
  }
  void begin_recentre(double t) {
    for (std::size_t i = 0; i < axes.size(); ++i) turn[i] = axes[i].recentre(t);
  }

 protected:
  void add_axes(const VectorFunction& direction, double t) {
    axes.emplace_back(direction, t);
    turn.emplace_back();
  }
  void turn_axes(double t) {
    for (TurningPair& pair : axes) {
      if (pair.moves()) pair.set_time(t);
    }
  }
};

/// Points in a plane, r = (offset/|normal|) n + q1 e1 + q2 e2, with the unit normal n and e1, e2 in the plane.
struct PlaneChartKernel : TurningCharts {
  using Group = PlaneCoordinates;
  static constexpr int num_coordinates = 2;

  VectorTable<PlaneNormal> normal;
  ScalarTable offset;

  Index add(const PlaneCoordinates& group, double t) {
    add_axes(group.normal, t);
    return static_cast<Index>(normal.add(group.normal));
  }
  void add_member(const PlaneCoordinates& group, Index slot, std::size_t k, Vec3 r, double t) {
    entry.push_back(slot);
    offset.append_member(offset.add(number_of(group.offset, k, dot(make_moving(group.normal(t)).value, r))));
  }

  bool depends_on_time() const { return !normal.is_constant() || !offset.is_constant(); }
  void set_time(double t) {
    normal.set_time(t);
    offset.set_time(t);
    turn_axes(t);
  }
  Place<2> place(std::size_t k, const double* q, const double* q_dot) const {
    const auto& [n, c] = normal[entry[k]];
    const TurningPair& pair = axes[entry[k]];
    const MovingScalar& o = offset[k];
    // With the height h = offset/|normal|, r = h n + q1 e1 + q2 e2.
    const double h = o.value * c.value, h1 = o.first * c.value + o.value * c.first;
    const double h2 = o.second * c.value + 2.0 * o.first * c.first + o.value * c.second;
    Place<2> result{h * n.value, h1 * n.value + h * n.first, h2 * n.value + 2.0 * h1 * n.first + h * n.second, {}};
    const MovingVec3* const e[2] = {&pair.first, &pair.second};
    for (int j = 0; j < 2; ++j) {
      result.r = result.r + q[j] * e[j]->value;
      result.v = result.v + q_dot[j] * e[j]->value + q[j] * e[j]->first;
      result.psi = result.psi + 2.0 * q_dot[j] * e[j]->first + q[j] * e[j]->second;
      result.tangent[j] = e[j]->value;
    }
    return result;
  }
  void locate(std::size_t k, Vec3 r, double* q) const {
    q[0] = dot(axes[entry[k]].first.value, r);
    q[1] = dot(axes[entry[k]].second.value, r);
  }
  void recentre(std::size_t k, double* q, double* q_dot, double* q_ddot) const {
    const Jet<2>& beta = turn[entry[k]];
    if (beta.value() == 0.0) return;
    const Jet<2> x = make_jet({q[0], q_dot[0], q_ddot[0]}), y = make_jet({q[1], q_dot[1], q_ddot[1]});
    const Jet<2> c = cos(beta), s = sin(beta);
    write_jet(c * x + s * y, q, q_dot, q_ddot);
    write_jet(c * y - s * x, q + 1, q_dot + 1, q_ddot + 1);
  }
};

/// Points on a circle, r = c + R u, with u = cos q e1 + sin q e2 in the plane of the circle.
struct CircleChartKernel : TurningCharts {
  using Group = CircleCoordinates;
  static constexpr int num_coordinates = 1;

  VectorTable<AsGiven> center;
  ScalarTable radius;

  static bool takes(const CircleCoordinates& group) { return detail::depends_on_time(group); }
  Index add(const CircleCoordinates& group, double t) {
    add_axes(group.normal, t);
    return static_cast<Index>(center.add(group.center));
  }
  void add_member(const CircleCoordinates& group, Index slot, std::size_t k, Vec3 r, double t) {
    entry.push_back(slot);
    radius.append_member(radius.add(number_of(group.radius, k, CircleKernel::measure(group, t, r))));
  }

  bool depends_on_time() const { return has_charts() || !radius.is_constant() || !center.is_constant(); }
  void set_time(double t) {
    center.set_time(t);
    radius.set_time(t);
    turn_axes(t);
  }
  Place<1> place(std::size_t k, const double* q, const double* q_dot) const {
    const MovingVec3 &o = center[entry[k]], &e1 = axes[entry[k]].first, &e2 = axes[entry[k]].second;
    const MovingScalar& R = radius[k];
    const double c = std::cos(*q), s = std::sin(*q), rate = *q_dot;
    const Vec3 u = c * e1.value + s * e2.value, t = c * e2.value - s * e1.value;
    const Vec3 u1 = rate * t + c * e1.first + s * e2.first;
    const Vec3 u2 = 2.0 * rate * (c * e2.first - s * e1.first) + c * e1.second + s * e2.second - rate * rate * u;
    return {o.value + R.value * u,
            o.first + R.first * u + R.value * u1,
            o.second + R.second * u + 2.0 * R.first * u1 + R.value * u2,
            {R.value * t}};
  }
  void locate(std::size_t k, Vec3 r, double* q) const {
    const Vec3 a = r - center[entry[k]].value;
    *q = std::atan2(dot(axes[entry[k]].second.value, a), dot(axes[entry[k]].first.value, a));
  }
  void recentre(std::size_t k, double* q, double* q_dot, double* q_ddot) const {
    const Jet<2>& beta = turn[entry[k]];
    *q -= beta.value();
    *q_dot -= beta.derivative(1);
    *q_ddot -= beta.derivative(2);
  }
};

/// Points on circles that stay where they are.
struct FixedCircleKernel : OneChart {
  using Group = CircleCoordinates;
  static constexpr int num_coordinates = 1;
  static constexpr std::size_t run_size = circles::chunk_size;

  std::vector<double> ax, ay, az, bx, by, bz;  ///< [member] r = center + cos q a + sin q b
  std::vector<Vec3> center;

  static bool takes(const CircleCoordinates& group) { return !detail::depends_on_time(group); }
  Index add(const CircleCoordinates& group, double t) {
    const TurningPair axes(group.normal, t);
    group_ = {make_moving(group.center(t)).value, axes.first.value, axes.second.value};
    return 0;
  }
  void add_member(const CircleCoordinates& group, Index, std::size_t k, Vec3 r, double t) {
    const auto& [middle, first, second] = group_;
    const double radius = number_of(group.radius, k, CircleKernel::measure(group, t, r))(t).value();
    const Vec3 a = radius * first, b = radius * second;
    center.push_back(middle);
    for (const auto& [list, number] : {std::pair{&ax, a.x}, {&ay, a.y}, {&az, a.z}, {&bx, b.x}, {&by, b.y}, {&bz, b.z}})
      list->push_back(number);
  }
  circles::Circles from(std::size_t k) const { return {&ax[k], &ay[k], &az[k], &bx[k], &by[k], &bz[k], &center[k]}; }
  bool depends_on_time() const { return false; }
  void set_time(double) {}
  void place_run(std::size_t first, std::size_t count, const double* q, const double* q_dot, Place<1>* places) const {
    circles::place(from(first), count, q, q_dot, places);
  }
  double accelerate_run(std::size_t first, std::size_t count, const double* q, const double* q_dot, Vec3 w0,
                        double* q_ddot, Vec3* w) const {
    return circles::accelerate(from(first), count, q, q_dot, w0, q_ddot, w);
  }
  void locate(std::size_t k, Vec3 r, double* q) const {
    const Vec3 arm = r - center[k];
    *q = std::atan2(dot({bx[k], by[k], bz[k]}, arm), dot({ax[k], ay[k], az[k]}, arm));
  }

 private:
  std::array<Vec3, 3> group_;  // center and unit vectors of the group that is being added
};

/// Points on a sphere, r = c + R u(q), with u in a chart around the present place.
struct SphereChartKernel {
  using Group = SphereCoordinates;
  static constexpr int num_coordinates = 2;

  std::vector<Index> entry;  ///< [member]
  VectorTable<AsGiven> center;
  ScalarTable radius;
  std::vector<DirectionChart> chart;  ///< [member]

  Index add(const SphereCoordinates& group, double) { return static_cast<Index>(center.add(group.center)); }
  void add_member(const SphereCoordinates& group, Index slot, std::size_t k, Vec3 r, double t) {
    entry.push_back(slot);
    chart.emplace_back();
    radius.append_member(radius.add(number_of(group.radius, k, norm(r - make_moving(group.center(t)).value))));
  }

  bool depends_on_time() const { return !center.is_constant() || !radius.is_constant(); }
  void set_time(double t) {
    center.set_time(t);
    radius.set_time(t);
  }
  Place<2> place(std::size_t k, const double* q, const double* q_dot) const {
    const MovingVec3& c = center[entry[k]];
    const MovingScalar& R = radius[k];
    const DirectionChart::Value u = chart[k](q, q_dot);
    return {c.value + R.value * u.u,
            c.first + R.first * u.u + R.value * u.first,
            c.second + R.second * u.u + 2.0 * R.first * u.first + R.value * u.second,
            {R.value * u.tangent[0], R.value * u.tangent[1]}};
  }
  void locate(std::size_t k, Vec3 r, double* q) {
    const Vec3 a = r - center[entry[k]].value;
    chart[k] = DirectionChart((1.0 / norm(a)) * a);
    q[0] = q[1] = 0.0;
  }
  bool has_charts() const { return true; }
  void exchange_memory(Memory& memory) {
    for (DirectionChart& each : chart) each.exchange_memory(memory);
  }
  void begin_recentre(double) {}
  void recentre(std::size_t k, double* q, double* q_dot, double* q_ddot) { chart[k].recentre(q, q_dot, q_ddot); }
};

}  // namespace tanor::detail
