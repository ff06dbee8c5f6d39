// Measures the phases of one instant with Google Benchmark, by scene and threads: evaluate, assemble, factorize, solve,
// gather.
//   phases [--benchmark_filter='chain.*/1/']      phase/scene/threads
// `items_per_second` counts rods.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "assembly/reactions.hpp"
#include "bench_scenes.hpp"
#include "evaluate/constraints.hpp"
#include "schur/gram_solver.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

std::vector<double> inner_inverse_masses(const System& system, const Numbering& numbering) {
  std::vector<double> result;
  for (const Index point : numbering.user_point) result.push_back(1.0 / system.masses[static_cast<std::size_t>(point)]);
  return result;
}

struct Instant {
  System system;
  Numbering numbering;
  Constraints constraints;
  std::vector<Incidence> incidences;
  std::vector<double> inverse_masses;
  GramSolver solver;
  ReactionGather gather;
  Parallel parallel;
  std::vector<double> r, v, w, blocks, b, lambda;

  Instant(System s, int threads)
      : system(std::move(s)),
        numbering(number(system)),
        constraints(system, numbering),
        incidences(constraints.list_incidences()),
        inverse_masses(inner_inverse_masses(system, numbering)),
        solver(incidences, inverse_masses, numbering, Ordering::Auto, constraints.squared_gradient_norms()),
        gather(incidences, system.num_points()),
        parallel(threads),
        r(system.positions.size()),
        v(r.size()),
        w(r.size()),
        blocks(3 * constraints.num_blocks()),
        b(constraints.num_rows()),
        lambda(b.size()) {
    numbering.gather_points(system.positions, r);
    numbering.gather_points(system.velocities, v);
    constraints.evaluate_right_side(parallel, r.data(), v.data(), w.data(), b.data(), blocks.data());
    solver.assemble(parallel, blocks.data());
    (void)solver.factorize(parallel);
    solver.solve_negative(parallel, b.data(), lambda.data());
  }
};

/// Returns the instant of a scene; the last one that was asked for is kept.
Instant& instant_of(const BenchScene& scene, int threads) {
  static std::string name;
  static std::unique_ptr<Instant> instant;
  const std::string wanted = scene.name + "/" + std::to_string(threads);
  if (name != wanted) {
    instant = nullptr;
    instant = std::make_unique<Instant>(scene.make(), threads);
    name = wanted;
  }
  return *instant;
}

struct Phase {
  const char* name;
  void (*work)(Instant&);
};

const std::array<Phase, 5> phases = {{
    {"evaluate",
     [](Instant& i) {
       i.constraints.evaluate_right_side(i.parallel, i.r.data(), i.v.data(), i.w.data(), i.b.data(), i.blocks.data());
     }},
    {"assemble", [](Instant& i) { i.solver.assemble(i.parallel, i.blocks.data()); }},
    {"factorize", [](Instant& i) { benchmark::DoNotOptimize(i.solver.factorize(i.parallel)); }},
    {"solve", [](Instant& i) { i.solver.solve_negative(i.parallel, i.b.data(), i.lambda.data()); }},
    {"reactions", [](Instant& i) { i.gather.reactions(i.parallel, i.blocks.data(), i.lambda.data(), i.w.data()); }},
}};

/// Returns true for chains, clusters, beads, nets and lattices of two sizes each or more.
bool is_shown(const BenchScene& scene) {
  constexpr std::array shown = {"chain 1e4",   "chain 1e6", "clusters 1e3 x 10", "clusters 1e5 x 10", "spheres 1e4",
                                "spheres 1e6", "net ",      "lattice "};
  return std::any_of(shown.begin(), shown.end(), [&](const char* name) { return scene.name.starts_with(name); });
}

}  // namespace

int main(int argc, char** argv) {
  for (const BenchScene& scene : bench_scenes()) {
    for (const int threads : {1, 2}) {
      for (const Phase& phase : phases) {
        if (!is_shown(scene)) continue;
        const std::string name = std::string(phase.name) + "/" + scene.name + "/" + std::to_string(threads);
        benchmark::RegisterBenchmark(name.c_str(), [&scene, &phase, threads](benchmark::State& state) {
          Instant& instant = instant_of(scene, threads);
          for (auto _ : state) phase.work(instant);
          state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(instant.b.size()));
        })->UseRealTime();
      }
    }
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
