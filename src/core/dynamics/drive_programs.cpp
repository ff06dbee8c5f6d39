#include <algorithm>
#include <cmath>

#include "dynamics/drives.hpp"

/// \file Evaluates formulas of state and time as functions of time, at the state where a step begins.
namespace tanor::detail {

/// Loads all variables but the time.
void Drives::load_state(const Program& each, const Place& place, SeriesLane* lanes) const {
  const SeriesProgram& program = each.program;
  const std::size_t num_coordinates = 3 * each.points.size();
  for (std::size_t i = 0; i + 1 < program.num_variables(); ++i) {
    double value = 0.0;
    if (each.as == Program::As::SomeCoordinates) {
      value = place.q[each.first_coordinate + i];
    } else {
      // A force has 3p coordinates, then as many velocities.
      const double* const from = i < num_coordinates ? place.r : place.v;
      value = from[3 * static_cast<std::size_t>(each.points[i % num_coordinates / 3]) + i % 3];
    }
    *program.variable(lanes, 0, i) = SeriesLane{} + value;
  }
}

/// Writes values_ [value][time]. Returns |gradient| of a constraint where the step begins, otherwise 1.
double Drives::run(const Program& each, const Place& place) {
  const SeriesProgram& program = each.program;
  const std::size_t num_times = samples_.times().size(), num_values = each.num_values();
  lanes_.resize(program.num_lanes(0) * series_width);
  auto* const lanes = reinterpret_cast<SeriesLane*>(lanes_.data());
  load_state(each, place, lanes);
  values_.resize(num_values * num_times);
  double steepness = 1.0;
  const SeriesLane one = SeriesLane{} + 1.0;
  for (std::size_t first = 0; first < num_times; first += series_width) {
    const std::size_t count = std::min(series_width, num_times - first);
    SeriesLane& t = *program.variable(lanes, 0, program.num_variables() - 1);
    for (std::size_t lane = 0; lane < series_width; ++lane)
      t[lane] = samples_.times()[first + std::min(lane, count - 1)];
    program.evaluate(lanes, 0, 0);
    const bool is_energy = each.as == Program::As::AnEnergy;
    if (is_energy) program.differentiate(lanes, 0, 0, &one);
    for (std::size_t m = 0; m < num_values; ++m) {
      const SeriesLane& value = is_energy ? *program.adjoint(lanes, 0, m) : *program.result(lanes, 0, m);
      for (std::size_t lane = 0; lane < count; ++lane) values_[m * num_times + first + lane] = value[lane];
    }
    if (first > 0 || each.as != Program::As::AConstraint) continue;
    program.differentiate(lanes, 0, 0, &one);
    double square = 0.0;
    for (std::size_t i = 0; i + 1 < program.num_variables(); ++i) {
      const double slope = (*program.adjoint(lanes, 0, i))[0];
      square += slope * slope;
    }
    if (square > 0.0) steepness = std::sqrt(square);
  }
  return steepness;
}

}  // namespace tanor::detail
