#pragma once

#include <array>
#include <functional>
#include <ostream>
#include <span>
#include <vector>

#include <tanor/motion.hpp>

/// \file Lists of methods for tests, taken from the traits in the table of methods.
namespace tanor {

/// Prints methods in the names of tests.
inline void PrintTo(Method method, std::ostream* out) {
  *out << name_of(method);
}

/// Returns the methods whose traits suit, in the order of the table, without `auto`, which stands for one of the
/// others. `suits` is a function of the traits or one of their members.
template <class Suits>
std::vector<Method> list_methods_that(Suits suits) {
  std::vector<Method> result;
  for (const MethodTraits& each : methods())
    if (each.method != Method::Auto && std::invoke(suits, each)) result.push_back(each.method);
  return result;
}

/// Returns the methods that choose their steps by a tolerance.
inline std::vector<Method> list_adaptive_methods() {
  return list_methods_that([](const MethodTraits& method) { return !method.has_fixed_steps; });
}

/// Returns the explicit methods that choose their steps by a tolerance.
inline std::vector<Method> list_explicit_adaptive_methods() {
  return list_methods_that([](const MethodTraits& method) { return !method.has_fixed_steps && !method.is_implicit; });
}

/// Returns `auto` and these methods.
inline std::vector<Method> with_auto(std::span<const Method> methods) {
  std::vector<Method> result{Method::Auto};
  result.insert(result.end(), methods.begin(), methods.end());
  return result;
}

/// A sample of the explicit methods that serve friction: a Runge-Kutta method of fixed steps, an adaptive one and
/// velocity Verlet. The others run the same loops with other coefficients.
inline constexpr std::array sampled_methods{Method::Rk4, Method::Dopri5, Method::Rattle};

}  // namespace tanor
