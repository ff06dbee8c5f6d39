// Measures multifrontal factors of S = K'K of nets and lattices of rods, on one thread and on N in turn:
//   fronts [--threads N] [--rounds R] [net K | lattice K …]   default: 2 threads, nets of 100 and 300, lattices of 10
//   to 30
// Prints medians: ms and Gflop/s of a factorization, ms and GB/s of a solve (it reads L twice), the speedup by N
// threads, and the storage of fronts' updates beside L. The program fails if two numbers of threads give different
// bits.

#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "factor/cholesky.hpp"
#include "factor/multifrontal.hpp"
#include "factor/patterns.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;
using namespace tanor::patterns;

/// Returns the values of S = C'C beside the pattern's rows; row k is that of column order[k] of C.
std::vector<double> values_of(const SparseColumns& C, const TrianglePattern& lower, const std::vector<int>& order) {
  std::vector<double> dense(static_cast<std::size_t>(C.num_rows), 0.0), values;
  const auto visit = [&](std::size_t place, const auto& body) {
    const std::size_t column = order.empty() ? place : static_cast<std::size_t>(order[place]);
    for (auto e = static_cast<std::size_t>(C.start[column]); e < static_cast<std::size_t>(C.start[column + 1]); ++e)
      body(static_cast<std::size_t>(C.rows[e]), C.values[e]);
  };
  for (std::size_t j = 0; j < lower.size(); ++j) {
    visit(j, [&](std::size_t row, double value) { dense[row] = value; });
    for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]); ++e) {
      double sum = 0.0;
      visit(static_cast<std::size_t>(lower.rows[e]), [&](std::size_t row, double value) { sum += value * dense[row]; });
      values.push_back(sum);
    }
    visit(j, [&](std::size_t row, double) { dense[row] = 0.0; });
  }
  return values;
}

struct Times {
  std::vector<double> factor, solve;
};

void measure(const std::string& kind, int side, int most_threads, int rounds) {
  const Rods rods = kind == "net" ? make_net(side, side) : make_lattice(side);
  const SymbolicAnalysis analysis = analyze(pattern_of(rods), Ordering::Auto, [&] { return points_of(rods, 0.1); });
  const TrianglePattern lower = pattern_of(rods, analysis.permutation);
  const std::vector<double> values = values_of(gradients_of(rods, 1), lower, analysis.permutation);
  Multifrontal factor(lower);
  const std::vector<int> counts{1, most_threads};
  std::vector<Times> times(counts.size());
  std::vector<std::vector<double>> x(counts.size());
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t k = 0; k < counts.size(); ++k) {
      const double factorized = seconds_of([&] {
        if (!factor.factorize(values.data(), counts[k]).positive_definite)
          throw std::runtime_error("not positive definite");
      });
      x[k].assign(lower.size(), 1.0);
      const double solved = seconds_of([&] { factor.solve(x[k].data(), counts[k]); });
      if (round == 0) continue;  // wakes memory
      times[k].factor.push_back(factorized);
      times[k].solve.push_back(solved);
    }
    if (x.front() != x.back()) throw std::runtime_error("the bits depend on the number of threads");
  }
  const double one = median(times[0].factor), more = median(times[1].factor);
  const double solve_one = median(times[0].solve), solve_more = median(times[1].solve);
  const double bytes = 2.0 * 8.0 * analysis.factor_nonzeros;
  std::printf("%-8s%4d %9.1e %9.3f %8.1f %7.2f %9.3f %8.1f %7.2f %6.1f %%\n", kind.c_str(), side, analysis.flops,
              1e3 * one, analysis.flops / one / 1e9, one / more, 1e3 * solve_one, bytes / solve_one / 1e9,
              solve_one / solve_more,
              1e2 * static_cast<double>(factor.num_beside()) / static_cast<double>(factor.num_stored()));
}

}  // namespace

int main(int argc, char** argv) {
  int threads = 2, rounds = 21;
  std::vector<std::pair<std::string, int>> scenes;
  for (int k = 1; k + 1 < argc; k += 2) {
    const std::string key = argv[k];
    const int value = std::atoi(argv[k + 1]);
    if (key == "--threads")
      threads = value;
    else if (key == "--rounds")
      rounds = value;
    else
      scenes.emplace_back(key, value);
  }
  if (scenes.empty()) scenes = {{"net", 100}, {"net", 300}, {"lattice", 10}, {"lattice", 20}, {"lattice", 30}};
  std::printf("                 flops factor ms Gflop/s 1/%d thr  solve ms     GB/s 1/%d thr beside L\n", threads,
              threads);
  for (const auto& [kind, side] : scenes) measure(kind, side, threads, rounds);
}
