// Measures a rod's phi with Google Benchmark by three kernels: hand-written, the user's function on jets, a formula.
//   kernels [--benchmark_filter=phi]
// Compare `time a rod`: the bars are 3 times (jet) and 20 times (formula) the hand-written kernel. `phi` is phi alone;
// `right_side` is what a step needs: phi + K'w0 and the blocks of K, gathered from and scattered to all points.

#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include <tanor/user_kernel.hpp>

#include "evaluate/constraints.hpp"
#include "system/tuples.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

constexpr Index num_points = 20000;  // stays in the second cache
constexpr double length = 0.1;

ConstraintKernel jet_rod() {
  return make_constraint_kernel<2>([](const auto& x, const auto&) {
    const auto a = x[3] - x[0], b = x[4] - x[1], c = x[5] - x[2];
    return sqrt(a * a + b * b + c * c) - length;
  });
}

ConstraintKernel formula_rod() {
  return formula_constraint("sqrt((x2-x1)^2 + (y2-y1)^2 + (z2-z1)^2) - length", 2, {{"length", length}});
}

Constraint make_rods(int kind) {
  Rods rods{"", {}, length, {}};
  UserConstraints user{"", {}, kind == 1 ? jet_rod() : formula_rod()};
  for (Index i = 1; i < num_points; ++i) {
    rods.pairs.push_back({i - 1, i});
    user.tuples.push_back({i - 1, i});
  }
  if (kind == 0) return rods;
  return user;
}

struct Chain {
  System system;
  Numbering numbering;
  Constraints constraints;
  std::vector<double> r, v, w, phi, blocks;

  explicit Chain(int kind)
      : system(make_system(kind)),
        numbering(number(system)),
        constraints(system, numbering),
        r(system.positions.size()),
        v(r.size()),
        w(r.size()),
        phi(constraints.num_rows()),
        blocks(3 * constraints.num_blocks()) {
    numbering.gather_points(system.positions, r);
    numbering.gather_points(system.velocities, v);
  }

  static System make_system(int kind) {
    System result;
    for (Index i = 0; i < num_points; ++i) {
      result.positions.insert(result.positions.end(), {0.1 * i, 0.02 * std::sin(0.3 * i), 0.01 * std::cos(i)});
      result.velocities.insert(result.velocities.end(), {std::cos(0.5 * i), 0.0, std::sin(0.2 * i)});
      result.masses.push_back(1.0);
    }
    result.constraints = {make_rods(kind)};
    return result;
  }
};

void report(benchmark::State& state) {
  state.counters["time a rod"] =
      benchmark::Counter(num_points - 1, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void right_side(benchmark::State& state, int kind) {
  Chain chain(kind);
  const Parallel serial(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(chain.constraints.evaluate_right_side(
        serial, chain.r.data(), chain.v.data(), chain.w.data(), chain.phi.data(), chain.blocks.data()));
  }
  report(state);
}

/// Runs the hand-written kernel in a loop of its own.
void phi_by_hand(benchmark::State& state) {
  Chain chain(0);
  RodKernel<false, false> kernel;
  for (Index i = 1; i < num_points; ++i) kernel.points.push_back({i - 1, i});
  kernel.length.assign(kernel.points.size(), length);
  for (auto _ : state) {
    for (std::size_t k = 0; k < kernel.points.size(); ++k) {
      chain.phi[k] = kernel(k, chain.r.data(), chain.v.data()).phi[0];
    }
    benchmark::ClobberMemory();
  }
  report(state);
}

/// Runs a batch kernel with its gathers.
void phi_by_kernel(benchmark::State& state, const ConstraintKernel& kernel) {
  Chain chain(0);
  std::vector<Index> points;
  for (Index i = 1; i < num_points; ++i) points.insert(points.end(), {i - 1, i});
  for (auto _ : state) {
    for_each_chunk<false>(kernel, points, 0, points.size() / 2, 0.0, chain.r.data(), chain.v.data(),
                          [&](const TupleValues& values) {
                            for (std::size_t k = 0; k < values.count; ++k) chain.phi[values.first + k] = values.phi[k];
                          });
    benchmark::ClobberMemory();
  }
  report(state);
}

BENCHMARK(phi_by_hand)->Name("phi/hand");
BENCHMARK_CAPTURE(phi_by_kernel, jet, jet_rod())->Name("phi/jet");
BENCHMARK_CAPTURE(phi_by_kernel, formula, formula_rod())->Name("phi/formula");
BENCHMARK_CAPTURE(right_side, hand, 0)->Name("right_side/hand");
BENCHMARK_CAPTURE(right_side, jet, 1)->Name("right_side/jet");
BENCHMARK_CAPTURE(right_side, formula, 2)->Name("right_side/formula");

}  // namespace

BENCHMARK_MAIN();
