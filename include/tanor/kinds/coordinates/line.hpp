#pragma once

#include <array>
#include <string>
#include <vector>

#include <tanor/kinds/constraint/line.hpp>

namespace tanor {

/// r = origin + q direction/|direction|, one coordinate for each point, m.
struct LineCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction origin{};
  VectorFunction direction{};
};

template <>
struct KindOf<LineCoordinates> {
  static constexpr std::string_view name = "line";
  static constexpr auto members = &LineCoordinates::points;
  static constexpr auto fields = line_fields<LineCoordinates>;
  static constexpr int coordinates = 1;

  template <class T>
  struct Definition {
    TripleOf<T> origin, along;

    template <class Now>
    Definition(const LineCoordinates& given, const Now& now) : origin(now(given.origin)) {
      const TripleOf<T> direction = now(given.direction);
      along = direction / norm(direction);
    }

    TripleOf<T> place(const std::array<T, 1>& q, const T&, NoChart) const { return origin + q[0] * along; }
    std::array<T, 1> locate(const TripleOf<T>& r, const T&, NoChart) const { return {dot(along, r - origin)}; }
  };
};

}  // namespace tanor
