// Measures whole steps of OpenMM (Verlet, platform Reference) with ExactConstraints and with CCMA, in turn in one
// process:
//   openmm [largest number of rods]
// Prints, as a page, the median processor time of a step, the largest violation, and the result of 1e6 steps of two
// molecules whose constraints close rings or depend on each other.

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "openmm_systems.hpp"
#include "timing.hpp"

namespace {

using namespace tanor::embed;

/// A system in motion, and the times of its steps.
struct Motion {
  std::string name;
  Molecules molecules;
  OpenMM::VerletIntegrator integrator{0.001};
  std::unique_ptr<OpenMM::Context> context;
  double set_up = 0.0;
  double violation = 0.0;
  std::vector<double> times;

  Motion(std::string title, Molecules of, bool exact, double tolerance)
      : name(std::move(title)), molecules(std::move(of)) {
    if (exact) molecules.add_exact_constraints();
    integrator.setConstraintTolerance(tolerance);
    const double begin = processor_seconds();
    context = std::make_unique<OpenMM::Context>(*molecules.system, integrator,
                                                OpenMM::Platform::getPlatformByName("Reference"));
    set_up = processor_seconds() - begin;
    context->setPositions(molecules.positions);
    context->setVelocitiesToTemperature(300, 7);
  }
  void step(int count) {
    const double begin = processor_seconds();
    integrator.step(count);
    times.push_back((processor_seconds() - begin) / count);
    violation = std::max(violation, molecules.violation(context->getState(OpenMM::State::Positions).getPositions()));
  }
};

/// Makes a chain with the longest coupling: a change of one rod reaches all others.
Molecules make_zigzag(int count) {
  Molecules chain;
  for (int i = 0; i <= count; ++i) {
    chain.add_particle(14.0, OpenMM::Vec3(0.125 * (i - count / 2), 0.08 * (i % 2), 0.0));
    if (i > 0) chain.add_constraint(i - 1, i);
  }
  chain.add_field("0.5*(y^2 + z^2)");
  return chain;
}

template <class Make>
void measure_chain(const char* shape, int rods, const Make& make) {
  std::vector<std::unique_ptr<Motion>> motions;
  motions.push_back(std::make_unique<Motion>("ExactConstraints", make(rods), true, 1e-5));
  for (const double tolerance : {1e-5, 1e-10, 1e-12}) {
    char name[32];
    std::snprintf(name, sizeof name, "CCMA, %.0e", tolerance);
    motions.push_back(std::make_unique<Motion>(name, make(rods), false, tolerance));
  }
  Molecules free = make(rods);
  while (free.system->getNumConstraints() > 0) free.system->removeConstraint(free.system->getNumConstraints() - 1);
  free.pairs.clear();
  motions.push_back(std::make_unique<Motion>("no constraints", std::move(free), false, 1e-5));
  constexpr int rounds = 41, steps = 10;
  for (int round = 0; round < rounds; ++round)
    for (const auto& motion : motions) motion->step(steps);
  const double ours = median(motions.front()->times);
  for (const auto& motion : motions) {
    const double time = median(motion->times);
    std::printf("| %s | %d | %s | %.2f | %.1f | %.2f | %.1e |\n", shape, rods, motion->name.c_str(), motion->set_up,
                1e6 * time, time / ours, motion->violation);
  }
}

double energy_of(const Motion& motion) {
  const OpenMM::State state = motion.context->getState(OpenMM::State::Energy);
  return state.getKineticEnergy() + state.getPotentialEnergy();
}

void go_far(const char* name, Molecules molecules, bool exact) {
  constexpr int pieces = 1000, steps = 1000;
  int done = 0;
  try {
    Motion motion(name, std::move(molecules), exact, 1e-12);
    motion.step(1);
    const double start = energy_of(motion),
                 kinetic = motion.context->getState(OpenMM::State::Energy).getKineticEnergy();
    for (; done < pieces; ++done) motion.step(steps);
    std::printf("| %s | %s | %d | %.1e | %.1e | %.1f |\n", name, exact ? "ExactConstraints" : "CCMA, 1e-12",
                pieces * steps, motion.violation, (energy_of(motion) - start) / kinetic, 1e6 * median(motion.times));
  } catch (const std::exception& error) {
    std::printf("| %s | %s | %d | %s | | |\n", name, exact ? "ExactConstraints" : "CCMA, 1e-12", done * steps,
                error.what());
  }
}

}  // namespace

int main(int count, char** words) {
  const int largest = count > 1 ? std::atoi(words[1]) : 9999;
  std::puts(
      "# OpenMM: ExactConstraints beside CCMA\n\nOpenMM 7.7, platform Reference, VerletIntegrator of 1 fs, chains of "
      "rods at 300 K, random walks and straight\nones; one thread, whole steps, medians of processor time of 41 runs "
      "of 10 steps in turn. The bar: 999 rods at\n1e-13 for less than CCMA at 1e-5. Set-up includes that of CCMA, "
      "which OpenMM makes for constraints of the System.\nRepeat with `build/bench/openmm > "
      "bench/results/openmm.md`.\n\n"
      "| chain | rods | constraints by | set-up, s | us a step | to ours | largest violation "
      "|\n|---|--:|---|--:|--:|--:|--:|");
  for (const int rods : {99, 999, 9999}) {
    if (rods > largest) continue;
    measure_chain("walk", rods, make_chain);
    measure_chain("zigzag", rods, make_zigzag);
  }
  std::puts(
      "\n| molecule | constraints by | steps | largest violation | change of energy / kinetic | us a step |\n"
      "|---|---|--:|--:|--:|--:|");
  for (const bool exact : {true, false}) {
    go_far("methane, all ten distances", make_methane(), exact);
    go_far("diamond of five rods", make_diamond(), exact);
  }
}
