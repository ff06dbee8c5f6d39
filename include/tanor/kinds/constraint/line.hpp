#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>
#include <tanor/kinds/line_frame.hpp>

namespace tanor {

/// Points on a line; two rows for each, the distances along two unit vectors orthogonal to the direction d. These
/// depend on d alone: e1 is the part orthogonal to d of the coordinate axis that d is farthest from (the first of axes
/// that are equally far), and e2 = d x e1. When another axis becomes the farthest, they jump by a rotation around d;
/// K lambda does not.
struct Lines {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction origin{};
  VectorFunction direction{};
};

/// The fields of a line, as a constraint and as coordinates.
template <class Group>
inline constexpr std::tuple line_fields{
    FieldOf("origin", &Group::origin, {.unit = "m", .role = FieldRole::Place, .is_required = true}),
    FieldOf("direction", &Group::direction, {.role = FieldRole::Direction, .is_required = true})};

template <>
struct KindOf<Lines> {
  static constexpr std::string_view name = "line";
  static constexpr auto members = &Lines::points;
  static constexpr int rows = 2;
  static constexpr auto fields = line_fields<Lines>;
  /// The rows use the two unit vectors of this direction (line_frame.hpp), which jump when another axis is used.
  static constexpr auto turning = &Lines::direction;

  template <class T>
  struct Definition {
    TripleOf<T> origin, first, second;

    /// `axis` replaces the one of the rule.
    template <class Now>
    Definition(const Lines& given, const Now& now, std::optional<LineAxis> axis = {}) : origin(now(given.origin)) {
      const TripleOf<T> along = now(given.direction);
      const std::array<T, 3> d{along.x, along.y, along.z};
      const auto [e1, e2] = line_frame(d, axis ? *axis : line_axis(d));
      first = {e1[0], e1[1], e1[2]};
      second = {e2[0], e2[1], e2[2]};
    }

    template <class Points>
    std::array<T, 2> xi(const Points& r, const T&, std::size_t) const {
      const TripleOf<T> a = r[0] - origin;
      return {dot(first, a), dot(second, a)};
    }
  };
};

}  // namespace tanor
