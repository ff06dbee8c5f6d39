#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

/// Problems whose answers are known in closed form or to published digits. `tanor selftest` solves them.
namespace tanor::cli {

/// The difference of an answer from what is known, or the reason why there is no answer.
struct Finding {
  double error = 0.0;  ///< largest difference over the largest known number
  Outcome outcome{};
};

struct KnownProblem {
  std::string name, known, method;
  double promised = 0.0;  ///< about half a digit less than found, for other compilers' rounding
  std::function<Finding()> solve;
};

/// Pendulums, chains and moving mechanisms.
std::vector<KnownProblem> list_known_motions();
std::vector<KnownProblem> list_known_mechanisms();
/// Points that slide, stick and jam.
std::vector<KnownProblem> list_known_friction();
/// Forces at one instant.
std::vector<KnownProblem> list_known_forces();

// ---- what they share ----

inline constexpr double g = 9.81;

/// Adds a point and returns its number.
Index add_point(const Vector3& place, const Vector3& velocity, double mass, System* system);

/// Returns options with tolerances near rounding.
MotionOptions tightly(Method method);

double relative_error(std::span<const double> found, std::span<const double> known);

/// Advances to t_end and compares positions, from the given point on.
Finding follow(const System& system, const MotionOptions& options, double t_end, Index first_point,
               const std::vector<double>& known);

/// The accelerations and multipliers at the start of a problem.
struct Answer {
  std::vector<double> accelerations, multipliers;
  Outcome outcome{};
};

Answer solve_start(const System& system);

}  // namespace tanor::cli
