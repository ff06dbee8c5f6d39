/// Runs Simbody: a chain as a tree of universal joints, integrated by its Runge-Kutta-Merson method.
///
///     rival_simbody PROBLEM SIZE rkm ACCURACY FILE       PROBLEM: chain, pendulum, a01

#include <Simbody.h>

#include "problem.hpp"

namespace rivals {
namespace {

Run make_run(const Problem& problem, const std::string& /*method*/, double accuracy) {
  using namespace SimTK;
  MultibodySystem system;
  SimbodyMatterSubsystem matter(system);
  GeneralForceSubsystem forces(system);
  Force::UniformGravity(forces, matter, Vec3(0, 0, -problem.gravity));
  const Body::Rigid bead(MassProperties(problem.mass, Vec3(0), Inertia(0)));
  // The first joint is turned so that all angles are 0 where the chain lies along x.
  const Transform turned(Rotation(Mat33(0, 0, 1, 1, 0, 0, 0, 1, 0)));
  std::vector<MobilizedBody> bodies;
  for (int i = 0; i < problem.size(); ++i) {
    MobilizedBody parent = i > 0 ? bodies.back() : MobilizedBody(matter.Ground());
    bodies.push_back(
        MobilizedBody::Universal(parent, i > 0 ? Transform() : turned, bead, Transform(Vec3(0, 0, -problem.length))));
  }
  RungeKuttaMersonIntegrator integrator(system);
  integrator.setAccuracy(accuracy);
  TimeStepper stepper(system, integrator);
  stepper.initialize(system.realizeTopology());

  Run run;
  const double begin = processor_time();
  stepper.stepTo(problem.t_end);
  run.seconds = processor_time() - begin;
  run.steps = integrator.getNumStepsTaken();
  system.realize(stepper.getState(), Stage::Position);
  for (const MobilizedBody& body : bodies) {
    const Vec3 place = body.getBodyOriginLocation(stepper.getState());
    run.places.insert(run.places.end(), {place[0], place[1], place[2]});
  }
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  return rivals::drive(count, words, rivals::make_run);
}
