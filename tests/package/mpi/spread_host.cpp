// A host program moves eight pendulums on the ranks of MPI. Each rank compares its own with the same pendulums on one
// rank; the exit code is 1 if any answer is wrong.

#include <tanor_mpi.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <vector>

#include <tanor/motion.hpp>

namespace {

tanor::System make_pendulums(int count) {
  tanor::System system;
  tanor::Rods rods;
  tanor::Support hooks{.name = "hooks", .points = {}, .displacement = {}};
  for (int k = 0; k < count; ++k) {
    system.positions.insert(system.positions.end(), {1.0 * k, 0.0, 0.0, 1.0 * k + 0.1 + 0.01 * k, 0.0, 0.0});
    system.masses.insert(system.masses.end(), {0.1, 0.1});
    hooks.points.push_back(2 * k);
    rods.pairs.push_back({2 * k, 2 * k + 1});
  }
  system.supports = {hooks};
  system.constraints = {rods};
  system.forces = {tanor::Gravity{.name = "", .acceleration = {0.0, 0.0, -9.81}}};
  return system;
}

// Returns the largest difference of this rank's own points from those of a run on one rank, m.
double move(MPI_Comm communicator) {
  const tanor::System system = make_pendulums(8);
  tanor::MpiRanks ranks(communicator);
  const tanor::RankSystem own = tanor::take_part(system, tanor::assign_owners(system, ranks.size()), ranks);
  tanor::Simulation spread(own.system, own.part), alone(system);
  if (!spread.advance_to(0.5).ok() || !alone.advance_to(0.5).ok()) return 1.0;
  double largest = own.num_owned < system.num_points() ? 0.0 : 1.0;  // each rank has a part
  for (std::size_t i = 0; i < own.num_owned; ++i)
    for (std::size_t c = 0; c < 3; ++c)
      largest = std::max(largest, std::abs(spread.positions()[3 * i + c] -
                                           alone.positions()[3 * static_cast<std::size_t>(own.points[i]) + c]));
  return largest;
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const double error = move(MPI_COMM_WORLD);
  std::printf("largest difference from one rank: %.2e m\n", error);
  MPI_Finalize();
  return error < 1e-12 ? 0 : 1;
}
