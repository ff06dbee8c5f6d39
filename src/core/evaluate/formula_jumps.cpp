#include <algorithm>
#include <cmath>
#include <limits>

#include "evaluate/formula_features.hpp"
#include "evaluate/locate_jump.hpp"

/// \file Places of a step where what a formula causes jumps: by abs, min and max, or at the cut of atan2.
namespace tanor::detail {

void FormulaFeatures::load_variables(const PointPath& path, std::size_t member, double s, double* to) const {
  const std::span<const Index> own = numbers(member);
  const bool has_rates = variables_ == Variables::OfPointsAndTheirRates;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const PointPath::Number at = path.number(own[i], s, variables_ == Variables::OfMechanics);
    to[i] = at.x;
    // The cubic rounds rates also where it begins, which may be on the other side of a jump.
    if (has_rates) to[own.size() + i] = s == 0.0 ? path.velocities[0][static_cast<std::size_t>(own[i])] : at.rate;
  }
  const std::span<const double> constant = constants(member);
  std::copy(constant.begin(), constant.end(), to + (has_rates ? 2 : 1) * own.size());
  to[narrowness_.num_variables() - 1] = path.t + s * path.h;
}

void FormulaFeatures::measure_turns(const PointPath& path, std::size_t member, double s, double* values) const {
  thread_local std::vector<double> variables;
  variables.resize(narrowness_.num_variables());
  load_variables(path, member, s, variables.data());
  narrowness_.measure_turns(variables.data(), values);
}

/// Returns how far the number of a turn is uncertain by rounding, from changes of the variables by rounding of the
/// largest values that they have in the step.
double FormulaFeatures::uncertainty(const PointPath& path, std::size_t member, std::size_t turn, double s) const {
  constexpr double some_roundings = 32.0;
  const std::size_t count = narrowness_.num_variables();
  std::vector<double> variables(count), sizes(count, 0.0), values(narrowness_.num_turns());
  for (const double place : {0.0, 1.0, s}) {
    load_variables(path, member, place, variables.data());
    for (std::size_t i = 0; i < count; ++i) sizes[i] = std::max(sizes[i], std::abs(variables[i]));
  }
  narrowness_.measure_turns(variables.data(), values.data());
  const double value = values[turn];
  double sum = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double kept = variables[i];
    variables[i] += some_roundings * eps * sizes[i];
    narrowness_.measure_turns(variables.data(), values.data());
    sum += std::abs(values[turn] - value);
    variables[i] = kept;
  }
  return std::max(sum, std::numeric_limits<double>::min());
}

/// Returns true if what the formula causes differs on both sides of a place so far that it counts in the step, or by so
/// much of itself that a motion may stay at the place, where steps get too short for anything to count. A motion that
/// the accelerations a and -a drive to the place from both sides, and that returns to it after `idle`, was a idle^2/8
/// away. The path is magnified as where the place was found, since its own cubics miss the place by more than rounding.
bool FormulaFeatures::jumps(PointPath* path, std::size_t member, PointPath::Jump* at) const {
  constexpr double counts = 0.1, much = 1e-3;  // of a tolerance; of the larger one
  constexpr double reach = 1e-4;               // of the step
  const double begin = std::max(0.0, at->before - reach), end = std::min(1.0, at->after + reach);
  const PointPath* const part = path->magnify(begin, end);
  if (part == nullptr) return false;
  std::vector<double> before(num_accelerations()), after(before.size());
  accelerate(*part, member, (at->before - begin) / (end - begin), before.data());
  accelerate(*part, member, std::min((at->after - begin) / (end - begin), 1.0), after.data());
  const double larger = std::max(norm_of(before), norm_of(after));
  for (std::size_t i = 0; i < before.size(); ++i) after[i] -= before[i];
  const double jump = norm_of(after);
  const Allowed allowed = allow(*path, member);
  at->idle = std::sqrt(16.0 * allowed.r / jump);
  return jump > much * larger || jump * path->h > counts * allowed.v;
}

/// Finds the first place between two fractions, near to each other, where one of the numbers of turns changes its sign
/// and the formula jumps.
PointPath::Jump FormulaFeatures::find_jump(PointPath* path, std::size_t member, double low, double high) const {
  const std::size_t count = narrowness_.num_turns();
  std::vector<double> at_low(count), at_high(count);
  measure_turns(*path, member, low, at_low.data());
  measure_turns(*path, member, high, at_high.data());
  PointPath::Jump first;
  for (std::size_t turn = 0; turn < count; ++turn) {
    if (std::signbit(at_low[turn]) == std::signbit(at_high[turn])) continue;
    const double sign = std::signbit(at_low[turn]) ? -1.0 : 1.0;
    const auto side = [&](const PointPath& on, double s) {
      std::vector<double> values(count);
      measure_turns(on, member, s, values.data());
      return sign * values[turn];
    };
    const double margin = uncertainty(*path, member, turn, high);
    PointPath::Jump found = locate_jump(path, low, at_low[turn] != 0.0 ? high : low, margin, side);
    if (found.exists() && jumps(path, member, &found)) first.include(found);
  }
  return first;
}

void FormulaFeatures::note_jumps(PointPath* path, std::size_t member) const {
  thread_local std::vector<Part> parts;
  (void)divide(*path, member, &parts);
  constexpr int pieces = 2;
  for (const auto& [begin, end] : parts) {
    if (begin > path->jump.after) return;
    for (int k = 0; k < pieces; ++k) {
      const double length = (end - begin) / pieces;
      PointPath::Jump found = find_jump(path, member, begin + k * length, begin + (k + 1) * length);
      if (!found.exists()) continue;
      found.force = &name;
      return path->jump.include(found);
    }
  }
}

}  // namespace tanor::detail
