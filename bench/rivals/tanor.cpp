/// tanor on the problems of its rivals, one thread, through its public interface alone.
///
///     rival_tanor PROBLEM SIZE METHOD RTOL FILE       METHOD: dop853, dopri5, taylor, taylor12 (with its order), …

#include <tanor/tanor.hpp>

#include "problem.hpp"

namespace rivals {
namespace {

tanor::System make_system(const Problem& problem) {
  tanor::System system;
  system.positions = problem.places;
  system.masses.assign(static_cast<std::size_t>(problem.size()), problem.mass);
  tanor::Rods rods;
  for (const Rod& rod : problem.rods) {
    tanor::Index from = rod.i;
    if (rod.i < 0) {
      from = static_cast<tanor::Index>(system.masses.size());
      system.positions.insert(system.positions.end(), rod.anchor.begin(), rod.anchor.end());
      system.masses.push_back(1.0);
      system.supports.push_back({.points = {from}});
    }
    rods.pairs.push_back({from, rod.j});
  }
  rods.length = problem.length;
  system.constraints = {rods};
  system.forces = {tanor::Gravity{.acceleration = {0.0, 0.0, -problem.gravity}}};
  return system;
}

/// "taylor12" -> taylor, order 12
tanor::MotionOptions read_options(const std::string& method, double rtol) {
  tanor::MotionOptions options{.rtol = rtol, .atol = 0.01 * rtol};
  const bool has_order = method.starts_with("taylor") && method.size() > 6;
  options.method = tanor::method_from_name(has_order ? "taylor" : method);
  if (has_order) options.order = std::stoi(method.substr(6));
  return options;
}

Run make_run(const Problem& problem, const std::string& method, double rtol) {
  tanor::Simulation simulation(make_system(problem), read_options(method, rtol), {.threads = 1});
  Run run;
  const double begin = processor_time();
  const tanor::Outcome outcome = simulation.advance(problem.t_end);
  run.seconds = processor_time() - begin;
  if (!outcome.ok()) throw std::runtime_error(outcome.what);
  run.steps = static_cast<long>(simulation.report().steps);
  run.factorizations = static_cast<long>(simulation.report().counters.factorizations);
  const auto places = simulation.positions();
  run.places.assign(places.begin(), places.begin() + 3 * problem.size());
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  return rivals::drive(count, words, rivals::make_run);
}
