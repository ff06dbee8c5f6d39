#pragma once

#include <array>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Points that keep their distances. Their coordinates are the position of their centre of mass (m) and a rotation
/// around it, twice the Gibbs vector (rad near the present rotation), which has no poles. A body has at least three
/// points that are not on one line.
struct RigidBody {
  std::string name{};
  std::vector<Index> points{};
};

template <>
struct KindOf<RigidBody> {
  static constexpr std::string_view name = "rigid_body";
  static constexpr auto members = &RigidBody::points;
  static constexpr std::tuple<> fields{};
  /// The rotation R_c at which the last three numbers are 0, a unit quaternion w, x, y, z.
  using Chart = std::array<double, 4>;

  template <class T>
  struct Definition {
    template <class Now>
    Definition(const RigidBody&, const Now&) {}

    /// Returns c + R(theta) R_c arm with q = (c, theta). With Gibbs' vector g = theta/2 and a = R_c arm,
    /// R a = a + 2/(1 + g^2) (g x a + g x (g x a)). `arm` points from the centre of mass to a point, in the frame of
    /// the body.
    TripleOf<T> place(const std::array<T, 6>& q, const Vector3& arm, const Chart& centre) const {
      const TripleOf<double> axis{centre[1], centre[2], centre[3]}, start = triple_of<double>(arm);
      const TripleOf<double> turned = start + 2.0 * (centre[0] * cross(axis, start) + cross(axis, cross(axis, start)));
      const TripleOf<T> a{T(turned.x), T(turned.y), T(turned.z)}, g{0.5 * q[3], 0.5 * q[4], 0.5 * q[5]};
      const TripleOf<T> across = cross(g, a);
      return TripleOf<T>{q[0], q[1], q[2]} + a + (2.0 / (1.0 + dot(g, g))) * (across + cross(g, across));
    }
  };

  /// Returns the points that the coordinates tie to one another.
  static std::vector<Index> tied_points(const RigidBody& body) { return body.points; }
  static std::size_t num_coordinates(const RigidBody&) { return 6; }
};

}  // namespace tanor
