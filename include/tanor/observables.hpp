#pragma once

/// \file
/// Observables: named numbers and vectors of a motion that belong to things of its system, such as the tension of a rod
/// or the torque of a motor. docs/observables.md has the language in which they are written.

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor {

/// A request to observe something.
struct Observable {
  std::string name{};       ///< in results; the text if it is empty
  std::string text{};       ///< such as "max tension(links)", "moment(crank, z)" or "load(hook).z/9.81"
  Constants parameters{};   ///< names of numbers that the text may use
  bool every_step = false;  ///< extremes of all steps; otherwise of the instants at which `observe` is called
  std::string unit{};       ///< of a formula, or where the system has no letters; else those of the quantity
};

/// The smallest or the largest number so far.
struct Extreme {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN before the first instant
  double time = std::numeric_limits<double>::quiet_NaN();   ///< s
  std::string member{};                                     ///< whose number it is; empty if there is only one
};

/// An observable with its numbers at the last instant: [members x parts], member by member.
struct Observed {
  std::string name{}, text{};
  std::string unit{};                ///< empty for a plain number, or if it is not known
  Dimension dimension{};             ///< of a quantity; that of a formula is not known
  std::vector<std::string> members;  ///< names, such as "links[3]"; empty for one thing alone
  std::vector<std::string> parts;    ///< "x", "y", "z" and the like; empty for a number
  std::vector<double> values;
  std::string unknown{};  ///< why there are NaN among them, where that is known: "not unique", "broken at t = 2 s"
  std::string member{};   ///< whose value `max` or `min` took; else empty
  std::vector<Extreme> least, largest;  ///< [parts], or one
};

/// Throws InputError, with the column, if a text cannot be read for a system.
TANOR_API void check_observable(const System& system, const Observable& observable);

/// Returns the names of the columns in which the numbers stand in tables: "torque", "load(hook).x", "links[3]".
TANOR_API std::vector<std::string> column_names(const Observed& observed);

/// Returns what is observed where nothing is asked for: the largest and the smallest tension of each group of rods, the
/// largest part of `breaks_at` that it reaches, the load of each entry of supports and, with a periodic cell,
/// temperature and pressure.
TANOR_API std::vector<Observable> default_observables(const System& system);

/// Returns the tensions of all members of each group of rods, ropes, pulleys, springs and bonds, with its name, which
/// must be that of no other one.
TANOR_API std::vector<Observable> tensions_of_groups(const System& system);

/// Evaluates observables at one state, such as a state of rest, with the friction there (3n, N; empty without
/// friction). Throws InputError if a text cannot be read.
TANOR_API std::vector<Observed> observe(const System& system, std::span<const Observable> wanted, const Solution& at,
                                        std::span<const double> friction = {});

}  // namespace tanor
