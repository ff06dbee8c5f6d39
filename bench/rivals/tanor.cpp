/// Runs tanor on the problems of its rivals, one thread, through its public interface alone.
///
///     rival_tanor PROBLEM SIZE METHOD RTOL FILE       METHOD: dop853, dopri5, taylor, taylor12 (with its order), …;
///                                                     "/general" after it: general solver; generalized_alpha: RTOL
///                                                     is the step, s

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
  tanor::Springs springs{.stiffness = problem.stiffness, .damping = problem.damping, .rest_length = problem.length};
  for (const Rod& spring : problem.springs) springs.pairs.push_back({spring.i, spring.j});
  if (!springs.pairs.empty()) system.forces.push_back(springs);
  if (problem.drag > 0.0) {
    tanor::Drag honey{.linear = problem.drag};
    for (tanor::Index i = 0; i < static_cast<tanor::Index>(problem.size()); ++i) honey.points.push_back(i);
    system.forces.push_back(honey);
  }
  return system;
}

/// Makes the car axis of the IVP test set: the left wheel's foot at rest, the right one's on the road.
tanor::System make_car_axis(const Problem& axis) {
  tanor::System system;
  system.positions = axis.places;
  system.positions.insert(system.positions.end(), {0, 0, 0, 1, 0, 0});
  system.velocities = {-0.5, 0, 0, -0.5, 0, 0, 0, 0, 0, 0, 0, 0};
  system.masses.assign(4, 5e-4);
  const auto formula = [](const char* text) { return tanor::ScalarFunction::formula(text); };
  system.supports = {
      {.points = {2}},
      {.points = {3}, .displacement = {formula("sqrt(1 - (0.1*sin(10*t))^2) - 1"), formula("0.1*sin(10*t)"), 0.0}}};
  system.constraints = {tanor::Angles{.triples = {{0, 2, 3}}, .cosine = 0.0},
                        tanor::Rods{.pairs = {{0, 1}}, .length = 1.0}};
  system.forces = {tanor::Springs{.pairs = {{2, 0}, {3, 1}}, .stiffness = 1.0, .rest_length = 0.5},
                   tanor::Gravity{.acceleration = {0.0, -1.0, 0.0}}};
  return system;
}

/// Reads a method; "taylor12" means taylor of order 12.
tanor::MotionOptions read_options(const std::string& method, double tolerance) {
  if (method == "generalized_alpha")
    return {.method = tanor::Method::GeneralizedAlpha, .step = tolerance, .rtol = 1e-9, .atol = 1e-11};
  tanor::MotionOptions options{.rtol = tolerance, .atol = 0.01 * tolerance};
  const bool has_order = method.starts_with("taylor") && method.size() > 6;
  options.method = tanor::method_from_name(has_order ? "taylor" : method);
  if (has_order) options.order = std::stoi(method.substr(6));
  return options;
}

Run make_run(const Problem& problem, const std::string& method, double tolerance) {
  const std::size_t slash = method.find('/');
  tanor::SolverOptions solver{.threads = 1};
  if (slash != std::string::npos) solver.linear_solver = tanor::LinearSolver::General;
  tanor::Simulation simulation(problem.is_car_axis ? make_car_axis(problem) : make_system(problem),
                               read_options(method.substr(0, slash), tolerance), solver);
  Run run;
  const double begin = processor_time();
  const tanor::Outcome outcome = simulation.advance_to(problem.t_end);
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
