// Google Benchmark of the phases of one instant, by scene and threads: evaluate, assemble, factorize, solve, gather.
//   phases [--benchmark_filter=chain]
// `items_per_second` counts rods.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>

#include "assembly/reactions.hpp"
#include "evaluate/constraints.hpp"
#include "solve/gram_solver.hpp"

namespace {

using namespace tanor;

/// A net of columns x rows points with waves across it; one row: a chain.
System make_net(int columns, int rows) {
  System system;
  Rods rods;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double x = 0.1 * i, y = 0.1 * j;
      system.positions.insert(system.positions.end(), {x, y, 0.02 * std::sin(3.0 * x + y)});
      system.velocities.insert(system.velocities.end(), {0.0, 0.0, std::cos(5.0 * x - 2.0 * y)});
      system.masses.push_back(0.1);
      const int point = j * columns + i;
      if (i > 0) rods.pairs.push_back({point - 1, point});
      if (j > 0) rods.pairs.push_back({point - columns, point});
    }
  }
  system.constraints = {rods};
  return system;
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
        inverse_masses(system.num_points(), 10.0),
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

template <class Phase>
void run(benchmark::State& state, const Phase& phase) {
  Instant instant(make_net(static_cast<int>(state.range(0)), static_cast<int>(state.range(1))),
                  static_cast<int>(state.range(2)));
  for (auto _ : state) phase(instant);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(instant.b.size()));
}

void evaluate(benchmark::State& state) {
  run(state, [](Instant& i) {
    i.constraints.evaluate_right_side(i.parallel, i.r.data(), i.v.data(), i.w.data(), i.b.data(), i.blocks.data());
  });
}
void assemble(benchmark::State& state) {
  run(state, [](Instant& i) { i.solver.assemble(i.parallel, i.blocks.data()); });
}
void factorize(benchmark::State& state) {
  run(state, [](Instant& i) { benchmark::DoNotOptimize(i.solver.factorize(i.parallel)); });
}
void solve(benchmark::State& state) {
  run(state, [](Instant& i) { i.solver.solve_negative(i.parallel, i.b.data(), i.lambda.data()); });
}
void reactions(benchmark::State& state) {
  run(state, [](Instant& i) { i.gather.reactions(i.parallel, i.blocks.data(), i.lambda.data(), i.w.data()); });
}

void scenes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"columns", "rows", "threads"})->UseRealTime();
  constexpr std::array<std::array<int, 2>, 4> sizes{{{10000, 1}, {1000000, 1}, {30, 30}, {100, 100}}};
  for (const auto& [columns, rows] : sizes) {
    for (const int threads : {1, 2}) benchmark->Args({columns, rows, threads});
  }
}

BENCHMARK(evaluate)->Apply(scenes);
BENCHMARK(assemble)->Apply(scenes);
BENCHMARK(factorize)->Apply(scenes);
BENCHMARK(solve)->Apply(scenes);
BENCHMARK(reactions)->Apply(scenes);

}  // namespace

BENCHMARK_MAIN();
