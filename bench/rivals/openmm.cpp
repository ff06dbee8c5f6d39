/// Runs OpenMM's leapfrog with constraints (CCMA) and a fixed step: the positions of velocity Verlet, one projection a
/// step.
///
///     rival_openmm PROBLEM SIZE ccma STEP FILE       STEP: s

#include <OpenMM.h>

#include "problem.hpp"

namespace rivals {
namespace {

constexpr double anchor_mass = 1e15;            // OpenMM refuses constraints of fixed points
constexpr double constraint_tolerance = 1e-10;  // of the length

/// Makes the run. OpenMM's nm, ps, u stand for our m, s, kg, and no other units enter.
Run make_run(const Problem& problem, const std::string& /*method*/, double step) {
  using namespace OpenMM;
  OpenMM::System system;
  std::vector<Vec3> places;
  // Leapfrog keeps v half a step back, and rods that lie flat let beads fall freely at first.
  std::vector<Vec3> velocities(static_cast<std::size_t>(problem.size()), Vec3(0.0, 0.0, 0.5 * step * problem.gravity));
  auto* gravity = new CustomExternalForce("weight*z");  // the system deletes it
  gravity->addGlobalParameter("weight", problem.mass * problem.gravity);
  for (int i = 0; i < problem.size(); ++i) {
    gravity->addParticle(system.addParticle(problem.mass));
    places.emplace_back(problem.places[3 * i], problem.places[3 * i + 1], problem.places[3 * i + 2]);
  }
  system.addForce(gravity);
  for (const Rod& rod : problem.rods) {
    int from = rod.i;
    if (from < 0) {
      from = system.addParticle(anchor_mass);
      places.emplace_back(rod.anchor[0], rod.anchor[1], rod.anchor[2]);
      velocities.emplace_back();
    }
    system.addConstraint(from, rod.j, problem.length);
  }
  VerletIntegrator integrator(step);
  integrator.setConstraintTolerance(constraint_tolerance);
  Context context(system, integrator, Platform::getPlatformByName("Reference"));
  context.setPositions(places);
  context.setVelocities(velocities);

  Run run;
  run.steps = std::lround(problem.t_end / step);
  const double begin = processor_time();
  integrator.step(static_cast<int>(run.steps));
  run.seconds = processor_time() - begin;
  const State end = context.getState(State::Positions);
  for (int i = 0; i < problem.size(); ++i) {
    const Vec3& r = end.getPositions()[static_cast<std::size_t>(i)];
    run.places.insert(run.places.end(), {r[0], r[1], r[2]});
  }
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  return rivals::drive(count, words, rivals::make_run);
}
