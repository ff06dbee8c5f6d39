#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// A constant of a law of several points: one number for all members or one for each.
///
/// A kind that has an energy has `law_numbers(group)`, the numbers that the group's law reads, in the order of
/// Definition<T>::energy(r, numbers), which is U over a scalar type. Such a definition branches on no number, so that
/// it can be recorded as an expression, from which forces, stiffness and series follow.
struct LawNumber {
  const char* name;
  const Parameter* value;
  ValueRange range = ValueRange::any;
  bool may_be_initial = false;  ///< "initial" is Definition<T>::measure(r) at the start
};

/// True if a kind is an energy over its members.
template <class Group>
concept HasEnergy = requires(const Group& group) {
  KindOf<Group>::law_numbers(group);
};

/// Smallest sine of an angle whose three points do not count as lying on one line.
inline constexpr double least_sine = 1e-8;

namespace detail {

inline std::string show(double number) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr};
}

/// Returns (pi - theta)^2 of the angle theta between a and b, which is smooth through the straight angle and singular
/// at theta = 0.
///
/// The number q = |a/|a| + b/|b||^2/4 is sin^2(x/2) with x = pi - theta. The angle x is halved three times by
/// q' = q/(2 (1 + sqrt(1 - q))). The series x^2 = 4 asin^2(sqrt q) = 2 sum (4 q)^n/(n^2 binomial(2n, n)) then ends
/// after a few terms.
template <class T>
T square_of_bend(const TripleOf<T>& a, const TripleOf<T>& b) {
  using std::sqrt;
  const TripleOf<T> sum = a / norm(a) + b / norm(b);
  T q = 0.25 * dot(sum, sum);
  for (int halving = 0; halving < 3; ++halving) q = q / (2.0 * (1.0 + sqrt(1.0 - q)));
  constexpr int num_terms = 14;  // q < 0.0385 by now
  std::array<double, num_terms + 1> factor{};
  double binomial = 1.0, power = 1.0;
  for (int n = 1; n <= num_terms; ++n) {
    binomial *= 2.0 * (2.0 * n - 1.0) / n;
    power *= 4.0;
    factor[static_cast<std::size_t>(n)] = 2.0 * power / (binomial * n * n);
  }
  T series = factor[num_terms];
  for (std::size_t n = num_terms - 1; n >= 1; --n) series = factor[n] + q * series;
  return 64.0 * q * series;  // 8^2, since x was halved three times
}

}  // namespace detail

}  // namespace tanor
