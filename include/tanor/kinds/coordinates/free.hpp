#pragma once

#include <array>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Free points: q = r, three coordinates for each point.
struct FreeCoordinates {
  std::string name{};
  std::vector<Index> points{};
};

template <>
struct KindOf<FreeCoordinates> {
  static constexpr std::string_view name = "free";
  static constexpr auto members = &FreeCoordinates::points;
  static constexpr std::tuple<> fields{};
  static constexpr int coordinates = 3;

  template <class T>
  struct Definition {
    template <class Now>
    Definition(const FreeCoordinates&, const Now&) {}

    TripleOf<T> place(const std::array<T, 3>& q, const T&, NoChart) const { return {q[0], q[1], q[2]}; }
    std::array<T, 3> locate(const TripleOf<T>& r, const T&, NoChart) const { return {r.x, r.y, r.z}; }
  };
};

}  // namespace tanor
