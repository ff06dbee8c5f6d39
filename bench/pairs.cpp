// Measures pair forces with Google Benchmark: WCA beads at the density of a melt, log on 2000 points; arguments:
// threads.
//   pairs [--benchmark_filter=wca]
// `ns_a_point` is one evaluation of forces and energy; `ns_a_pair` counts each ordered pair within the cutoff.

#include <benchmark/benchmark.h>

#include <cmath>

#include "evaluate/pair_field.hpp"
#include "scenes.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

/// Makes 32,000 beads on a shaken grid, 0.8442 a cubic sigma, periodic.
System make_beads() {
  constexpr int columns = 20, rows = 40;
  const double spacing = std::cbrt(1.0 / 0.8442);
  System system = scenes::make_shaken_grid({columns, rows, rows}, spacing, 1);
  system.forces = {PairForces{.law = PairLaw::Wca, .box = {columns * spacing, rows * spacing, rows * spacing}}};
  return system;
}

System make_sphere(int count) {
  System system;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, radius = std::sqrt(1.0 - z * z),
                 angle = i * M_PI * (3.0 - std::sqrt(5.0));
    for (const double x : {radius * std::cos(angle), radius * std::sin(angle), z}) system.positions.push_back(x);
    system.masses.push_back(1.0);
  }
  system.forces = {PairForces{.law = PairLaw::Log}};
  return system;
}

std::size_t count_pairs(const System& system, const PairForces& pairs) {
  if (pairs.law == PairLaw::Log) return system.num_points() * (system.num_points() - 1);
  const PeriodicBox box(pairs.box);
  std::size_t count = 0;
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 d = box.nearest_image(load(system.positions.data(), i) - load(system.positions.data(), j));
      if (dot(d, d) < std::cbrt(2.0)) count += 2;
    }
  }
  return count;
}

/// Evaluates in turn at two configurations, `stride` apart. The neighbour lists are kept if they are near each other.
void evaluate(benchmark::State& state, const System& system, double stride) {
  const Parallel parallel(static_cast<int>(state.range(0)));
  const auto& pairs = std::get<PairForces>(system.forces[0]);
  PairField field(system, pairs, number(system));
  std::vector<double> places[2] = {system.positions, system.positions}, f(system.positions.size());
  for (double& x : places[1]) x += stride;
  int turn = 0;
  for (auto _ : state) {
    field.add_forces(parallel, places[turn ^= 1].data(), f.data());
    benchmark::ClobberMemory();
  }
  const auto nanoseconds_per = [](std::size_t count) {
    return benchmark::Counter(1e-9 * static_cast<double>(count),
                              benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  };
  state.counters["ns_a_point"] = nanoseconds_per(system.num_points());
  state.counters["ns_a_pair"] = nanoseconds_per(count_pairs(system, pairs));
}

void wca_32000(benchmark::State& state) {
  evaluate(state, make_beads(), 1e-3);
}
void wca_32000_new_lists(benchmark::State& state) {
  evaluate(state, make_beads(), 0.2);
}
void log_2000(benchmark::State& state) {
  evaluate(state, make_sphere(2000), 1e-3);
}

BENCHMARK(wca_32000)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(wca_32000_new_lists)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(log_2000)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
