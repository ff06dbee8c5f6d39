/// Measures the cost of a final certificate in steps of the run that it ends.
///
///   certificate [repetitions]    ratios of times taken in turn: certificate over one step, medians

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "scenes.hpp"
#include "timing.hpp"

namespace {

/// Makes every second bead heavier, so that Gamma is no multiple of S.
tanor::System make_uneven(tanor::System system) {
  for (std::size_t i = 1; i < system.masses.size(); i += 2) system.masses[i] *= 3.0;
  return system;
}

void compare(const char* name, const tanor::System& system, tanor::Method method, int repetitions) {
  tanor::Simulation simulation(system, {.method = method, .step = 1e-4}, {.threads = 1});
  if (!simulation.advance_to(1e-3).ok()) return;
  std::vector<double> step, certificate;
  std::string line;
  for (int k = 0; k < repetitions; ++k) {
    constexpr int steps = 10;
    step.push_back(seconds_of([&] { (void)simulation.advance_to(simulation.time() + steps * 1e-4); }) / steps);
    certificate.push_back(seconds_of([&] { line = simulation.certify().line(); }));
  }
  std::printf("%-24s %-7s step %10.3f ms   certificate %10.3f ms   ratio %5.1f   %s\n", name,
              std::string(tanor::name_of(method)).c_str(), 1e3 * median(step), 1e3 * median(certificate),
              median(certificate) / median(step), line.c_str());
}

}  // namespace

int main(int argc, char** argv) {
  using tanor::scenes::make_chain, tanor::scenes::make_net;
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 7;
  for (const tanor::Method method : {tanor::Method::Rk4, tanor::Method::Rattle}) {
    compare("chain 1000", make_chain(1000), method, repetitions);
    compare("chain 100000", make_chain(100000), method, repetitions);
    compare("chain 100000, 2 masses", make_uneven(make_chain(100000)), method, repetitions);
    compare("net 30 x 30", make_net(30, 30), method, repetitions);
    compare("net 100 x 100", make_net(100, 100), method, repetitions);
    compare("net 100 x 100, 2 masses", make_uneven(make_net(100, 100)), method, repetitions);
  }
}
