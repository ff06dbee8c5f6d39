#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// f = -c1 v - c2 |v| v
struct Drag {
  std::string name{};
  std::vector<Index> points{};
  double linear = 0.0;     ///< c1, N s/m, >= 0
  double quadratic = 0.0;  ///< c2, N s^2/m^2, >= 0
};

template <>
struct KindOf<Drag> {
  static constexpr std::string_view name = "drag";
  static constexpr auto members = &Drag::points;
  static constexpr std::tuple fields{
      FieldOf("linear", &Drag::linear, {.unit = "N s/m", .range = ValueRange::not_negative}),
      FieldOf("quadratic", &Drag::quadratic, {.unit = "N s^2/m^2", .range = ValueRange::not_negative})};

  static bool reads_velocities(const Drag&) { return true; }

  template <class T>
  struct Definition {
    double linear, quadratic;

    template <class Now>
    Definition(const Drag& given, const Now&) : linear(given.linear), quadratic(given.quadratic) {}

    template <class Points>
    TripleOf<T> force(const Points&, const Points& v, const T&) const {
      T factor = linear;
      if (quadratic > 0.0) factor += quadratic * norm(v[0]);
      return -factor * v[0];
    }
  };
};

}  // namespace tanor
