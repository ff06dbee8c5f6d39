#pragma once

/// \file
/// Descriptions of kinds of constraint, force, friction and coordinates. Each kind is one file of this folder;
/// <tanor/kinds.hpp> lists them. docs/contributing.md, "How to add a kind", has the steps.
///
/// The fields of a kind are plain data. Validation, the reader of scene files and the search for moving parts all loop
/// over them, so nothing else names the kind.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/export.hpp>
#include <tanor/jet.hpp>
#include <tanor/time_function.hpp>

namespace tanor {

/// Number of a point, 0 … num_points - 1.
using Index = std::int32_t;

/// One number for each constraint of a group: "initial" (the default, the value in the initial positions), one number
/// for all, or one for each. Numbers are constant or depend on time.
struct TANOR_API Parameter {
  Parameter() = default;
  Parameter(double constant) : constants{constant} {}                          // NOLINT
  Parameter(std::vector<double> each) : constants(std::move(each)) {}          // NOLINT
  Parameter(ScalarFunction function) : functions{std::move(function)} {}       // NOLINT
  Parameter(std::vector<ScalarFunction> each) : functions(std::move(each)) {}  // NOLINT

  bool is_initial() const { return constants.empty() && functions.empty(); }

  std::vector<double> constants{};          ///< size 1 (for all) or one for each
  std::vector<ScalarFunction> functions{};  ///< likewise; at most one of the two lists is filled
};

// ---- fields ----

/// A rule that a finite number must keep, and the complaint about a number that breaks it.
struct ValueRange {
  const char* (*complaint)(double);  ///< returns what is wrong with a number, or null
  const char* wanted = nullptr;      ///< what a scene file wants; if null, the reader takes any number

  static const ValueRange any, positive, not_negative, not_zero;
};

inline constexpr ValueRange ValueRange::any = {[](double) -> const char* { return nullptr; }};
inline constexpr ValueRange ValueRange::positive = {[](double x) { return x > 0.0 ? nullptr : "is not positive"; },
                                                    "a number > 0"};
inline constexpr ValueRange ValueRange::not_negative = {[](double x) { return x >= 0.0 ? nullptr : "is negative"; },
                                                        "a number >= 0"};
inline constexpr ValueRange ValueRange::not_zero = {[](double x) { return x != 0.0 ? nullptr : "must not be zero"; }};

/// Relation of a vector to the points that it is given for.
enum class FieldRole {
  Value,      ///< none of the following
  Place,      ///< the points move with the vector
  Center,     ///< the same; the points also stay at a distance from it that is a length of their neighbourhood
  Direction,  ///< it must not be zero; the points turn with it
};

/// The plain data of a field.
struct FieldData {
  const char* unit = "";
  ValueRange range = ValueRange::any;
  FieldRole role = FieldRole::Value;
  bool is_required = false;  ///< required in a scene file; else the field has the default of its struct
  bool is_constant = false;  ///< for a parameter: it must not depend on time
  bool is_each = false;      ///< for a list of numbers: one for all members, or one for each
  int point = 0;             ///< for a Center: which of a member's points belongs to it
};

/// A field of a group: its name in scene files, its address, and its rules.
template <class Group, class Value>
struct FieldOf {
  const char* name;
  Value Group::*value;
  FieldData data;

  constexpr FieldOf(const char* n, Value Group::*v, FieldData d = {}) : name(n), value(v), data(d) {}
};

// ---- constraints to one side ----

/// Side to which the members of a constraint with one equation may open: xi >= 0, such as points on a floor that does
/// not hold them down, or xi <= 0, such as ropes that may be slack.
enum class OneSide { AtLeast, AtMost };

/// The part of the speed of closing that an impact gives back.
inline constexpr ValueRange restitution_range = {
    [](double e) { return 0.0 <= e && e <= 1.0 ? nullptr : "is not in [0, 1]"; }, "a number in [0, 1]"};

/// The fields of a constraint that may act to one side: `side`, both if there is none, and Newton's `restitution`.
template <class Group>
inline constexpr std::tuple one_sided_fields{FieldOf("side", &Group::side),
                                             FieldOf("restitution", &Group::restitution, {.range = restitution_range})};

/// The field of constraints with a tension at which members break: events that take them out, "breaks_at of links".
template <class Group>
inline constexpr FieldOf strength_field{
    "breaks_at", &Group::breaks_at, {.unit = "N", .range = ValueRange::positive, .is_each = true}};

// ---- definitions ----

/// Three numbers of any scalar type, in which definitions are written.
template <class T>
struct TripleOf {
  T x, y, z;

  friend TripleOf operator+(const TripleOf& a, const TripleOf& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend TripleOf operator-(const TripleOf& a, const TripleOf& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend TripleOf operator*(const T& s, const TripleOf& a) { return {s * a.x, s * a.y, s * a.z}; }
  friend TripleOf operator/(const TripleOf& a, const T& s) { return {a.x / s, a.y / s, a.z / s}; }
};

template <class T>
T dot(const TripleOf<T>& a, const TripleOf<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
T norm(const TripleOf<T>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
template <class T>
TripleOf<T> cross(const TripleOf<T>& a, const TripleOf<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
TripleOf<T> triple_of(const Vector3& a) {
  return {T(a[0]), T(a[1]), T(a[2])};
}

/// Evaluates functions of time at t. A jet carries their derivatives in time; any other scalar type gets the value
/// alone.
template <class T>
struct ClockOf {
  double t;

  T operator()(const ScalarFunction& function) const {
    if constexpr (std::is_same_v<T, Jet<2>>)
      return function(t);
    else
      return T(function(t).value());
  }
  TripleOf<T> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

// ---- kinds ----

/// Description of a kind, specialised for each Group (a struct of groups: Rods, Planes, …). Every kind has
///
///     name        the name in scene files
///     members     the list of what the group holds: points, pairs, triples or tuples
///     fields      a std::tuple of FieldOf
///
/// A constraint also has
///
///     rows        number of equations of a member
///     parameter   the Parameter among the fields that gives each member a number, xi = measure - number; it may be
///                 left out
///     Definition<T>
///                 made from a group and a clock for one instant. xi(r, number, k) -> std::array<T, rows> is the
///                 constraint, where r[p] is the position of the p-th point of member k. measure(r, k) gives an
///                 "initial" number its value at the start.
///
/// It may have `distinct`, the reason why the points of a member must differ; `parameter_range`, a further rule for its
/// numbers; complaint(group, now, r, k), which returns what is wrong with member k at the start, or null; and
/// leverage(group, t, size), the distance (m) that a point moves when the parameter changes by 1.
///
/// Coordinates of single points also have
///
///     coordinates   number of coordinates q of a point, 1 to 3
///     parameter     as above
///     Definition<T>
///                   made from a group and a clock for one instant. place(q, number, chart) is the position of the
///                   point with the coordinates q; locate(r, number, chart) is the inverse, the q of a position r.
///     Chart         the point at which the coordinates are centred; charts compare with ==. It may be left out. If
///                   there is one, Definition<double>::chart_at(r) returns the chart to use at the position r.
///
/// Coordinates that tie points to one another have tied_points(group), num_coordinates(group) and a Definition of their
/// own. Their family is written by hand (src/core/evaluate/coordinate_families.hpp).
///
/// A law of friction acts against the sliding with a magnitude, N, and has one of
///
///     magnitude(law, speed)
///                 which depends on the speed of sliding alone;
///     magnitude(law, speed, normal)
///                 which also reads multipliers: `normal` is |N|, of a scalar type, so that Forward gives the
///                 derivative. N is the force of the guides, or the whole reaction of the point if
///                 reads_full_reaction(law);
///     forces(law, batch)
///                 which have any direction and read the multipliers of the guides one by one, of many points at once
///                 (FrictionBatch); such a law also has num_multipliers(law) and is_thread_safe(law).
///
/// It may have `is_proportional`, which says that the magnitude is mu(speed) |N|, as Coulomb's: modes of stick and slip
/// are then counted and (43) runs on a fast kernel; sticks(law) and static_coefficient(law), for a proportional law
/// that holds points at rest up to that times |N|; is_without_effect(law); check(law, check), for rules beyond the
/// ranges of fields; and variant(law), which reports add to its name.
template <class Group>
struct KindOf;

/// True if the members of a kind are single points.
template <class Group>
constexpr bool has_single_points = std::is_same_v<decltype(KindOf<Group>::members), std::vector<Index> Group::*const>;

/// The chart of coordinates whose chart is the same everywhere.
struct NoChart {};

namespace detail {

template <class Group>
struct ChartType {
  using Type = NoChart;
};
template <class Group>
requires requires {
  typename KindOf<Group>::Chart;
}
struct ChartType<Group> {
  using Type = typename KindOf<Group>::Chart;
};

}  // namespace detail

/// The chart of a group: the point at which the numbers of a member are centred.
template <class Group>
using ChartOf = typename detail::ChartType<Group>::Type;

/// The coordinates q of a point, for coordinates of single points.
template <class Group, class T>
using NumbersOf = std::array<T, static_cast<std::size_t>(KindOf<Group>::coordinates)>;

/// True if a law of friction gives a force in any direction instead of a magnitude against the sliding.
template <class Law>
concept HasForceOfFriction = requires {
  &KindOf<Law>::forces;
};

/// True if the magnitude of a law depends on the normal force.
template <class Law>
concept ReadsNormalForce = requires(const Law& law) {
  KindOf<Law>::magnitude(law, 0.0, 0.0);
};

/// True if the magnitude of a law is mu(speed) |N|.
template <class Law>
concept IsProportionalFriction = ReadsNormalForce<Law> && requires {
  requires KindOf<Law>::is_proportional;
};

/// Returns the name of the list of members in scene files.
template <class Group>
constexpr const char* list_name() {
  if constexpr (requires { KindOf<Group>::list; }) return KindOf<Group>::list;
  using List = std::remove_cvref_t<decltype(std::declval<Group>().*KindOf<Group>::members)>;
  if constexpr (std::is_same_v<List, std::vector<std::array<Index, 2>>>) return "pairs";
  if constexpr (std::is_same_v<List, std::vector<std::array<Index, 3>>>) return "triples";
  if constexpr (std::is_same_v<List, std::vector<std::array<Index, 4>>>) return "quadruples";
  if constexpr (std::is_same_v<List, std::vector<std::vector<Index>>>) return "tuples";
  return "points";
}

/// Calls visit(field) for each field of a kind, in the order of its file.
template <class Group, class Visit>
void for_each_field(const Visit& visit) {
  std::apply([&](const auto&... field) { (visit(field), ...); }, KindOf<Group>::fields);
}

}  // namespace tanor
