#pragma once

#include <array>
#include <cmath>

/// \file
/// The two unit vectors orthogonal to a line, along which its two equations measure distances.
///
/// They depend on the line's direction d alone, not on the motion before: e1 is the part orthogonal to d of the
/// coordinate axis that d is farthest from (the first of axes equally far to 1e-6), to unit length, and e2 = d x e1.
/// When another axis becomes the farthest one, both jump by a rotation around d. K lambda does not, so it is what
/// comparisons should use.
namespace tanor {

/// The number of a coordinate axis.
using LineAxis = int;

namespace detail {

inline double value_of(double x) {
  return x;
}
template <class T>
double value_of(const T& x) {
  return x.value();
}

template <class T>
T dot_of(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class T>
std::array<T, 3> to_unit_length(const std::array<T, 3>& a) {
  using std::sqrt;
  const T length = sqrt(dot_of(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

}  // namespace detail

/// Returns the axis that defines e1, for a direction of any length but 0. Axes that are equally far in a scene differ
/// by rounding; the margin keeps the first of them.
template <class T>
LineAxis line_axis(const std::array<T, 3>& direction) {
  constexpr double margin = 1e-6;
  const double x = std::abs(detail::value_of(direction[0])), y = std::abs(detail::value_of(direction[1])),
               z = std::abs(detail::value_of(direction[2])), tie = margin * std::hypot(x, y, z);
  if (x <= y + tie && x <= z + tie) return 0;
  return y <= z + tie ? 1 : 2;
}

/// Returns e1 and e2 from a given axis. Series and charts use it to continue them beyond where the rule changes the
/// axis.
template <class T>
std::array<std::array<T, 3>, 2> line_frame(const std::array<T, 3>& direction, LineAxis axis) {
  const std::array<T, 3> d = detail::to_unit_length(direction);
  const auto a = static_cast<std::size_t>(axis);
  std::array<T, 3> part;  // h - (h.d) d
  for (std::size_t k = 0; k < 3; ++k) part[k] = T(k == a ? 1.0 : 0.0) - d[a] * d[k];
  const std::array<T, 3> e = detail::to_unit_length(part);
  return {e, {d[1] * e[2] - d[2] * e[1], d[2] * e[0] - d[0] * e[2], d[0] * e[1] - d[1] * e[0]}};
}

/// Returns e1 and e2 by the rule.
template <class T>
std::array<std::array<T, 3>, 2> line_frame(const std::array<T, 3>& direction) {
  return line_frame(direction, line_axis(direction));
}

}  // namespace tanor
