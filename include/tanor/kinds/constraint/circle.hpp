#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Points on a circle; two rows for each: the distance from the circle's plane, and the distance from its axis -
/// radius.
struct Circles {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  VectorFunction normal{};
  Parameter radius{};
};

/// The fields of a circle, as a constraint and as coordinates.
template <class Group>
inline constexpr std::tuple circle_fields{
    FieldOf("center", &Group::center, {.unit = "m", .role = FieldRole::Center, .is_required = true}),
    FieldOf("normal", &Group::normal, {.role = FieldRole::Direction, .is_required = true}),
    FieldOf("radius", &Group::radius, {.unit = "m", .range = ValueRange::positive})};

template <>
struct KindOf<Circles> {
  static constexpr std::string_view name = "circle";
  static constexpr auto members = &Circles::points;
  static constexpr int rows = 2;
  static constexpr auto parameter = &Circles::radius;
  static constexpr auto fields = circle_fields<Circles>;

  template <class T>
  struct Definition {
    TripleOf<T> center, normal;

    /// `given` is Circles, or coordinates with the same fields.
    template <class Shape, class Now>
    Definition(const Shape& given, const Now& now) : center(now(given.center)), normal(now(given.normal)) {}

    /// Returns |n x a|/|n|, the distance from the axis.
    template <class Points>
    T measure(const Points& r, std::size_t) const {
      return norm(cross(normal, r[0] - center)) / norm(normal);
    }
    template <class Points>
    std::array<T, 2> xi(const Points& r, const T& radius, std::size_t k) const {
      return {dot(normal, r[0] - center) / norm(normal), measure(r, k) - radius};
    }
  };

  template <class Points>
  static const char* complaint(const Circles& circles, const Definition<double>& now, const Points& r, std::size_t) {
    if (!circles.radius.is_initial()) return nullptr;
    // |n x (r - c)| = |n| (distance from the axis) is zero, up to rounding, on the axis.
    constexpr double rounding = 8.0 * std::numeric_limits<double>::epsilon();
    const TripleOf<double> arm = r[0] - now.center;
    if (norm(cross(now.normal, arm)) > rounding * norm(now.normal) * norm(arm)) return nullptr;
    return "it is on the axis: the initial radius is 0; a radius is positive";
  }
};

}  // namespace tanor
