#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <tanor/system.hpp>

#include "base/vec3.hpp"
#include "evaluate/line_frame.hpp"
#include "evaluate/tables.hpp"

/// The built-in constraints at one instant, hand-written. For a member k, with a = r - (what it is measured from):
///   xi    the constraint itself
///   rate  d xi/dt = K'v + xi_t
///   phi   d2 xi/dt2 along r + e v, t + e: v' Hess(xi) v + 2 v' grad(xi_t) + xi_tt (theory, section 1)
///   gradient blocks, 3 numbers each: one for each point of the member and row; a rod has a single one, its unit
///   vector.
/// Kernels are pure: numbers in, numbers out; inlined into every loop, where the compiler removes what is not used.
namespace tanor {

template <int Rows, int Blocks>
struct Local {
  double xi[Rows], rate[Rows], phi[Rows];
  Vec3 gradient[Blocks];
  double gradient_norm = 1.0;  ///< largest over the blocks
};

/// rho = |a| and its derivatives along a straight line with velocity b: u = a/rho,
/// rho' = u.b, rho'' = (b.b - rho'^2)/rho.
struct Distance {
  Vec3 unit;
  double value, first, second;

  [[gnu::always_inline]] Distance(Vec3 a, Vec3 b) {
    value = norm(a);
    unit = (1.0 / value) * a;
    first = dot(unit, b);
    second = (dot(b, b) - first * first) / value;
  }
};

/// |r_j - r_i + offset| - length. `Timed`: the lengths move; `Shifted`: some offset is not zero.
template <bool Timed, bool Shifted>
struct RodKernel {
  static constexpr int num_points = 2, num_rows = 1, num_blocks = 1;
  static constexpr bool unit_gradient = true;

  std::vector<std::array<Index, 2>> points;
  std::vector<double> length;  // Timed: empty
  ScalarTable moving_length;   // Timed only
  std::vector<Vec3> offset;    // Shifted only

  void set_time(double t) { moving_length.set_time(t); }
  bool depends_on_time() const { return Timed; }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const {
    if constexpr (Timed) return moving_length[k].value;
    return length[k];
  }

  [[gnu::always_inline]] Local<1, 1> operator()(std::size_t k, const double* r, const double* v) const {
    const auto [i, j] = points[k];
    Vec3 a = load(r, j) - load(r, i);
    if constexpr (Shifted) a = a + offset[k];
    const Distance rho(a, load(v, j) - load(v, i));
    Local<1, 1> local{{}, {rho.first}, {rho.second}, {rho.unit}};
    if constexpr (Timed) {
      const MovingScalar& l = moving_length[k];
      local.xi[0] = rho.value - l.value;
      local.rate[0] -= l.first;
      local.phi[0] -= l.second;
    } else {
      local.xi[0] = rho.value - length[k];
    }
    return local;
  }
};

/// Vector to unit length, with its derivatives.
struct ToUnit {
  MovingVec3 operator()(const std::array<Jet<2>, 3>& n) const {
    const Jet<2> length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return make_moving({n[0] / length, n[1] / length, n[2] / length});
  }
};

/// A plane's normal with its length, since the offset is measured along the given normal.
struct PlaneNormal {
  struct Value {
    MovingVec3 unit;
    MovingScalar inverse_length;
  };
  Value operator()(const std::array<Jet<2>, 3>& n) const {
    const Jet<2> inverse = 1.0 / sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    return {make_moving({n[0] * inverse, n[1] * inverse, n[2] * inverse}),
            {inverse.value(), inverse.derivative(1), inverse.derivative(2)}};
  }
};

/// n.r - offset with n = normal/|normal| (unit), offset likewise divided.
struct PlaneKernel {
  static constexpr int num_points = 1, num_rows = 1, num_blocks = 1;
  static constexpr bool unit_gradient = true;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<PlaneNormal> normal;
  ScalarTable offset;        // one a member
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void set_time(double t) {
    normal.set_time(t);
    offset.set_time(t);
  }
  bool depends_on_time() const { return !normal.is_constant() || !offset.is_constant(); }
  bool gradients_are_constant() const { return normal.is_constant(); }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<1, 1> operator()(std::size_t k, const double* r, const double* v) const {
    const auto& [n, c] = normal[geometry[k]];
    const MovingScalar& o = offset[k];
    const Vec3 x = load(r, points[k][0]), b = load(v, points[k][0]);
    return {{dot(n.value, x) - o.value * c.value},
            {dot(n.value, b) + dot(n.first, x) - (o.first * c.value + o.value * c.first)},
            {2.0 * dot(n.first, b) + dot(n.second, x) -
             (o.second * c.value + 2.0 * o.first * c.first + o.value * c.second)},
            {n.value}};
  }
};

/// |r - center| - radius
struct SphereKernel {
  static constexpr int num_points = 1, num_rows = 1, num_blocks = 1;
  static constexpr bool unit_gradient = true;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<AsGiven> center;
  ScalarTable radius;  // one a member

  void set_time(double t) {
    center.set_time(t);
    radius.set_time(t);
  }
  bool depends_on_time() const { return !center.is_constant() || !radius.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return radius[k].value; }

  [[gnu::always_inline]] Local<1, 1> operator()(std::size_t k, const double* r, const double* v) const {
    const MovingVec3& c = center[geometry[k]];
    const MovingScalar& R = radius[k];
    const Distance rho(load(r, points[k][0]) - c.value, load(v, points[k][0]) - c.first);
    return {
        {rho.value - R.value}, {rho.first - R.first}, {rho.second - dot(rho.unit, c.second) - R.second}, {rho.unit}};
  }
};

/// The two unit vectors of lines, with their derivatives. `choose` applies the rule of line_frame.hpp where a K begins
/// to stand; until the next one the axes are kept, so that what a step sets against that K does not jump inside it.
class LineNormals {
 public:
  struct Value {
    MovingVec3 first, second;
  };

  std::size_t add(const VectorFunction& function) {
    if (!function.is_constant()) moving_.push_back({now_.size(), function, none, {}});
    now_.push_back(function.is_constant() ? make(function(0.0), line_axis(function(0.0))) : Value{});
    return now_.size() - 1;
  }
  void set_time(double t) {
    for (Moving& line : moving_) {
      line.direction = line.function(t);
      if (line.axis == none || is_near(line.direction, line.axis)) line.axis = line_axis(line.direction);
      now_[line.slot] = make(line.direction, line.axis);
    }
  }
  void choose() {
    for (Moving& line : moving_) {
      const LineAxis axis = line_axis(line.direction);
      if (axis != line.axis) now_[line.slot] = make(line.direction, axis);
      line.axis = axis;
    }
  }
  /// Of all axes: another number after a jump.
  std::size_t frames() const {
    std::size_t number = 0;
    for (const Moving& line : moving_) number = 3 * number + static_cast<std::size_t>(line.axis);
    return number;
  }
  const Value& operator[](std::size_t slot) const { return now_[slot]; }
  bool is_constant() const { return moving_.empty(); }

 private:
  static constexpr LineAxis none = -1;
  struct Moving {
    std::size_t slot;
    VectorFunction function;
    LineAxis axis;
    std::array<Jet<2>, 3> direction;  // at the time
  };
  static Value make(const std::array<Jet<2>, 3>& direction, LineAxis axis) {
    const auto [first, second] = line_frame(direction, axis);
    return {make_moving(first), make_moving(second)};
  }
  /// Within 6 degrees: a step that turns so far has no use for its K.
  static bool is_near(const std::array<Jet<2>, 3>& direction, LineAxis axis) {
    const double length = std::hypot(direction[0].value(), direction[1].value(), direction[2].value());
    return !(std::abs(direction[static_cast<std::size_t>(axis)].value()) <= 0.995 * length);
  }

  std::vector<Value> now_;
  std::vector<Moving> moving_;
};

/// e1.(r - origin), e2.(r - origin)
struct LineKernel {
  static constexpr int num_points = 1, num_rows = 2, num_blocks = 2;
  static constexpr bool unit_gradient = true;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<AsGiven> origin;
  LineNormals normals;
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void set_time(double t) {
    origin.set_time(t);
    normals.set_time(t);
  }
  bool depends_on_time() const { return !origin.is_constant() || !normals.is_constant(); }
  bool gradients_are_constant() const { return normals.is_constant(); }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<2, 2> operator()(std::size_t k, const double* r, const double* v) const {
    const MovingVec3& o = origin[geometry[k]];
    const auto& pair = normals[geometry[k]];
    const Vec3 a = load(r, points[k][0]) - o.value, b = load(v, points[k][0]) - o.first;
    Local<2, 2> local{};
    const MovingVec3* const e[2] = {&pair.first, &pair.second};
    for (int m = 0; m < 2; ++m) {
      local.xi[m] = dot(e[m]->value, a);
      local.rate[m] = dot(e[m]->value, b) + dot(e[m]->first, a);
      local.phi[m] = 2.0 * dot(e[m]->first, b) + dot(e[m]->second, a) - dot(e[m]->value, o.second);
      local.gradient[m] = e[m]->value;
    }
    return local;
  }
};

/// s = n.a (height over the plane) and rho - radius, rho = |p|, p = a - s n, a = r - center.
struct CircleKernel {
  static constexpr int num_points = 1, num_rows = 2, num_blocks = 2;
  static constexpr bool unit_gradient = true;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<AsGiven> center;
  VectorTable<ToUnit> normal;
  ScalarTable radius;  // one a member

  void set_time(double t) {
    center.set_time(t);
    normal.set_time(t);
    radius.set_time(t);
  }
  bool depends_on_time() const { return !center.is_constant() || !normal.is_constant() || !radius.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return radius[k].value; }

  [[gnu::always_inline]] Local<2, 2> operator()(std::size_t k, const double* r, const double* v) const {
    const MovingVec3 &c = center[geometry[k]], &n = normal[geometry[k]];
    const MovingScalar& R = radius[k];
    // a, a', a'' at w = 0
    const Vec3 a = load(r, points[k][0]) - c.value, a1 = load(v, points[k][0]) - c.first, a2 = -c.second;
    // s = n.a
    const double s = dot(n.value, a);
    const double s1 = dot(n.first, a) + dot(n.value, a1);
    const double s2 = dot(n.second, a) + 2.0 * dot(n.first, a1) + dot(n.value, a2);
    // p = a - s n
    const Vec3 p = a - s * n.value;
    const Vec3 p1 = a1 - s1 * n.value - s * n.first;
    const Vec3 p2 = a2 - s2 * n.value - 2.0 * s1 * n.first - s * n.second;
    // rho'' = (p'.p' - rho'^2)/rho + u.p''
    const Distance rho(p, p1);
    return {{s, rho.value - R.value},
            {s1, rho.first - R.first},
            {s2, rho.second + dot(rho.unit, p2) - R.second},
            {n.value, rho.unit}};
  }
};

/// cos = u.w of the directions u = a/|a|, w = b/|b| from the corner j to i and k, minus the wanted cosine. Near a
/// straight angle a cosine has no digits left of it: cos = s (1 - |e|^2/2) with e = u - s w, s = 1 or -1 as cos has it,
/// keeps them, xi = s (1 - s wanted - |e|^2/2).
struct AngleKernel {
  static constexpr int num_points = 3, num_rows = 1, num_blocks = 3;
  static constexpr bool unit_gradient = false;

  std::vector<std::array<Index, 3>> points;
  ScalarTable cosine;        // one a member
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void set_time(double t) { cosine.set_time(t); }
  bool depends_on_time() const { return !cosine.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<1, 3> operator()(std::size_t m, const double* r, const double* v) const {
    const auto [i, j, k] = points[m];
    const MovingScalar& wanted = cosine[m];
    const Vec3 a1 = load(v, i) - load(v, j), b1 = load(v, k) - load(v, j);
    const Distance a(load(r, i) - load(r, j), a1), b(load(r, k) - load(r, j), b1);
    // u' = (a' - rho' u)/rho ; u'' = -(2 rho' u' + rho'' u)/rho since a'' = 0
    const Vec3 u = a.unit, w = b.unit;
    const Vec3 u1 = (1.0 / a.value) * (a1 - a.first * u), w1 = (1.0 / b.value) * (b1 - b.first * w);
    const Vec3 u2 = (-1.0 / a.value) * (2.0 * a.first * u1 + a.second * u);
    const Vec3 w2 = (-1.0 / b.value) * (2.0 * b.first * w1 + b.second * w);
    const double s = dot(u, w) < 0.0 ? -1.0 : 1.0;
    const Vec3 e = u - s * w;
    const Vec3 grad_i = (-s / a.value) * (e - dot(e, u) * u), grad_k = (1.0 / b.value) * (e - dot(e, w) * w);
    Local<1, 3> local{{s * ((1.0 - s * wanted.value) - 0.5 * dot(e, e))},
                      {dot(grad_i, a1) + dot(grad_k, b1) - wanted.first},
                      {dot(u2, w) + 2.0 * dot(u1, w1) + dot(u, w2) - wanted.second},
                      {grad_i, -(grad_i + grad_k), grad_k}};
    // A straight angle has no gradient: rounding's share of 1/length keeps ratios finite there.
    constexpr double rounding = 1e-16;
    local.gradient_norm = std::max({norm(grad_i), norm(grad_k), norm(local.gradient[1]), rounding / a.value});
    return local;
  }
};

/// |r_i - a| + ratio |r_j - b| - length
struct PulleyKernel {
  static constexpr int num_points = 2, num_rows = 1, num_blocks = 2;
  static constexpr bool unit_gradient = false;

  struct Wheel {
    Vec3 a, b;
    double ratio;
  };
  std::vector<std::array<Index, 2>> points;
  std::vector<Index> geometry;
  std::vector<Wheel> wheels;
  ScalarTable length;        // one a member; may be 0 or negative where the ratio is
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void set_time(double t) { length.set_time(t); }
  bool depends_on_time() const { return !length.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<1, 2> operator()(std::size_t k, const double* r, const double* v) const {
    const auto [i, j] = points[k];
    const auto& [a, b, ratio] = wheels[geometry[k]];
    const MovingScalar& l = length[k];
    const Distance first(load(r, i) - a, load(v, i)), second(load(r, j) - b, load(v, j));
    Local<1, 2> local{{first.value + ratio * second.value - l.value},
                      {first.first + ratio * second.first - l.first},
                      {first.second + ratio * second.second - l.second},
                      {first.unit, ratio * second.unit}};
    local.gradient_norm = std::max(1.0, std::abs(ratio));
    return local;
  }
};

}  // namespace tanor
