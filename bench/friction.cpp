/// Measures the cost of friction for beads on rough wires that rods couple, one thread.
///
///   OPENBLAS_NUM_THREADS=1 GOMP_SPINCOUNT=2000 friction [repetitions]
///
/// Prints one iteration of (43) over one back-solve with the factor of S that it needs; iterations and residual of an
/// instant; one evaluation with friction over one without. All are medians of times taken in turn.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <tanor/enum_names.hpp>

#include "dynamics/multiplier_form.hpp"

#include "timing.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;
using Clock = std::chrono::steady_clock;

constexpr Index num_beads = 10000;
constexpr double mu = 0.3;

/// Returns a number in [-1, 1], the same one each time.
double wave(Index i, double pitch) {
  return std::sin(pitch * static_cast<double>(i));
}

void add_rods(System* system, Index beads_a_group) {
  Rods rods{"rods", {}, {}, {}};
  for (Index i = 1; i < num_beads; ++i) {
    if (i % beads_a_group != 0) rods.pairs.push_back({i - 1, i});
  }
  system->constraints.push_back(rods);
  system->forces = {Gravity{"", {3.0, 0.0, -9.0}}};
  system->friction = {Coulomb{.name = "rust", .at = {}, .coefficient = mu}};
}

/// Makes a line for each bead; the lines are not quite parallel, and the rods are at 45 degrees to them.
System make_lines(Index beads_a_group) {
  System system;
  std::vector<std::string> wires;
  add_rods(&system, beads_a_group);
  for (Index i = 0; i < num_beads; ++i) {
    const double angle = 0.2 * wave(i, 1.7);
    const Vector3 place{0.1 * i, 0.1 * i, 0.0}, direction{std::sin(angle), std::cos(angle), 0.0};
    system.positions.insert(system.positions.end(), place.begin(), place.end());
    system.masses.push_back(0.1 * (1.5 + wave(i, 2.3)));
    // The rods keep their lengths, so that the velocities of all beads along them are equal.
    const double speed = 1.0 / (direction[0] + direction[1]);
    for (const double d : direction) system.velocities.push_back(speed * d);
    wires.push_back("wire" + std::to_string(i));
    system.constraints.push_back(Lines{wires.back(), {i}, place, direction});
  }
  std::get<Coulomb>(system.friction[0]).at = wires;
  return system;
}

/// Makes a hoop around the z axis for each bead, hoop above hoop, all beads turning at one rate; rods wind upwards at
/// 45
/// degrees.
System make_hoops(Index beads_a_group) {
  System system;
  std::vector<std::string> wires;
  add_rods(&system, beads_a_group);
  for (Index i = 0; i < num_beads; ++i) {
    const double angle = 0.1 * i + 0.01 * wave(i, 1.7), z = 0.1 * i;
    const Vector3 place{std::cos(angle), std::sin(angle), z};
    system.positions.insert(system.positions.end(), place.begin(), place.end());
    system.masses.push_back(0.1 * (1.5 + wave(i, 2.3)));
    for (const double v : {-place[1], place[0], 0.0}) system.velocities.push_back(v);
    wires.push_back("hoop" + std::to_string(i));
    system.constraints.push_back(Circles{wires.back(), {i}, Vector3{0.0, 0.0, z}, Vector3{0.0, 0.0, 1.0}, 1.0});
  }
  std::get<Coulomb>(system.friction[0]).at = wires;
  return system;
}

/// A system at its start, in the inner order.
struct Instant {
  Workspace work;
  const Model& model{work.model()};
  MultiplierForm form;
  std::vector<double> r, v, w, b;
  SolveReport report;

  explicit Instant(const System& system, FrictionMethod method)
      : work(system, {.threads = 1, .friction = method}, 0.0),
        form(work, {.friction = method}),
        r(form.size()),
        v(form.size()),
        w(form.size()),
        b(model.num_rows(), 1.0) {
    model.numbering.gather_points(system.positions, r);
    model.numbering.gather_points(system.velocities, v);
    work.measure_velocity_scale(0.0, r.data(), v.data());
  }

  /// Evaluates at larger and smaller velocities by turns, so that the solution found before is no answer yet.
  double evaluate(int round) {
    for (double& each : v) each *= round % 2 == 0 ? 1.25 : 0.8;
    const auto begin = Clock::now();
    const Outcome outcome =
        form.accelerations({0.0, r.data(), v.data()}, {.refuses_several = true}, {w.data(), nullptr, &report});
    if (!outcome.ok()) std::printf("%s\n", outcome.what.c_str());
    return std::chrono::duration<double>(Clock::now() - begin).count();
  }
  /// Returns the time of one back-solve.
  double solve() {
    constexpr int times = 10;
    const auto begin = Clock::now();
    for (int k = 0; k < times; ++k) {
      form.linearization().solve_negative(b.data(), b.data());
      b[0] += 1.0;
    }
    return std::chrono::duration<double>(Clock::now() - begin).count() / times;
  }
};

void measure(const char* name, const System& rough, FrictionMethod method, int repetitions) {
  System smooth = rough;
  smooth.friction.clear();
  Instant instant(rough, method), without(smooth, method);
  std::vector<double> iteration, solve, evaluation, evaluation_without;
  double residual = 0.0;
  (void)instant.evaluate(1);
  (void)without.evaluate(1);
  const Counters start = instant.work.counters;
  for (int round = 0; round < repetitions; ++round) {
    const double seconds_before = instant.work.times.friction;
    const std::size_t iterations_before = instant.work.counters.friction_iterations;
    evaluation.push_back(instant.evaluate(round));
    iteration.push_back((instant.work.times.friction - seconds_before) /
                        static_cast<double>(instant.work.counters.friction_iterations - iterations_before));
    solve.push_back(instant.solve());
    evaluation_without.push_back(without.evaluate(round));
    residual = std::max(residual, instant.report.friction.residual);
  }
  const Counters& end = instant.work.counters;
  std::printf(
      "%-24s %-9s iteration %7.3f ms   back-solve %7.3f ms   ratio %5.2f   iterations %4.1f   residual %.0e   "
      "evaluation %6.2f ms, without friction %6.2f ms\n",
      name, std::string(tanor::name_of(method)).c_str(), 1e3 * median(iteration), 1e3 * median(solve),
      median(iteration) / median(solve),
      static_cast<double>(end.friction_iterations - start.friction_iterations) /
          static_cast<double>(end.friction_solves - start.friction_solves),
      residual, 1e3 * median(evaluation), 1e3 * median(evaluation_without));
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 21;
  for (const auto& [name, system] :
       {std::pair{"lines, groups of 10", make_lines(10)}, std::pair{"lines, groups of 100", make_lines(100)},
        std::pair{"hoops, groups of 10", make_hoops(10)}, std::pair{"hoops, groups of 100", make_hoops(100)}}) {
    for (const FrictionMethod method : {FrictionMethod::Anderson, FrictionMethod::FixedPoint})
      measure(name, system, method, repetitions);
  }
}
