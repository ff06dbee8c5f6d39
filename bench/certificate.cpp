/// What a final certificate costs, in steps of the run that it ends.
///
///   certificate [repetitions]    ratios of times taken in turn: certificate over one step, medians

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

namespace {

using Clock = std::chrono::steady_clock;

template <class Work>
double seconds(const Work& work) {
  const auto begin = Clock::now();
  work();
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Columns x rows of beads, rods between neighbours; two opposite corners held. One row: a hanging chain. Every second
/// bead may be heavier: then Gamma is no multiple of S.
tanor::System make_net(int columns, int rows, double second_mass = 0.1) {
  tanor::System system;
  tanor::Rods rods{"rods", {}, {}, {}};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int point = j * columns + i;
      system.positions.insert(system.positions.end(), {0.1 * i, 0.1 * j, 0.0});
      system.masses.push_back(point % 2 == 0 ? 0.1 : second_mass);
      if (i > 0) rods.pairs.push_back({point - 1, point});
      if (j > 0) rods.pairs.push_back({point - columns, point});
    }
  }
  system.supports = {{"", {0}, {}}};
  if (rows > 1) system.supports.push_back({"", {columns * rows - 1}, {}});
  system.constraints = {rods};
  system.forces = {tanor::Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

void compare(const char* name, const tanor::System& system, tanor::Method method, int repetitions) {
  tanor::Simulation simulation(system, {.method = method, .step = 1e-4}, {.threads = 1});
  if (!simulation.advance_to(1e-3).ok()) return;
  std::vector<double> step, certificate;
  std::string line;
  for (int k = 0; k < repetitions; ++k) {
    constexpr int steps = 10;
    step.push_back(seconds([&] { (void)simulation.advance_to(simulation.time() + steps * 1e-4); }) / steps);
    certificate.push_back(seconds([&] { line = simulation.certify().line(); }));
  }
  std::printf("%-24s %-7s step %10.3f ms   certificate %10.3f ms   ratio %5.1f   %s\n", name,
              std::string(tanor::name_of(method)).c_str(), 1e3 * median(step), 1e3 * median(certificate),
              median(certificate) / median(step), line.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 7;
  for (const tanor::Method method : {tanor::Method::Rk4, tanor::Method::Rattle}) {
    compare("chain 1000", make_net(1001, 1), method, repetitions);
    compare("chain 100000", make_net(100001, 1), method, repetitions);
    compare("chain 100000, 2 masses", make_net(100001, 1, 0.3), method, repetitions);
    compare("net 30 x 30", make_net(30, 30), method, repetitions);
    compare("net 100 x 100", make_net(100, 100), method, repetitions);
    compare("net 100 x 100, 2 masses", make_net(100, 100, 0.3), method, repetitions);
  }
}
