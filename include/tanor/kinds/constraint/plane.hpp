#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// xi = (normal.r - offset)/|normal|
struct Planes {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction normal{};
  Parameter offset = 0.0;
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

/// The fields of a plane, as a constraint and as coordinates.
template <class Group>
inline constexpr std::tuple plane_fields{
    FieldOf("normal", &Group::normal, {.role = FieldRole::Direction, .is_required = true}),
    FieldOf("offset", &Group::offset, {.unit = "m"})};

template <>
struct KindOf<Planes> {
  static constexpr std::string_view name = "plane";
  static constexpr auto members = &Planes::points;
  static constexpr int rows = 1;
  static constexpr auto parameter = &Planes::offset;
  static constexpr auto fields = std::tuple_cat(plane_fields<Planes>, one_sided_fields<Planes>);

  template <class T>
  struct Definition {
    TripleOf<T> normal;

    /// `given` is Planes, or coordinates with the same fields.
    template <class Shape, class Now>
    Definition(const Shape& given, const Now& now) : normal(now(given.normal)) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      return dot(normal, r[0]);
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& offset, std::size_t k) const {
      return {(measure(r, k) - offset) / norm(normal)};
    }
  };

  template <class Shape>
  static double leverage(const Shape& planes, double t, double) {
    const auto n = planes.normal(t);
    return 1.0 / std::hypot(n[0].value(), n[1].value(), n[2].value());
  }
};

}  // namespace tanor
