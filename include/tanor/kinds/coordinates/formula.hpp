#pragma once

#include <string>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/kinds/kind.hpp>

namespace tanor {

/// A user's own map of some coordinates to the points of a tuple, from user_kernel.hpp or formula_coordinates.
struct UserCoordinates {
  std::string name{};
  std::vector<std::vector<Index>> tuples{};
  CoordinateKernel kernel{};
  std::vector<double> q{};      ///< [tuples][s] at the start; they define the positions of the points
  std::vector<double> q_dot{};  ///< likewise; empty at rest
};

template <>
struct KindOf<UserCoordinates> {
  static constexpr std::string_view name = "formula";
  static constexpr auto members = &UserCoordinates::tuples;
  static constexpr const char* list = "points";
  static constexpr std::tuple<> fields{};
  static std::size_t num_coordinates(const UserCoordinates& group) {
    return static_cast<std::size_t>(group.kernel.num_coordinates) * group.tuples.size();
  }
};

}  // namespace tanor
