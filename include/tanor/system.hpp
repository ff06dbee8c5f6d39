#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tanor/cell.hpp>
#include <tanor/error.hpp>
#include <tanor/export.hpp>
#include <tanor/kinds.hpp>
#include <tanor/units.hpp>

/// The simulated system: points, supports, constraints and forces. A System is constant during a run, while the state
/// (t, r, v) changes. The structs mirror the scene file, with one struct for each entry of its lists, in the same order
/// and with the same names. Each kind of constraint, force, friction and coordinates has its own file in tanor/kinds.
namespace tanor {

/// Points whose motion is prescribed, r = initial position + displacement(t). They are no unknowns.
struct Support {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction displacement{};  ///< m; fixed by default
};

/// The number of a point, as System::add_point and add_support return it.
struct Point {
  Index index = -1;
};

/// The start of a moving point.
struct PointStart {
  Vector3 position{};  ///< m
  Vector3 velocity{};  ///< m/s
  double mass = 1.0;   ///< kg, > 0
};

/// One member of a group of constraints, such as rods[17].
struct Member {
  std::size_t group = 0;   ///< in System::constraints
  std::size_t number = 0;  ///< in the group
};

struct System;

/// A group of rods that are joined one by one. It refers to its System, which must outlive it and must not be moved.
class TANOR_API RodGroup {
 public:
  /// Joins two points by a rod that is as long as they are apart at the start; returns rods[size() - 1].
  Member join(Point i, Point j);
  /// Returns a member, in the order in which they were joined. Throws InputError if there is no such member.
  Member operator[](std::size_t number) const;
  std::size_t size() const;

 private:
  friend struct System;
  RodGroup(System& system, std::size_t group) : system_(&system), group_(group) {}

  System* system_;
  std::size_t group_;
};

/// A system as arrays, which are all there is. The functions append to them, for users who build a system point by
/// point.
struct TANOR_API System {
  std::string name = "system";
  std::vector<double> positions{};   ///< 3n, point by point, m
  std::vector<double> velocities{};  ///< 3n, m/s; empty at rest
  std::vector<double> masses{};      ///< n, kg, > 0; ignored for supports
  std::vector<Support> supports{};
  std::vector<Constraint> constraints{};
  std::vector<Force> forces{};
  std::vector<Friction> friction{};
  std::vector<Coordinates> coordinates{};  ///< empty if the constraints alone say what can move
  std::optional<Cell> cell{};              ///< of a periodic sample, for results: forces and rods have their own images
  Units units{};                           ///< letters beside results

  std::size_t num_points() const { return masses.size(); }

  Point add_point(const PointStart& start);
  /// Adds a point that stays where it is, or moves by displacement(t), m.
  Point add_support(const Vector3& position, VectorFunction displacement = {}, std::string support_name = {});
  RodGroup add_rods(std::string group_name = {});
  /// Adds a gravity on every point, m/s^2.
  void add_gravity(const Vector3& acceleration);
};

/// Returns the number of scalar equations d of all constraints: group by group, member by member, a member's rows side
/// by side.
TANOR_API std::size_t num_equations(const System& system);

/// Returns the number of contacts of an entry of `friction`: moving points on its guides that it can act on (none if it
/// has no effect).
TANOR_API std::size_t num_contacts(const System& system, std::size_t friction);

/// Returns the user's name of a row, e.g. "rods[17]", or "wire[4].1" for the second row of a member with several.
TANOR_API std::string equation_name(const System& system, std::size_t row);

/// Returns the name of an entry of `constraints`, `forces`, `friction` or `coordinates`: its own, or `<kind><index>`.
TANOR_API std::string constraint_name(const System& system, std::size_t group);
TANOR_API std::string force_name(const System& system, std::size_t index);
TANOR_API std::string friction_name(const System& system, std::size_t index);
TANOR_API std::string coordinates_name(const System& system, std::size_t index);

/// Returns the kind of a constraint, force, friction or coordinates as the scene file spells it: "rod", "plane", …
TANOR_API std::string_view kind_name(const Constraint& constraint);
TANOR_API std::string_view kind_name(const Force& force);
TANOR_API std::string_view kind_name(const Friction& friction);
TANOR_API std::string_view kind_name(const Coordinates& coordinates);

/// Checks every rule of docs/scene-format.md: sizes, indices, finite numbers (and at most 1e100, so that squares are
/// finite too), positive masses and lengths, nonzero normals, pairs of distinct points, no straight angles, unique
/// names, friction at guides. What depends on time is checked at t, the start. Throws InputError with a JSON pointer.
TANOR_API void validate(const System& system, double t = 0.0);

}  // namespace tanor
