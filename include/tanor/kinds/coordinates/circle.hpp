#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <tanor/kinds/chart.hpp>
#include <tanor/kinds/constraint/circle.hpp>

namespace tanor {

/// The angle around the circle's axis n, rad, from e1 towards n x e1. e1 is the part orthogonal to n of the coordinate
/// axis that n is farthest from, and does not turn into, at the start; another axis is chosen when n comes near to it.
struct CircleCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  VectorFunction normal{};
  Parameter radius{};
};

template <>
struct KindOf<CircleCoordinates> {
  static constexpr std::string_view name = "circle";
  static constexpr auto members = &CircleCoordinates::points;
  static constexpr auto fields = circle_fields<CircleCoordinates>;
  static constexpr int coordinates = 1;
  static constexpr auto parameter = &CircleCoordinates::radius;
  /// The coordinate axis that defines the first unit vector.
  using Chart = LineAxis;

  /// r = center + radius (cos q e1 + sin q e2)
  template <class T>
  struct Definition : KindOf<Circles>::Definition<T> {
    using Base = typename KindOf<Circles>::template Definition<T>;
    using Base::Base, Base::center, Base::normal;

    TripleOf<T> place(const std::array<T, 1>& q, const T& radius, Chart axis) const {
      using std::cos, std::sin;
      const auto [e1, e2] = frame_of(normal, axis);
      return center + radius * (cos(q[0]) * e1 + sin(q[0]) * e2);
    }
    std::array<T, 1> locate(const TripleOf<T>& r, const T&, Chart axis) const {
      using std::atan2;
      const auto [e1, e2] = frame_of(normal, axis);
      return {atan2(dot(e2, r - center), dot(e1, r - center))};
    }
    Chart chart_at(const TripleOf<double>&) const { return axis_of(normal); }
  };

  template <class Points>
  static const char* complaint(const CircleCoordinates& group, const Definition<double>& now, const Points& r,
                               std::size_t) {
    const TripleOf<double> arm = r[0] - now.center;
    constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
    const bool is_initial = group.radius.is_initial();
    if (norm(cross(now.normal, arm)) > (is_initial ? rounding * norm(now.normal) * norm(arm) : 0.0)) return nullptr;
    return is_initial ? "it is on the axis: the initial radius is 0; a radius is positive"
                      : "it is on the axis and has no angle there";
  }
};

}  // namespace tanor
