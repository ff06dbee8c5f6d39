#include "schur/lane_groups.hpp"

#include "plan/thresholds.hpp"

namespace tanor::detail {

// ---- the plan ----

LaneGroups::LaneGroups(LanePlan plan, const RodRows& given, std::span<const double> inverse_mass,
                       std::size_t num_moving, int threads)
    : plan_(std::move(plan)), num_moving_(static_cast<Index>(num_moving)) {
  read_rods(given);
  read_masses(inverse_mass);
  for (const LaneGroup& group : plan_.groups) {
    lists_.push_back({{plan_.point.data() + num_lanes * group.first_place, group.num_places},
                      {block_.data() + num_lanes * group.first_rod, group.num_rods},
                      {plan_.row.data() + num_lanes * group.first_rod, group.num_rods}});
  }
  prepare_workspaces(threads);
}

/// Calls visit(group, k-th rod, lane, whether there is one, the point at its first place).
template <class Visit>
void LaneGroups::for_each_rod(const Visit& visit) const {
  for (const LaneGroup& group : plan_.groups) {
    for (std::size_t k = 0; k < group.num_rods; ++k) {
      const std::size_t rod = group.first_rod + k,
                        first = group.schedule == nullptr
                                    ? k
                                    : static_cast<std::size_t>(group.schedule->topology.rods[k][0]);
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Index point = plan_.point[(group.first_place + first) * num_lanes + lane];
        visit(group, k, lane, plan_.row[rod * num_lanes + lane] >= 0, point < 0 ? ~point : point);
      }
    }
  }
}

void LaneGroups::read_rods(const RodRows& given) {
  const std::size_t num_rods = plan_.num_slots();
  block_.assign(num_rods * num_lanes, no_block);
  for (Packs* const moving : {&length_first_, &length_second_}) {
    if (!given.moving_length.empty()) moving->resize(num_rods);
  }
  length_.resize(num_rods);
  are_shifted_ = !given.offset.empty();
  for (LaneGroup& group : plan_.groups) {
    group.first_offset = offset_.size();
    if (are_shifted_ || group.is_padded) offset_.resize(offset_.size() + group.num_rods);
  }
  for_each_rod([&](const LaneGroup& group, std::size_t k, std::size_t lane, bool is_there, Index first) {
    const std::size_t rod = group.first_rod + k, slot = rod * num_lanes + lane;
    length_.data()[rod][lane] = 1.0;
    // The offset of a rod of nobody gives it a direction.
    if (!is_there) return set_lane(&offset_[group.first_offset + k], lane, {1.0, 0.0, 0.0});
    const auto row = static_cast<std::size_t>(plan_.row[slot]);
    const auto block = static_cast<Index>(given.block[row]);
    block_[slot] = given.ends[row][0] == first ? block : ~block;
    length_.data()[rod][lane] = given.constant_length[row];
    if (!given.moving_length.empty() && given.moving_length[row] != nullptr)
      moving_lengths_.emplace_back(slot, given.moving_length[row]);
  });
  read_offsets(given.offset);
}

void LaneGroups::read_masses(std::span<const double> inverse_mass) {
  inverse_mass_.resize(plan_.num_places());
  for (std::size_t k = 0; k < plan_.point.size(); ++k) {
    const Index point = plan_.point[k];
    inverse_mass_.data()[k / num_lanes][k % num_lanes] =
        inverse_mass[static_cast<std::size_t>(point < 0 ? ~point : point)];
  }
  // Rods of nobody join free points to one that never moves, which leaves them out of all that is found.
  for (const LaneGroup& group : plan_.groups) {
    Pack<>* const own = inverse_mass_.data() + group.first_place;
    for (std::size_t lane = 0; lane < num_lanes && group.is_padded && plan_.is_of_trees(); ++lane) {
      for (std::size_t k = 0; k < group.num_rods && plan_.row[(group.first_rod + k) * num_lanes + lane] < 0; ++k)
        own[k][lane] = 1.0;
      own[group.num_rods + 1][lane] = 0.0;
    }
  }
}

void LaneGroups::read_offsets(std::span<const Vec3> by_row) {
  if (by_row.empty()) return;
  for_each_rod([&](const LaneGroup& group, std::size_t k, std::size_t lane, bool is_there, Index) {
    const std::size_t slot = (group.first_rod + k) * num_lanes + lane;
    if (!is_there) return;
    const Vec3 offset = by_row[static_cast<std::size_t>(plan_.row[slot])];
    set_lane(&offset_[group.first_offset + k], lane, block_[slot] < 0 ? -offset : offset);
  });
}

void LaneGroups::take_lengths() {
  for (const auto& [slot, length] : moving_lengths_) {
    const std::size_t rod = slot / num_lanes, lane = slot % num_lanes;
    length_.data()[rod][lane] = length->value;
    length_first_.data()[rod][lane] = length->first;
    length_second_.data()[rod][lane] = length->second;
  }
}

std::size_t LaneGroups::num_shares(std::size_t num_slots, const Parallel& parallel) const {
  const std::size_t most = std::min(workspaces_.size(), static_cast<std::size_t>(parallel.threads()));
  return std::clamp<std::size_t>(num_slots * num_lanes / plan::rows_of_lanes_worth_a_thread, 1, most);
}

void LaneGroups::prepare_workspaces(int threads) {
  factor_.resize(plan_.size_of_factor);
  if (plan_.is_of_trees()) {
    u_.resize(plan_.num_slots());
    joints_.resize(plan_.groups.size());
  }
  if (plan_.is_of_paths()) borders_.resize(plan_.groups.size());
  std::size_t of_group = 0;
  for (const LaneGroup& group : plan_.groups) of_group = std::max(of_group, group.num_places);
  workspaces_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  for (Workspace& work : workspaces_) {
    // Threads share what is more than one thread's, in the arrays of the first one.
    LanePlan::Extent& most = work.largest = {0, of_group, of_group};
    for (std::size_t grove = 0; grove < plan_.num_groves(); ++grove) {
      const LanePlan::Extent own = plan_.extent(grove);
      if (&work != workspaces_.data() && 2 * own.rods > plan_.num_slots()) continue;
      most = {std::max(most.groups, own.groups), std::max(most.rods, own.rods), std::max(most.places, own.places)};
    }
    for (auto* points : {&work.r, &work.v, &work.w, &work.s, &work.dw}) points->resize(of_group);
    if (plan_.is_of_trees()) work.mobility.resize(of_group);
    work.b.resize(most.rods);
    for (Packs* groups : {&work.right_side, &work.residual}) groups->resize(most.groups);
  }
  hold(Pass::Single);
}

void LaneGroups::hold(Pass pass) {
  const auto grow = [](auto* array, std::size_t size) {
    if (array->size() < size) array->resize(size);
  };
  for (Workspace& work : workspaces_) {
    const bool is_of_group = goes_through_memory(pass);
    const std::size_t rods = is_of_group ? work.r.size() : work.largest.rods;
    if (!plan_.is_of_trees()) grow(&work.u, rods);
    grow(&work.z, rods);
    grow(&work.points, is_of_group ? work.r.size() : work.largest.places);
    if (pass == Pass::Single) continue;
    grow(&work.directions, rods);
    grow(&work.sum, rods);
  }
}

}  // namespace tanor::detail
