#include "evaluate/energy_forces.hpp"

#include <algorithm>

namespace tanor::detail {

EnergyForces::EnergyForces(const Numbering& numbering, std::vector<EnergyGroup> groups,
                           std::vector<EnergyGroup> of_pairs)
    : num_points_(numbering.num_points()), num_moving_(numbering.num_moving) {
  const auto add_to = [&](std::vector<PotentialFamily>* families, EnergyGroup& group) {
    if (!group.points.empty()) families->emplace_back(std::move(group), numbering);
  };
  for (EnergyGroup& group : groups) add_to(&families_, group);
  for (EnergyGroup& group : of_pairs) add_to(&pair_families_, group);
  list_slots();
  list_own_blocks();
}

void EnergyForces::list_slots() {
  std::size_t num_tuples = 0;
  for (const PotentialFamily& family : families_) {
    for (std::size_t i = 0; i < family.points_per_member(); ++i) {
      for (std::size_t k = 0; k < family.size(); ++k) points_.push_back(family.point(k, i));
    }
    num_tuples += family.size();
    depends_on_time_ = depends_on_time_ || family.depends_on_time();
  }
  energies_.resize(num_tuples);
  rates_.resize(num_tuples);
  on_points_ = {num_points_, points_};
}

/// Visits the families of which stiffness is wanted, in the order of their blocks and influences.
template <class Visit>
void EnergyForces::for_each_stiff_family(const Visit& visit) const {
  for (const PotentialFamily& family : families_) visit(family);
  for (const PotentialFamily& family : pair_families_) visit(family);
}

void EnergyForces::list_own_blocks() {
  std::vector<std::pair<Index, Index>> own;
  for_each_stiff_family([&](const PotentialFamily& family) {
    const std::size_t p = family.points_per_member();
    for (std::size_t k = 0; k < family.size(); ++k) {
      for (std::size_t i = 0; i < p; ++i)
        own.push_back({family.point(k, i), static_cast<Index>(num_blocks_ + (k * p + i) * p + i)});
    }
    num_blocks_ += family.size() * p * p;
    num_influences_ += family.size() * p * (p - 1);
  });
  own_blocks_ = {num_points_, own};
}

void EnergyForces::evaluate(const Parallel& parallel, double t, const double* r) {
  std::size_t first_slot = 0, first_member = 0;
  for (const PotentialFamily& family : families_) {
    family.evaluate_forces(parallel, t, r, on_points_.slot(first_slot), rates_.data() + first_member);
    first_slot += family.size() * family.points_per_member();
    first_member += family.size();
  }
}

void EnergyForces::write_forces(double* f) const {
  for (std::size_t i = 0; i < num_points_; ++i) {
    Vec3 sum{};
    on_points_.for_each_on(i, [&](Vec3 force) { sum = sum + force; });
    store(f, i, sum);
  }
}

double EnergyForces::energy(const Parallel& parallel, double t, const double* r) {
  std::size_t first = 0;
  for (const PotentialFamily& family : families_) {
    family.evaluate_energies(parallel, t, r, energies_.data() + first);
    first += family.size();
  }
  return parallel.sum(energies_.size(), [&](std::size_t k) { return energies_[k]; });
}

double EnergyForces::explicit_rate(const Parallel& parallel) const {
  if (!depends_on_time_) return 0.0;
  return parallel.sum(rates_.size(), [&](std::size_t k) { return rates_[k]; });
}

double EnergyForces::power_of_supports(const Parallel& parallel, const double* v) const {
  // The support does the work -(force on it).velocity on the energy.
  return parallel.sum(points_.size(), [&](std::size_t slot) {
    const Index point = points_[slot];
    return moves(point) ? 0.0 : -dot(on_points_[slot], load(v, point));
  });
}

std::string EnergyForces::find_undefined(const Parallel& parallel, double t, const double* r) const {
  for (const PotentialFamily& family : families_) {
    if (std::string found = family.find_undefined(parallel, t, r); !found.empty()) return found;
  }
  return {};
}

// ---- stiffness ----

void EnergyForces::append_influences(std::vector<Influence>* list) const {
  for_each_stiff_family([&](const PotentialFamily& family) {
    const auto point = [&](std::size_t k, std::size_t i) { return family.point(k, i); };
    detail::append_influences(family.size(), family.points_per_member(), point, list);
  });
}

void EnergyForces::add_derivatives(const Parallel& parallel, double t, const double* r, const ForceDerivatives& to) {
  if (num_blocks_ == 0) return;
  stiffness_.resize(num_blocks_);
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
  if (to.influence_velocities != nullptr) std::fill_n(to.influence_velocities, num_influences_, Block3{});
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (const Index block : own_blocks_[i]) to.point_positions[i] += stiffness_[static_cast<std::size_t>(block)];
    }
  });
}

}  // namespace tanor::detail
