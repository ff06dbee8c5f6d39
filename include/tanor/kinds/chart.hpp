#pragma once

/// \file
/// Shared parts of the definitions of coordinates: the frame of a direction, and two numbers for a unit vector.

#include <array>

#include <tanor/kinds/kind.hpp>
#include <tanor/kinds/line_frame.hpp>

namespace tanor {

/// Returns the two unit vectors orthogonal to a direction, from a given axis (line_frame.hpp).
template <class T>
std::array<TripleOf<T>, 2> frame_of(const TripleOf<T>& direction, LineAxis axis) {
  const auto [e1, e2] = line_frame(std::array<T, 3>{direction.x, direction.y, direction.z}, axis);
  return {TripleOf<T>{e1[0], e1[1], e1[2]}, TripleOf<T>{e2[0], e2[1], e2[2]}};
}

/// Returns the axis that defines the frame of a direction.
inline LineAxis axis_of(const TripleOf<double>& direction) {
  return line_axis(Vector3{direction.x, direction.y, direction.z});
}

/// Returns e1, orthogonal to the unit vector n and to the coordinate axis that n is farthest from, and e2 = n x e1.
template <class T>
std::array<TripleOf<T>, 2> frame_around(const Vector3& n) {
  const auto [along, across] = line_frame(n);
  return {triple_of<T>(across), T(-1.0) * triple_of<T>(along)};
}

/// Returns the unit vector around n with two given numbers, by stereographic projection from -n. It is, with
/// s = (x^2 + y^2)/4,
///
///     u = ((1 - s) n + x e1 + y e2)/(1 + s)
template <class T>
TripleOf<T> direction_around(const Vector3& n, const T& x, const T& y) {
  const auto [e1, e2] = frame_around<T>(n);
  const T s = 0.25 * (x * x + y * y);
  return ((1.0 - s) * triple_of<T>(n) + x * e1 + y * e2) / (1.0 + s);
}

/// Returns the two numbers of a unit vector u, which must not be -n.
template <class T>
std::array<T, 2> numbers_around(const Vector3& n, const TripleOf<T>& u) {
  const auto [e1, e2] = frame_around<T>(n);
  const T half = 0.5 * (1.0 + dot(triple_of<T>(n), u));
  return {dot(e1, u) / half, dot(e2, u) / half};
}

}  // namespace tanor
