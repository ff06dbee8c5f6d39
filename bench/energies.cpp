// Measures the cost of energies of tuples (bonds, bendings, torsions) in an evaluation of the forces, one thread.
//
//   energies SCENE [ROUNDS]      200
//
// Pair forces are left out. The program prints the median of the processor's times, ms: forces, and forces with
// energies U.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "evaluate/forces.hpp"
#include "scene/scene.hpp"

namespace {

double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

template <class Work>
double median_ms(int rounds, const Work& work) {
  std::vector<double> times;
  for (int round = 0; round < rounds; ++round) {
    const double begin = processor_time();
    work();
    times.push_back(1e3 * (processor_time() - begin));
  }
  std::nth_element(times.begin(), times.begin() + rounds / 2, times.end());
  return times[static_cast<std::size_t>(rounds / 2)];
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 200;
  tanor::System system = tanor::scene::load_scene(argv[1]).system;
  std::erase_if(system.forces,
                [](const tanor::Force& force) { return std::holds_alternative<tanor::PairForces>(force); });
  const tanor::Numbering numbering = tanor::number(system);
  tanor::Forces forces(system, numbering);
  const tanor::Parallel serial(1);
  std::vector<double> r(system.positions.size()), v(r.size(), 0.0), f(r.size());
  numbering.gather_points(system.positions, r);
  const double of_forces = median_ms(rounds, [&] { forces.evaluate(serial, 0.0, r.data(), v.data(), f.data()); });
  double energy = 0.0;
  const double of_energies = median_ms(rounds, [&] { energy = forces.potential(serial, 0.0, r.data()); });
  std::printf("%.4f ms forces, %.4f ms energies, U = %.10g, f[0] = %.10g\n", of_forces, of_energies, energy, f[0]);
}
