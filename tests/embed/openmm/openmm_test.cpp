#include <gtest/gtest.h>

#include <openmm/internal/ContextImpl.h>
#include <openmm/kernels.h>
#include <openmm/reference/ReferenceKernelFactory.h>
#include <openmm/reference/ReferencePlatform.h>
#include <openmm/serialization/XmlSerializer.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "embed/openmm/openmm_systems.hpp"

/// OpenMM never frees what it registers when it is loaded, nor Contexts that it refuses.
extern "C" [[gnu::visibility("default")]] const char* __asan_default_options() {
  return "detect_leaks=0";
}

namespace tanor::embed {
namespace {

using OpenMM::State;
using OpenMM::Vec3;

OpenMM::Platform& reference() {
  return OpenMM::Platform::getPlatformByName("Reference");
}

std::vector<Vec3> positions_of(const OpenMM::Context& context) {
  return context.getState(State::Positions).getPositions();
}

double energy_of(const OpenMM::Context& context) {
  const State state = context.getState(State::Energy);
  return state.getKineticEnergy() + state.getPotentialEnergy();
}

/// The message of what `action` throws.
template <class Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const OpenMM::OpenMMException& error) {
    return error.what();
  }
  return "nothing thrown";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A context, and the integrator that it needs.
struct HostRun {
  std::unique_ptr<OpenMM::Integrator> integrator;
  OpenMM::Context context;

  HostRun(const Molecules& molecules, std::unique_ptr<OpenMM::Integrator> method, OpenMM::Platform& platform)
      : integrator(std::move(method)), context(*molecules.system, *integrator, platform) {
    context.setPositions(molecules.positions);
  }
  HostRun(const Molecules& molecules, double step)
      : HostRun(molecules, std::make_unique<OpenMM::VerletIntegrator>(step), reference()) {}
};

// ---- what holds ----

TEST(OpenMM, ChainKeepsItsDistancesToRounding) {
  Molecules chain = make_chain(999);
  chain.add_exact_constraints();
  HostRun run(chain, 0.001);
  run.context.setVelocitiesToTemperature(300, 7);

  for (int k = 0; k < 30; ++k) {
    run.integrator->step(10);
    ASSERT_LT(chain.violation(positions_of(run.context)), 1e-13) << k;
  }
}

void expect_long_motion(Molecules molecules) {
  molecules.add_exact_constraints();
  HostRun run(molecules, 0.001);
  run.context.setVelocitiesToTemperature(300, 7);
  run.integrator->step(1);
  const double start = energy_of(run.context), kinetic = run.context.getState(State::Energy).getKineticEnergy();

  for (int k = 0; k < 100; ++k) {
    run.integrator->step(1000);
    ASSERT_LT(molecules.violation(positions_of(run.context)), 1e-13) << k;
    ASSERT_NEAR(energy_of(run.context), start, 1e-3 * kinetic) << k;
  }
}

TEST(OpenMM, MethaneWithAllTenDistancesGoesOnFor1e5Steps) {
  expect_long_motion(make_methane());
}

TEST(OpenMM, DiamondOfFiveRodsGoesOnFor1e5Steps) {
  expect_long_motion(make_diamond());
}

TEST(OpenMM, MovesAsCcmaDoesThatConverges) {
  std::vector<Vec3> ends[2];
  double energies[2];
  for (const bool exact : {false, true}) {
    Molecules chain = make_chain(30);
    if (exact) chain.add_exact_constraints();
    HostRun run(chain, 0.001);
    run.integrator->setConstraintTolerance(1e-12);
    // Velocities that the constraints allow; the Context would make them so with a tolerance of its own.
    run.context.setVelocities(std::vector<Vec3>(31, Vec3(0.1, -0.2, 0.3)));
    run.integrator->step(200);
    ends[exact] = positions_of(run.context);
    energies[exact] = energy_of(run.context);
  }

  for (std::size_t i = 0; i < ends[0].size(); ++i)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(ends[0][i][k], ends[1][i][k], 1e-9);
  EXPECT_NEAR(energies[0], energies[1], 1e-9 * std::abs(energies[0]));
}

TEST(OpenMM, KeepsWaterRigidInThePlaceOfSettle) {
  Molecules water;
  water.add_particle(15.999, {0, 0, 0});
  for (const double side : {-1.0, 1.0}) water.add_particle(1.008, {0.0757 * side, 0.0586, 0});
  water.add_constraint(0, 1);
  water.add_constraint(0, 2);
  water.add_constraint(1, 2);
  water.add_field("2*(x^2 + y^2 + z^2)");
  water.add_exact_constraints();
  HostRun run(water, 0.001);
  run.context.setVelocitiesToTemperature(300, 7);

  run.integrator->step(1000);

  EXPECT_LT(water.violation(positions_of(run.context)), 1e-13);  // SETTLE keeps its distances in single precision
}

TEST(OpenMM, VelocitiesAndPositionsAreProjectedOnRequest) {
  Molecules chain = make_chain(50);
  chain.add_exact_constraints();
  HostRun run(chain, 0.001);
  std::vector<Vec3> disturbed = chain.positions;
  for (std::size_t i = 0; i < disturbed.size(); ++i) disturbed[i][0] += 0.01 * std::sin(static_cast<double>(i));
  run.context.setPositions(disturbed);

  run.context.applyConstraints(1e-5);
  run.context.setVelocitiesToTemperature(300, 7);

  const State state = run.context.getState(State::Positions | State::Velocities);
  EXPECT_LT(chain.violation(state.getPositions()), 1e-13);
  for (const auto& [i, j] : chain.pairs) {
    const auto from = static_cast<std::size_t>(i), to = static_cast<std::size_t>(j);
    const Vec3 r = state.getPositions()[to] - state.getPositions()[from];
    EXPECT_NEAR(r.dot(state.getVelocities()[to] - state.getVelocities()[from]), 0.0, 1e-13);
  }
}

TEST(OpenMM, EveryIntegratorAndThePlatformCpuKeepTheConstraints) {
  std::vector<OpenMM::Platform*> platforms{&reference()};
  try {
    OpenMM::Platform::loadPluginLibrary(OpenMM::Platform::getDefaultPluginsDirectory() + "/libOpenMMCPU.so");
    platforms.push_back(&OpenMM::Platform::getPlatformByName("CPU"));
  } catch (const OpenMM::OpenMMException& error) {
    std::puts(error.what());
  }
  const auto make_rattle = [] {
    auto rattle = std::make_unique<OpenMM::CustomIntegrator>(0.001);
    rattle->addPerDofVariable("x1", 0);
    rattle->addUpdateContextState();
    rattle->addComputePerDof("v", "v+0.5*dt*f/m");
    rattle->addComputePerDof("x", "x+dt*v");
    rattle->addComputePerDof("x1", "x");
    rattle->addConstrainPositions();
    rattle->addComputePerDof("v", "v+0.5*dt*f/m+(x-x1)/dt");
    rattle->addConstrainVelocities();
    return rattle;
  };
  for (OpenMM::Platform* const platform : platforms) {
    std::vector<std::unique_ptr<OpenMM::Integrator>> integrators;
    integrators.push_back(std::make_unique<OpenMM::VerletIntegrator>(0.001));
    integrators.push_back(std::make_unique<OpenMM::VariableVerletIntegrator>(1e-7));
    integrators.push_back(std::make_unique<OpenMM::LangevinIntegrator>(300, 1, 0.001));
    integrators.push_back(std::make_unique<OpenMM::LangevinMiddleIntegrator>(300, 1, 0.001));
    integrators.push_back(std::make_unique<OpenMM::BrownianIntegrator>(300, 1, 1e-4));
    integrators.push_back(std::make_unique<OpenMM::NoseHooverIntegrator>(300, 1, 0.001));
    integrators.push_back(make_rattle());
    for (std::size_t k = 0; k < integrators.size(); ++k) {
      Molecules chain = make_chain(40);
      chain.add_exact_constraints();
      HostRun run(chain, std::move(integrators[k]), *platform);
      run.context.setVelocitiesToTemperature(300, 7);

      run.integrator->step(100);

      EXPECT_LT(chain.violation(positions_of(run.context)), 1e-13) << platform->getName() << ", integrator " << k;
    }
  }
}

TEST(OpenMM, WholeMoleculesInAPeriodicCellStayWholeUnderABarostat) {
  Molecules chain = make_chain(20);  // across faces of the cell: nobody wraps it
  chain.system->setDefaultPeriodicBoxVectors({1.2, 0, 0}, {0.2, 1.3, 0}, {-0.1, 0.3, 1.4});
  auto* const pairs = new OpenMM::NonbondedForce;
  pairs->setNonbondedMethod(OpenMM::NonbondedForce::CutoffPeriodic);
  pairs->setCutoffDistance(0.4);
  for (std::size_t i = 0; i < chain.positions.size(); ++i) pairs->addParticle(0.0, 0.1, 0.0);
  chain.system->addForce(pairs);
  auto* const barostat = new OpenMM::MonteCarloBarostat(30.0, 300.0, 2);
  barostat->setRandomNumberSeed(3);  // with some the cell shrinks below twice the cutoff
  chain.system->addForce(barostat);
  chain.add_exact_constraints();
  HostRun run(chain, 0.001);
  run.context.setVelocitiesToTemperature(300, 7);

  run.integrator->step(500);

  Vec3 edges[3];
  run.context.getState(0).getPeriodicBoxVectors(edges[0], edges[1], edges[2]);
  EXPECT_NE(edges[0][0], 1.2);
  EXPECT_LT(chain.violation(positions_of(run.context)), 1e-13);
}

// ---- particles without mass ----

TEST(OpenMM, ParticleWithoutMassHoldsAPendulum) {
  Molecules pendulum;
  pendulum.add_particle(0.0, {0.5, 0, 0});
  pendulum.add_particle(2.0, {1.5, 0, 0});
  pendulum.pairs = {{0, 1}};
  pendulum.add_field("2*9.81*y");
  ExactConstraints& exact = pendulum.add_exact_constraints();
  EXPECT_EQ(exact.addConstraint(0, 1, 1.0), 0);
  HostRun run(pendulum, 1e-3);

  // It falls from the horizontal to the lowest place in a quarter of the period: K(sin 45°) = 1.854074677 times
  // sqrt(l/g).
  run.integrator->step(static_cast<int>(std::lround(1.854074677 / std::sqrt(9.81) / 1e-3)));

  const std::vector<Vec3> end = positions_of(run.context);
  EXPECT_EQ(end[0], Vec3(0.5, 0, 0));
  EXPECT_LT(pendulum.violation(end), 1e-13);
  EXPECT_NEAR(end[1][0], 0.5, 5e-3);
  EXPECT_NEAR(end[1][1], -1.0, 1e-4);
}

TEST(OpenMM, ConstrainedParticlesFormOneMolecule) {
  Molecules loose;
  for (int i = 0; i < 4; ++i) loose.add_particle(1.0, Vec3(i, 0, 0));
  ExactConstraints& exact = loose.add_exact_constraints();
  exact.addConstraint(0, 1, 1.0);
  exact.addConstraint(2, 1, 1.0);
  HostRun run(loose, 1e-3);

  EXPECT_EQ(run.context.getMolecules(), (std::vector<std::vector<int>>{{0, 1, 2}, {3}}));
}

TEST(OpenMM, ConstraintsBetweenParticlesWithoutMassAreLeftOutAsOpenMMDoes) {
  Molecules chain = make_chain(2);
  const int first = chain.add_particle(0.0, {0, 1, 0}), second = chain.add_particle(0.0, {0, 2, 0});
  chain.system->addConstraint(first, second, 7.0);
  chain.add_exact_constraints();
  HostRun run(chain, 1e-3);

  run.integrator->step(10);

  EXPECT_LT(chain.violation(positions_of(run.context)), 1e-13);
}

TEST(OpenMM, ACallForPythonAddsTheForce) {
  const Molecules chain = make_chain(2);

  tanor_openmm_add_exact_constraints(chain.system.get());

  EXPECT_NE(dynamic_cast<ExactConstraints*>(&chain.system->getForce(chain.system->getNumForces() - 1)), nullptr);
}

TEST(OpenMM, ASystemInXmlKeepsTheForce) {
  Molecules chain = make_chain(2);
  ExactConstraints& exact = chain.add_exact_constraints();
  exact.setForceGroup(3);
  exact.addConstraint(0, 2, 0.1875);
  std::stringstream xml;

  OpenMM::XmlSerializer::serialize<OpenMM::System>(chain.system.get(), "System", xml);
  const std::unique_ptr<OpenMM::System> read(OpenMM::XmlSerializer::deserialize<OpenMM::System>(xml));

  const auto& back = dynamic_cast<const ExactConstraints&>(read->getForce(1));
  EXPECT_EQ(back.getForceGroup(), 3);
  ASSERT_EQ(back.getNumConstraints(), 1);
  int i, j;
  double distance;
  back.getConstraintParameters(0, i, j, distance);
  EXPECT_EQ(std::make_pair(i, j), std::make_pair(0, 2));
  EXPECT_EQ(distance, 0.1875);
}

// ---- errors ----

/// Reference by another name that is not derived from it, as OpenCL and CUDA are not.
class OtherPlatform : public OpenMM::Platform {
 public:
  OtherPlatform() {
    for (const std::string& kernel :
         {OpenMM::CalcForcesAndEnergyKernel::Name(), OpenMM::UpdateStateDataKernel::Name(),
          OpenMM::ApplyConstraintsKernel::Name(), OpenMM::VirtualSitesKernel::Name(),
          OpenMM::IntegrateVerletStepKernel::Name(), OpenMM::CalcCustomExternalForceKernel::Name()})
      registerKernelFactory(kernel, new OpenMM::ReferenceKernelFactory);
  }
  const std::string& getName() const override {
    static const std::string name = "Other";
    return name;
  }
  double getSpeed() const override { return 0; }
  bool supportsDoublePrecision() const override { return true; }
  void contextCreated(OpenMM::ContextImpl& context, const std::map<std::string, std::string>& with) const override {
    base_.contextCreated(context, with);
  }
  void contextDestroyed(OpenMM::ContextImpl& context) const override { base_.contextDestroyed(context); }

 private:
  OpenMM::ReferencePlatform base_;
};

TEST(OpenMMErrors, AnotherPlatformIsNamed) {
  Molecules chain = make_chain(2);
  chain.add_exact_constraints();
  static OtherPlatform other;

  EXPECT_EQ(
      message_of([&] { HostRun(chain, std::make_unique<OpenMM::VerletIntegrator>(1e-3), other); }),
      "ExactConstraints: the platform Other keeps its constraints to itself; give the Context the platform CPU or "
      "Reference");
}

TEST(OpenMMErrors, ConstraintsThatCannotBeKeptAreNamedByTheirParticles) {
  const auto refused = [](int i, int j, double distance) {
    Molecules chain = make_chain(3);
    chain.system->setVirtualSite(chain.add_particle(0.0, {}), new OpenMM::TwoParticleAverageSite(0, 1, 0.5, 0.5));
    chain.add_exact_constraints().addConstraint(i, j, distance);
    return message_of([&] { HostRun(chain, 1e-3); });
  };
  const std::string prefix = "ExactConstraints: the constraint between particles ";

  EXPECT_EQ(refused(0, 2, 0.0), prefix + "0 and 2 has the distance 0 nm; it must be positive");
  EXPECT_EQ(refused(0, 2, std::nan("")), prefix + "0 and 2 has the distance nan nm; it must be positive");
  EXPECT_EQ(refused(1, 9, 0.1), prefix + "1 and 9: there is no particle 9");
  EXPECT_EQ(refused(1, 4, 0.1), prefix + "1 and 4: particle 4 is a virtual site");
  EXPECT_EQ(refused(2, 2, 0.1), prefix + "2 and 2 joins a particle to itself");
  EXPECT_EQ(refused(2, 1, 0.15), prefix + "2 and 1 is there twice");
}

TEST(OpenMMErrors, MissingConstraintsAndSecondForcesAreNamed) {
  Molecules nothing, twice = make_chain(2);
  nothing.add_particle(1.0, {});
  nothing.add_exact_constraints();
  twice.add_exact_constraints();
  twice.add_exact_constraints();

  EXPECT_EQ(message_of([&] { HostRun(nothing, 1e-3); }), "ExactConstraints: the System has no constraints");
  EXPECT_EQ(message_of([&] { HostRun(twice, 1e-3); }), "ExactConstraints: the System contains more than one");
  int i, j;
  double distance;
  EXPECT_EQ(message_of([&] { ExactConstraints().getConstraintParameters(0, i, j, distance); }),
            "ExactConstraints: there is no constraint 0");
}

TEST(OpenMMErrors, PositionsThatAreNoNumbersAreNamed) {
  Molecules chain = make_chain(5);
  chain.add_exact_constraints();
  for (const int steps_before : {0, 3}) {
    HostRun run(chain, 1e-3);
    run.integrator->step(steps_before);
    std::vector<Vec3> positions = chain.positions;
    positions[4][1] = std::numeric_limits<double>::quiet_NaN();
    run.context.setPositions(positions);

    EXPECT_EQ(message_of([&] { run.integrator->step(1); }),
              "ExactConstraints: the position of particle 4 is no finite number");
  }
}

TEST(OpenMMErrors, VelocitiesThatAreNoNumbersAreNamed) {
  Molecules chain = make_chain(5);
  chain.add_exact_constraints();
  HostRun run(chain, 1e-3);
  std::vector<Vec3> velocities(chain.positions.size());
  velocities[2][0] = std::numeric_limits<double>::infinity();
  run.context.setVelocities(velocities);

  EXPECT_EQ(message_of([&] { run.context.applyVelocityConstraints(1e-5); }),
            "ExactConstraints: the velocity of particle 2 is no finite number");
}

TEST(OpenMMErrors, AStartOffTheConstraintsSaysWhatToCall) {
  Molecules chain = make_chain(5);
  chain.add_exact_constraints();
  HostRun run(chain, 1e-3);
  std::vector<Vec3> stretched = chain.positions;
  stretched[5] += (stretched[5] - stretched[4]) * 0.01;
  run.context.setPositions(stretched);

  EXPECT_EQ(message_of([&] { run.integrator->step(1); }),
            "ExactConstraints: the constraint between particles 4 and 5 is violated by 0.01 of its distance where the "
            "step begins; call applyConstraints() of the Context after setPositions()");
  run.context.applyConstraints(1e-5);
  run.integrator->step(1);
  EXPECT_LT(chain.violation(positions_of(run.context)), 1e-13);
}

TEST(OpenMMErrors, AStepThatTurnsARodTooFarNamesIt) {
  Molecules chain = make_chain(5);
  chain.add_exact_constraints();
  HostRun run(chain, 1e-3);
  std::vector<Vec3> velocities(chain.positions.size());
  const Vec3 along = chain.positions[3] - chain.positions[2];
  velocities[3] = along.cross(Vec3(1, 0, 0)) * 1e5;
  run.context.setVelocities(velocities);

  const std::string message = message_of([&] { run.integrator->step(1); });

  EXPECT_TRUE(contains(message, "between particles 2 and 3 does not converge") ||
              contains(message, "between particles 3 and 4 does not converge"))
      << message;
  EXPECT_EQ(positions_of(run.context), chain.positions);
}

}  // namespace
}  // namespace tanor::embed
