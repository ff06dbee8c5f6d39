#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <tanor/error.hpp>
#include <tanor/export.hpp>
#include <tanor/kernel.hpp>
#include <tanor/time_function.hpp>

/// What is simulated: points, supports, constraints, forces. Constant during a run; the state (t, r, v) moves.
/// The structs mirror the scene file: one struct per entry of its lists, in the same order, with the same names.
namespace tanor {

/// Number of a point, 0 … num_points - 1.
using Index = std::int32_t;

/// One number for each constraint of a group: "initial" (the value that the initial positions have; the default),
/// one for all, or one each; constant or depending on time.
struct TANOR_API Parameter {
  Parameter() = default;
  Parameter(double constant) : constants{constant} {}                          // NOLINT
  Parameter(std::vector<double> each) : constants(std::move(each)) {}          // NOLINT
  Parameter(ScalarFunction function) : functions{std::move(function)} {}       // NOLINT
  Parameter(std::vector<ScalarFunction> each) : functions(std::move(each)) {}  // NOLINT

  bool is_initial() const { return constants.empty() && functions.empty(); }

  std::vector<double> constants{};          ///< size 1 (for all) or one each
  std::vector<ScalarFunction> functions{};  ///< likewise; at most one of the two lists is filled
};

/// Points whose motion is prescribed: r = initial position + displacement(t). They are no unknowns.
struct Support {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction displacement{};  ///< m; default: fixed
};

// ---- constraints xi(r, t) = 0; built-in ones are lengths (m) with unit gradients, so multipliers are forces (N) ----

/// |r_j - r_i + offset| - length; tension = -lambda.
struct Rods {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  Parameter length{};              ///< m, > 0
  std::vector<Vector3> offsets{};  ///< m; constant image shift of r_j - r_i; empty or one each
};

/// (normal.r - offset)/|normal|
struct Planes {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction normal{};
  Parameter offset = 0.0;
};

/// |r - center| - radius
struct Spheres {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  Parameter radius{};
};

/// Two distances, along two unit vectors orthogonal to the direction d (two rows a point), which are a function of d
/// alone: e1 is the part orthogonal to d of the coordinate axis that d is farthest from (of axes as far the first), e2
/// = d x e1. Where another axis becomes the farthest they jump by a turn around d; K lambda does not.
struct Lines {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction origin{};
  VectorFunction direction{};
};

/// Distance from the circle's plane; distance from its axis - radius (two rows a point).
struct Circles {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  VectorFunction normal{};
  Parameter radius{};
};

/// cos(angle at the middle point of i, j, k) - cosine; its multiplier is a torque-like N m.
struct Angles {
  std::string name{};
  std::vector<std::array<Index, 3>> triples{};
  Parameter cosine{};
};

/// |r_i - a| + ratio |r_j - b| - length
struct Pulleys {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  Vector3 a{}, b{};
  Parameter length{};
  double ratio = 1.0;
};

/// sum over the tuple of c.r - value; the same coefficients for every tuple.
struct Linears {
  std::string name{};
  std::vector<std::vector<Index>> tuples{};
  std::vector<Vector3> coefficients{};  ///< one for each point of a tuple
  Parameter value = 0.0;
};

/// A user's own function of the points of a tuple, from user_kernel.hpp or formula_constraint; supports may take part.
struct UserConstraints {
  std::string name{};
  std::vector<std::vector<Index>> tuples{};
  ConstraintKernel kernel{};
};

using Constraint = std::variant<Rods, Planes, Spheres, Lines, Circles, Angles, Pulleys, Linears, UserConstraints>;

// ---- active forces f(r, v, t), N ----

struct Gravity {
  std::string name{};
  Vector3 acceleration{};  ///< m/s^2
};

struct ConstantForce {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction force{};  ///< N on each point
};

/// On r_i: (k (L - rest) + c dL/dt) along (r_j - r_i)/L, and the opposite on r_j; L = |r_j - r_i|.
struct Springs {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  double stiffness = 0.0;   ///< N/m, >= 0
  double damping = 0.0;     ///< N s/m, >= 0
  Parameter rest_length{};  ///< m, >= 0, constant
};

/// -c1 v - c2 |v| v
struct Drag {
  std::string name{};
  std::vector<Index> points{};
  double linear = 0.0;     ///< c1, N s/m, >= 0
  double quadratic = 0.0;  ///< c2, N s^2/m^2, >= 0
};

/// A user's own f(r, v, t) on each point, from formula_force. It has no potential: all that it does is work.
struct FormulaForce {
  std::string name{};
  std::vector<Index> points{};
  ForceKernel kernel{};
};

enum class PairLaw {
  Wca,  ///< Lennard-Jones cut at its minimum: repulsion alone
  Lj,   ///< Lennard-Jones, cut and shifted
  Log,  ///< potential -strength ln r, without a cutoff
};

/// Between any two of the points at a distance r, along the line that joins them.
///
/// Wca, Lj: potential 4 epsilon ((sigma/r)^12 - (sigma/r)^6) - its value at the cutoff, 0 beyond that; with a box the
/// nearest image of the other point counts, wherever in space both are. Log: strength (r_i - r_j)/r^2 on point i.
/// Supports take part; what two of them do to each other is in the load that they carry, but in no energy and no work.
struct PairForces {
  std::string name{};
  std::vector<Index> points{};  ///< empty: all
  PairLaw law = PairLaw::Wca;
  double epsilon = 1.0;            ///< J, > 0 (Wca, Lj)
  double sigma = 1.0;              ///< m, > 0 (Wca, Lj)
  std::optional<double> cutoff{};  ///< m, > 0 (Lj; default 2.5 sigma); that of Wca is 2^(1/6) sigma
  double strength = 1.0;           ///< N m; negative: attraction (Log)
  Vector3 box{};                   ///< m, edges of the periodic box (Wca, Lj); 0: not periodic along this axis
  bool exclude_rods = false;       ///< points that a rod joins leave each other alone
};

using Force = std::variant<Gravity, ConstantForce, Springs, Drag, FormulaForce, PairForces>;

// ---- friction tau at points that constraints guide, N ----
//
// `at` names the guides: planes, spheres, lines, circles or a user's constraints of single points; where several guide
// one point they form one wire (or one surface) together. v_rel is the velocity of the point along its guide, relative
// to it: the guide's own motion across itself follows from xi_t, `velocity` says how it moves along itself.

/// -mu |N| v_rel/|v_rel|, N the force of the guides on the point (17), (41).
struct Coulomb {
  enum class Reaction {
    Guide,  ///< of the named guides alone: a rod that pulls at the bead takes no part
    Full    ///< eta_i of the point, whatever makes it: the paper's literal law
  };
  std::string name{};
  std::vector<std::string> at{};
  double coefficient = 0.0;                    ///< mu, >= 0
  std::optional<double> static_coefficient{};  ///< mu_s >= mu; default: mu
  /// m/s, > 0: v_rel/sqrt(v_rel^2 + v0^2) in place of v_rel/|v_rel|, which creeps. Default: exact, with stick.
  std::optional<double> regularisation{};
  VectorFunction velocity{};  ///< m/s
  Reaction reaction = Reaction::Guide;
};

/// -c v_rel
struct Viscous {
  std::string name{};
  std::vector<std::string> at{};
  double coefficient = 0.0;  ///< c, N s/m, >= 0
  VectorFunction velocity{};
};

/// A user's own law of position, sliding velocity, time and the multipliers of the guides at the point, from
/// make_friction_kernel.
struct UserFriction {
  std::string name{};
  std::vector<std::string> at{};
  FrictionKernel kernel{};
  VectorFunction velocity{};
};

using Friction = std::variant<Coulomb, Viscous, UserFriction>;

// ---- generalized coordinates r = r(q, t): the tangent form; together they cover every point that moves once ----

/// q = r, three a point.
struct FreeCoordinates {
  std::string name{};
  std::vector<Index> points{};
};

/// r = origin + q direction/|direction|, one a point, m.
struct LineCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction origin{};
  VectorFunction direction{};
};

/// Two lengths along two unit vectors of the plane normal.r = offset, m.
struct PlaneCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction normal{};
  Parameter offset = 0.0;
};

/// The angle around the circle's axis n, rad, from e1 towards n x e1; e1 is the part orthogonal to n of the coordinate
/// axis that n is farthest from (and does not turn into) at the start.
struct CircleCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  VectorFunction normal{};
  Parameter radius{};
};

/// Two numbers of a stereographic chart around the present place, rad near there: no poles.
struct SphereCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  Parameter radius{};
};

/// A chain of rods on a support, link by link: the direction of each in a stereographic chart (two numbers), or, in a
/// given plane with unit normal n, its angle, rad, from e1 = n x a (to unit length) towards n x e1; a is the coordinate
/// axis that n is farthest from.
struct ChainAngles {
  std::string name{};
  std::vector<Index> points{};  ///< along the chain, from the anchor on
  Index anchor = 0;             ///< a support
  Parameter length{};           ///< m, > 0, one a link
  Vector3 normal{};             ///< of the plane; 0: directions in space
};

/// Points that keep their distances: displacement of their centre of mass (m) and a rotation around it (rad near the
/// present one, Gibbs vector times 2: no poles). At least three points that are not on one line.
struct RigidBody {
  std::string name{};
  std::vector<Index> points{};
};

/// A user's own map of some coordinates to the points of a tuple, from user_kernel.hpp or formula_coordinates.
struct UserCoordinates {
  std::string name{};
  std::vector<std::vector<Index>> tuples{};
  CoordinateKernel kernel{};
  std::vector<double> q{};      ///< [tuples][s] at the start; they decide where the points are
  std::vector<double> q_dot{};  ///< likewise; empty: at rest
};

using Coordinates = std::variant<FreeCoordinates, LineCoordinates, PlaneCoordinates, CircleCoordinates,
                                 SphereCoordinates, ChainAngles, RigidBody, UserCoordinates>;

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

/// Checks every rule of the contract: sizes, indices, finite numbers (and at most 1e100, so that squares are finite
/// too), positive masses and lengths, nonzero normals, pairs of distinct points, no straight angles, names used once,
/// friction at guides. What depends on time is checked at t, the start. Throws InputError with a JSON pointer.
TANOR_API void validate(const System& system, double t = 0.0);

}  // namespace tanor
