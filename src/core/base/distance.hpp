#pragma once

namespace tanor::detail {

/// Returns the second derivative of |a| while a moves along a straight line with velocity v, which is phi of a rod:
/// (v.v - (u.v)^2)/|a| with the unit vector u = a/|a| and `inverse` = 1/|a|.
template <class Vector, class Number>
[[gnu::always_inline]] inline Number second_derivative_of_distance(const Vector& u, const Vector& v,
                                                                   const Number& inverse) {
  const Number along = dot(u, v);
  return inverse * (dot(v, v) - along * along);
}

}  // namespace tanor::detail
