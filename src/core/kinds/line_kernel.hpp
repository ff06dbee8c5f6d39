#pragma once

#include <array>
#include <cmath>
#include <vector>

#include <tanor/kinds/constraint/line.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// The two unit vectors of lines, with their derivatives. `choose` applies the rule of line_frame.hpp when a K is
/// evaluated that others refer to. Until the next such call the axes are kept, so that what a step compares with that K
/// does not jump inside it.
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
  /// Returns a number that encodes all axes, so that it changes when one jumps.
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
    std::array<Jet<2>, 3> direction;  // at the present time
  };
  static Value make(const std::array<Jet<2>, 3>& direction, LineAxis axis) {
    const auto [first, second] = line_frame(direction, axis);
    return {make_moving(first), make_moving(second)};
  }
  /// Returns true if the direction is within 6 degrees of the axis. A step that turns so far has no use for its K.
  static bool is_near(const std::array<Jet<2>, 3>& direction, LineAxis axis) {
    const double length = std::hypot(direction[0].value(), direction[1].value(), direction[2].value());
    return !(std::abs(direction[static_cast<std::size_t>(axis)].value()) <= 0.995 * length);
  }

  std::vector<Value> now_;
  std::vector<Moving> moving_;
};

/// xi is e1.(r - origin) and e2.(r - origin).
struct LineKernel {
  static constexpr int num_points = 1, num_rows = 2, num_blocks = 2;
  static constexpr bool unit_gradient = true;
  using Group = Lines;

  std::vector<std::array<Index, 1>> points;
  std::vector<Index> geometry;
  VectorTable<AsGiven> origin;
  LineNormals normals;
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void add(const Lines& lines) {
    origin.add(lines.origin);
    normals.add(lines.direction);
  }

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

}  // namespace tanor::detail
