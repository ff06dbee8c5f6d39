#include "evaluate/forces.hpp"

namespace tanor {

void Forces::add_potential(EnergyGroup group, const Numbering& numbering, std::vector<std::pair<Index, Index>>* slots) {
  if (group.points.empty()) return;
  const PotentialFamily& family = potentials_.emplace_back(std::move(group), numbering);
  for (std::size_t i = 0; i < family.points_per_member(); ++i) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      potential_points_.push_back(family.point(k, i));
      slots->push_back({family.point(k, i), static_cast<Index>(slots->size())});
    }
  }
  energies_.resize(energies_.size() + family.size());
  rates_.resize(energies_.size());
  potentials_depend_on_time_ = potentials_depend_on_time_ || family.depends_on_time();
}

/// Families of which stiffness is wanted, in the order of their blocks and influences.
template <class Visit>
void Forces::for_each_stiff_family(const Visit& visit) const {
  for (const PotentialFamily& family : potentials_) visit(family);
  for (const PotentialFamily& family : pair_energies_) visit(family);
}

void Forces::list_own_blocks() {
  std::vector<std::pair<Index, Index>> own;
  for_each_stiff_family([&](const PotentialFamily& family) {
    const std::size_t p = family.points_per_member();
    for (std::size_t k = 0; k < family.size(); ++k) {
      for (std::size_t i = 0; i < p; ++i)
        own.push_back({family.point(k, i), static_cast<Index>(num_stiffness_blocks_ + (k * p + i) * p + i)});
    }
    num_stiffness_blocks_ += family.size() * p * p;
    num_energy_influences_ += family.size() * p * (p - 1);
  });
  own_blocks_ = {num_points_, own};
}

void Forces::evaluate_potentials(const Parallel& parallel, double t, const double* r) {
  std::size_t first_slot = 0, first_member = 0;
  for (const PotentialFamily& family : potentials_) {
    family.evaluate_forces(parallel, t, r, potential_force_.data() + 3 * first_slot, rates_.data() + first_member);
    first_slot += family.size() * family.points_per_member();
    first_member += family.size();
  }
}

void Forces::write_potential_forces(double* f) const {
  for (std::size_t i = 0; i < num_points_; ++i) {
    Vec3 sum{};
    for (const Index slot : potential_forces_[i]) sum = sum + load(potential_force_.data(), slot);
    store(f, i, sum);
  }
}

double Forces::power_of_potentials(const Parallel& parallel) const {
  if (!potentials_depend_on_time_) return 0.0;
  return parallel.sum(rates_.size(), [&](std::size_t k) { return rates_[k]; });
}

std::string Forces::find_undefined(const Parallel& parallel, double t, const double* r) const {
  for (const PotentialFamily& family : potentials_) {
    if (std::string found = family.find_undefined(parallel, t, r); !found.empty()) return found;
  }
  return {};
}

std::vector<Influence> Forces::list_influences() const {
  std::vector<Influence> result;
  const auto append = [&](std::size_t size, std::size_t p, const auto& point) {
    for (std::size_t k = 0; k < size; ++k) {
      for (std::size_t ij = 0; ij < p * p; ++ij) {
        if (ij / p != ij % p) result.push_back({point(k, ij / p), point(k, ij % p)});
      }
    }
  };
  for_each_stiff_family([&](const PotentialFamily& family) {
    append(family.size(), family.points_per_member(), [&](std::size_t k, std::size_t i) { return family.point(k, i); });
  });
  for (const FormulaGroup& group : formulas_) {
    const std::size_t p = group.points_per_member();
    append(group.size(), p, [&](std::size_t k, std::size_t i) { return group.points[k * p + i]; });
  }
  return result;
}

/// -d2U/dr_i dr_j': those with i = j belong to points, the others to influences.
void Forces::add_potential_derivatives(const Parallel& parallel, double t, const double* r, const Derivatives& to) {
  if (num_stiffness_blocks_ == 0) return;
  stiffness_.resize(num_stiffness_blocks_);
  std::size_t first_block = 0, influence = 0;
  for_each_stiff_family([&](const PotentialFamily& family) {
    Block3* const blocks = stiffness_.data() + first_block;
    const std::size_t p = family.points_per_member(), num_blocks = family.size() * p * p;
    family.evaluate_stiffness(parallel, t, r, blocks);
    for (std::size_t n = 0; n < num_blocks; ++n) {
      const std::size_t ij = n % (p * p);
      if (ij / p != ij % p) to.influence_positions[influence++] = blocks[n];
    }
    first_block += num_blocks;
  });
  if (to.influence_velocities != nullptr) std::fill_n(to.influence_velocities, num_energy_influences_, Block3{});
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const Index block : own_blocks_[i]) to.point_positions[i] += stiffness_[static_cast<std::size_t>(block)];
    }
  });
}

}  // namespace tanor
