// Finds equilibria of large systems and prints run time on one core, iterations and residual.
//
//   statics          a net of 100 x 100 points hung by two corners from a flat start; hanging chains of 10^4 and
//                    10^5 rods
//   statics N        the net alone, with N x N points

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <tanor/equilibrium.hpp>

#include "scenes.hpp"

namespace {

using namespace tanor;

/// Makes a chain of unit length between supports 0.7 apart, from a sine.
System make_slack_chain(int count) {
  System system;
  Rods rods{.name = "rods"};
  rods.length.constants = {1.0 / count};
  for (int i = 0; i <= count; ++i) {
    const double s = static_cast<double>(i) / count;
    system.positions.insert(system.positions.end(), {0.7 * s, -0.3 * std::sin(M_PI * s), 0.0});
    system.masses.push_back(1.0 / count);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.constraints.push_back(rods);
  system.supports.push_back({"", {0, count}, {}});
  system.add_gravity({0.0, -9.81, 0.0});
  return system;
}

void measure(const char* name, const System& system) {
  SolverOptions one_core;
  one_core.threads = 1;
  const std::clock_t begin = std::clock();
  const EquilibriumResult found = find_equilibrium(system, {.solver = one_core});
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%-22s %7.3f s CPU  %3d iterations  %3d factors  residual %.1e of the largest force  %s\n", name, seconds,
              found.search.iterations, found.search.factorizations, found.residual_force / found.largest_force,
              found.outcome.ok() ? "stable" : found.outcome.what.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) {
    measure("net", tanor::scenes::make_hung_net(std::atoi(argv[1])));
    return 0;
  }
  measure("net of 100 x 100", tanor::scenes::make_hung_net(100));
  measure("chain of 10^4 rods", make_slack_chain(10'000));
  measure("chain of 10^5 rods", make_slack_chain(100'000));
}
