#pragma once

#include <string>
#include <vector>

#include <tanor/error.hpp>
#include <tanor/export.hpp>
#include <tanor/kinds.hpp>

/// What is simulated: points, supports, constraints, forces. Constant during a run; the state (t, r, v) moves.
/// The structs mirror the scene file: one struct per entry of its lists, in the same order, with the same names; each
/// kind of constraint, force, friction and coordinates has its own file in tanor/kinds.
namespace tanor {

/// Points whose motion is prescribed: r = initial position + displacement(t). They are no unknowns.
struct Support {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction displacement{};  ///< m; default: fixed
};

/// A point, as System::add_point and add_support name it.
struct Point {
  Index index = -1;
};

/// A point that moves starts with these.
struct PointStart {
  Vector3 position{};  ///< m
  Vector3 velocity{};  ///< m/s
  double mass = 1.0;   ///< kg, > 0
};

/// One member of a group of constraints: rods[17].
struct Member {
  std::size_t group = 0;   ///< in System::constraints
  std::size_t number = 0;  ///< in the group
};

struct System;

/// Rods that are joined one by one. It refers to its System, which must outlive it and must not be moved meanwhile.
class TANOR_API RodGroup {
 public:
  /// A rod as long as its points are apart at the start; returns rods[size() - 1].
  Member join(Point i, Point j);
  /// The group's members in the order in which they were joined. Throws InputError where there is no such member.
  Member operator[](std::size_t number) const;
  std::size_t size() const;

 private:
  friend struct System;
  RodGroup(System& system, std::size_t group) : system_(&system), group_(group) {}

  System* system_;
  std::size_t group_;
};

/// The arrays are all there is; the functions below them append to these for those who build a system point by point.
struct TANOR_API System {
  std::string name = "system";
  std::vector<double> positions{};   ///< 3n, point by point, m
  std::vector<double> velocities{};  ///< 3n, m/s; empty: at rest
  std::vector<double> masses{};      ///< n, kg, > 0 (of supports: ignored)
  std::vector<Support> supports{};
  std::vector<Constraint> constraints{};
  std::vector<Force> forces{};
  std::vector<Friction> friction{};
  std::vector<Coordinates> coordinates{};  ///< empty: the constraints alone say what can move

  std::size_t num_points() const { return masses.size(); }

  Point add_point(const PointStart& start);
  /// A point that stays where it is, or moves by displacement(t), m.
  Point add_support(const Vector3& position, VectorFunction displacement = {}, std::string support_name = {});
  RodGroup add_rods(std::string group_name = {});
  /// m/s^2, on every point.
  void add_gravity(const Vector3& acceleration);
};

/// Number of scalar equations d of all constraints; group by group, member by member, a member's rows side by side.
TANOR_API std::size_t num_equations(const System& system);

/// Number of contacts of an entry of `friction`: moving points on its guides that it can act on (none without effect).
TANOR_API std::size_t num_contacts(const System& system, std::size_t friction);

/// The user's name of a row, e.g. "rods[17]"; "wire[4].1" for the second row of a member with several.
TANOR_API std::string equation_name(const System& system, std::size_t row);

/// Name of an entry of `constraints`, `forces`, `friction` or `coordinates`: its own, or `<kind><index>`.
TANOR_API std::string constraint_name(const System& system, std::size_t group);
TANOR_API std::string force_name(const System& system, std::size_t index);
TANOR_API std::string friction_name(const System& system, std::size_t index);
TANOR_API std::string coordinates_name(const System& system, std::size_t index);

/// Kind of a constraint or force as the scene file spells it: "rod", "plane", …
TANOR_API std::string_view kind_name(const Constraint& constraint);
TANOR_API std::string_view kind_name(const Force& force);
TANOR_API std::string_view kind_name(const Friction& friction);
TANOR_API std::string_view kind_name(const Coordinates& coordinates);

/// Checks every rule of docs/scene-format.md: sizes, indices, finite numbers (and at most 1e100, so that squares are
/// finite too), positive masses and lengths, nonzero normals, pairs of distinct points, no straight angles, names used
/// once, friction at guides. What depends on time is checked at t, the start. Throws InputError with a JSON pointer.
TANOR_API void validate(const System& system, double t = 0.0);

}  // namespace tanor
