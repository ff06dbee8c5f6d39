#include "evaluate/forces.hpp"

namespace tanor {

void Forces::add_potential(const EnergyGroup& group, const Numbering& numbering,
                           std::vector<std::pair<Index, Index>>* slots) {
  if (group.points.empty()) return;
  const PotentialFamily& family = potentials_.emplace_back(group, numbering);
  const std::size_t p = family.points_per_member(), first_block = num_stiffness_blocks_;
  for (std::size_t k = 0; k < family.size(); ++k) {
    for (std::size_t i = 0; i < p; ++i) {
      slots->push_back({family.point(k, i), static_cast<Index>(slots->size())});
      potential_points_.push_back(family.point(k, i));
      own_block_.push_back(first_block + (k * p + i) * p + i);
    }
  }
  num_stiffness_blocks_ += family.size() * p * p;
  energies_.resize(energies_.size() + family.size());
  rates_.resize(energies_.size());
  potentials_depend_on_time_ = potentials_depend_on_time_ || family.depends_on_time();
}

void Forces::evaluate_potentials(const Parallel& parallel, double t, const double* r) {
  std::size_t first_slot = 0, first_member = 0;
  for (const PotentialFamily& family : potentials_) {
    family.evaluate_forces(parallel, t, r, potential_force_.data() + 3 * first_slot, rates_.data() + first_member);
    first_slot += family.size() * family.points_per_member();
    first_member += family.size();
  }
}

std::vector<Influence> Forces::list_influences() const {
  std::vector<Influence> result;
  for (const PotentialFamily& family : potentials_) {
    const std::size_t p = family.points_per_member();
    for (std::size_t k = 0; k < family.size(); ++k) {
      for (std::size_t ij = 0; ij < p * p; ++ij) {
        if (ij / p != ij % p) result.push_back({family.point(k, ij / p), family.point(k, ij % p)});
      }
    }
  }
  return result;
}

/// -d2U/dr_i dr_j': those with i = j belong to points, the others to influences.
void Forces::add_potential_derivatives(const Parallel& parallel, double t, const double* r, const Derivatives& to) {
  if (potentials_.empty()) return;
  stiffness_.resize(num_stiffness_blocks_);
  std::size_t first_block = 0, influence = 0;
  for (const PotentialFamily& family : potentials_) {
    Block3* const blocks = stiffness_.data() + first_block;
    const std::size_t p = family.points_per_member(), num_blocks = family.size() * p * p;
    family.evaluate_stiffness(parallel, t, r, blocks);
    for (std::size_t n = 0; n < num_blocks; ++n) {
      const std::size_t ij = n % (p * p);
      if (ij / p != ij % p) to.influence_positions[influence++] = blocks[n];
    }
    first_block += num_blocks;
  }
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const Index slot : potential_forces_[i]) {
        const Block3& own = stiffness_[own_block_[static_cast<std::size_t>(slot)]];
        for (std::size_t entry = 0; entry < 9; ++entry) to.point_positions[i].entries[entry] += own.entries[entry];
      }
    }
  });
}

}  // namespace tanor
