#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// xi = |r - center| - radius
struct Spheres {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  Parameter radius{};
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

/// The fields of a sphere, as a constraint and as coordinates.
template <class Group>
inline constexpr std::tuple sphere_fields{
    FieldOf("center", &Group::center, {.unit = "m", .role = FieldRole::Center, .is_required = true}),
    FieldOf("radius", &Group::radius, {.unit = "m", .range = ValueRange::positive})};

template <>
struct KindOf<Spheres> {
  static constexpr std::string_view name = "sphere";
  static constexpr auto members = &Spheres::points;
  static constexpr int rows = 1;
  static constexpr auto parameter = &Spheres::radius;
  static constexpr auto fields = std::tuple_cat(sphere_fields<Spheres>, one_sided_fields<Spheres>);
  static constexpr bool is_distance = true;

  template <class T>
  struct Definition {
    TripleOf<T> center;

    /// `given` is Spheres, or coordinates with the same fields.
    template <class Shape, class Now>
    Definition(const Shape& given, const Now& now) : center(now(given.center)) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      return norm(r[0] - center);
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& radius, std::size_t k) const {
      return {measure(r, k) - radius};
    }
  };

  template <class Points>
  static const char* complaint(const Spheres& spheres, const Definition<double>& now, const Points& r, std::size_t k) {
    if (!spheres.radius.is_initial() || now.measure(r, k) > 0.0) return nullptr;
    return "it is at the center: the initial radius is 0; a radius is positive";
  }
};

}  // namespace tanor
