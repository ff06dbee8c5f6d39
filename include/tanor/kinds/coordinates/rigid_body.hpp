#pragma once

#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Points that keep their distances: displacement of their centre of mass (m) and a rotation around it (rad near the
/// present one, Gibbs vector times 2: no poles). At least three points that are not on one line.
struct RigidBody {
  std::string name{};
  std::vector<Index> points{};
};

template <>
struct KindOf<RigidBody> {
  static constexpr std::string_view name = "rigid_body";
  static constexpr auto members = &RigidBody::points;
  static constexpr std::tuple<> fields{};
  /// Points that the coordinates tie to one another.
  static std::vector<Index> tied_points(const RigidBody& body) { return body.points; }
  static std::size_t num_coordinates(const RigidBody&) { return 6; }
};

}  // namespace tanor
