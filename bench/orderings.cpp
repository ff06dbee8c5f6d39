// Measures orders of elimination of S = K'K: nets, lattices, clouds and folded nets of rods, for thresholds.hpp.
//   orderings [net K | lattice K | cloud K | folded K …]   default: nets of 100 to 1000, lattices of 20 and 30, clouds
//   of 2000 and 20000 points, a folded net of 300
// Prints processor seconds (ordering and analysis), nonzeros of L, flops, and the rows that a first cut of METIS
// separates
// beside those of the first cut along an axis; "auto" is tanor's choice. Positions are moved by a tenth of the spacing.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "factor/cholesky.hpp"
#include "factor/patterns.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;
using namespace tanor::patterns;

constexpr std::pair<Ordering, const char*> names[] = {{Ordering::Amd, "amd"},
                                                      {Ordering::Axes, "axes"},
                                                      {Ordering::Points, "points"},
                                                      {Ordering::Metis, "metis"},
                                                      {Ordering::Auto, "auto"}};

const char* name_of(Ordering ordering) {
  for (const auto& [own, name] : names) {
    if (own == ordering) return name;
  }
  return "natural";
}

double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

/// Folds the positions, so that coordinates tell nothing about which points are joined.
Rods fold(Rods rods) {
  for (std::size_t k = 0; k < rods.positions.size(); k += 3) {
    const double x = rods.positions[k], y = rods.positions[k + 1];
    rods.positions[k] = 10.0 * std::sin(0.13 * x + 0.07 * y);
    rods.positions[k + 1] = 10.0 * std::cos(0.11 * y - 0.05 * x);
    rods.positions[k + 2] = 10.0 * std::sin(0.09 * (x + y) + 0.2 * std::sin(0.3 * x));
  }
  return rods;
}

Rods make(const std::string& kind, int size) {
  if (kind == "net") return make_net(size, size);
  if (kind == "lattice") return make_lattice(size);
  if (kind == "cloud") return make_cloud(size, 5);
  return fold(make_net(size, size));
}

void measure(const std::string& kind, int size) {
  const Rods rods = make(kind, size);
  const TrianglePattern lower = pattern_of(rods);
  const RowsInSpace points = points_of(rods, kind == "cloud" ? 0.0 : 0.1);
  const double before = processor_seconds();
  const double of_graph = first_cut_of_graph(points), measured = processor_seconds();
  std::printf("%s %d: %zu rods, %zu nonzeros of S; METIS cuts %.2f of what the first axis does (%.3f s)\n",
              kind.c_str(), size, lower.size(), lower.rows.size(), of_graph / dissect_along_axes(points).first_cut,
              measured - before);
  for (const auto& [wanted, name] : names) {
    const double start = processor_seconds();
    const SymbolicAnalysis analysis = analyze(lower, wanted, [&] { return points; });
    std::printf("  %-8s %8.3f s %10.3e nonzeros of L %10.3e flops  %s\n", name, processor_seconds() - start,
                analysis.factor_nonzeros, analysis.flops, name_of(analysis.ordering));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::pair<std::string, int>> scenes;
  for (int k = 1; k + 1 < argc; k += 2) scenes.emplace_back(argv[k], std::atoi(argv[k + 1]));
  if (scenes.empty()) {
    scenes = {{"net", 100},    {"net", 300},    {"net", 1000},    {"lattice", 20},
              {"lattice", 30}, {"cloud", 2000}, {"cloud", 20000}, {"folded", 300}};
  }
  for (const auto& [kind, size] : scenes) measure(kind, size);
}
