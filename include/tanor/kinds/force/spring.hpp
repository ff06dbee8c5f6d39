#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// The force on r_i is (k (L - rest) + c dL/dt) along (r_j - r_i)/L with L = |r_j - r_i|; that on r_j is the opposite.
struct Springs {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  double stiffness = 0.0;   ///< N/m, >= 0
  double damping = 0.0;     ///< N s/m, >= 0
  Parameter rest_length{};  ///< m, >= 0, constant
};

template <>
struct KindOf<Springs> {
  static constexpr std::string_view name = "spring";
  static constexpr auto members = &Springs::pairs;
  static constexpr const char* distinct = "a spring joins two different points";
  static constexpr std::tuple fields{
      FieldOf("stiffness", &Springs::stiffness,
              {.unit = "N/m", .range = ValueRange::not_negative, .is_required = true}),
      FieldOf("damping", &Springs::damping, {.unit = "N s/m", .range = ValueRange::not_negative}),
      FieldOf("rest_length", &Springs::rest_length,
              {.unit = "m", .range = ValueRange::not_negative, .is_constant = true})};
  static constexpr auto parameter = &Springs::rest_length;

  static bool reads_velocities(const Springs& springs) { return springs.damping > 0.0; }
  /// Returns false for a rest length of 0, which takes no part.
  static bool reads_number(const Springs& springs) {
    return springs.rest_length.is_initial() || springs.rest_length.constants != std::vector{0.0};
  }

  template <class T>
  struct Definition {
    double stiffness, damping;
    bool has_rest_length;

    template <class Now>
    Definition(const Springs& given, const Now&)
        : stiffness(given.stiffness), damping(given.damping), has_rest_length(reads_number(given)) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      return norm(r[1] - r[0]);
    }
    /// Returns the force on r[1], with a = r[1] - r[0]: -(k (L - rest) + c dL/dt) a/L, dL/dt = a.a_dot/L.
    template <class Points>
    TripleOf<T> force(const Points& r, const Points& v, const T& rest_length) const {
      using std::sqrt;
      const TripleOf<T> a = r[1] - r[0];
      T factor = stiffness;
      if (has_rest_length || damping > 0.0) {
        const T square = dot(a, a);
        if (has_rest_length) factor -= stiffness * rest_length / sqrt(square);
        if (damping > 0.0) factor += damping * dot(a, v[1] - v[0]) / square;
      }
      return -factor * a;
    }
  };
};

}  // namespace tanor
