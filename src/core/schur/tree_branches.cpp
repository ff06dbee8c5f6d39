#include "schur/tree_branches.hpp"

#include <algorithm>
#include <utility>

namespace tanor::detail {

TreeBranches::TreeBranches(EqualBranches plan, const RodRows& given, std::span<const double> inverse_mass, int threads)
    : plan_(std::move(plan)) {
  read_rods(given, inverse_mass);
  read_offsets(given.offset);
  prepare_workspaces(threads);
}

void TreeBranches::read_rods(const RodRows& given, std::span<const double> inverse_mass) {
  const std::size_t num_rods = plan_.num_rods();
  blocks_.resize(num_rods * num_lanes);
  if (!given.lengths.empty()) moving_lengths_.resize(num_rods * num_lanes, nullptr);
  length_.resize(num_rods);
  rods_.resize(num_rods);
  rows_.resize(num_rods);
  inverse_mass_.resize(num_rods + plan_.batches.size());
  for (std::vector<double>* array : {&right_side_, &residual_}) array->resize(plan_.batches.size() * num_lanes);
  for (const BranchBatch& batch : plan_.batches) {
    const trees::Shape shape = plan_.shape(batch);
    for (std::size_t lane = 0; lane < num_lanes; ++lane) {
      for (std::size_t k = 0; k < shape.num_points(); ++k) {
        const auto point = batch.first_point[lane] + static_cast<Index>(k);
        inverse_mass_.data()[batch.first_place + k][lane] = inverse_mass[static_cast<std::size_t>(point)];
        if (k == shape.num_rods) continue;
        const std::size_t row = static_cast<std::size_t>(batch.first_row[lane]) + k, rod = batch.first_rod + k;
        const bool is_turned = given.ends[row][0] != point;
        const auto block = static_cast<Index>(given.block[row]);
        blocks_[rod * num_lanes + lane] = is_turned ? ~block : block;
        length_.data()[rod][lane] = given.constant_length[row];
        if (!given.lengths.empty()) moving_lengths_[rod * num_lanes + lane] = given.moving_length(row);
      }
    }
  }
}

void TreeBranches::read_offsets(std::span<const Vec3> by_row) {
  if (by_row.empty()) return;
  offsets_.resize(plan_.num_rods());
  for (const BranchBatch& batch : plan_.batches) {
    for (std::size_t k = 0; k < plan_.shape(batch).num_rods; ++k) {
      const std::size_t rod = batch.first_rod + k;
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const Vec3 offset = by_row[static_cast<std::size_t>(batch.first_row[lane]) + k];
        const bool is_turned = blocks_[rod * num_lanes + lane] < 0;
        set_lane(&offsets_[rod], lane, is_turned ? -offset : offset);
      }
    }
  }
}

void TreeBranches::prepare_workspaces(int threads) {
  workspaces_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  std::size_t most_points = 0;
  for (const std::vector<Index>& parent : plan_.parents) most_points = std::max(most_points, parent.size() + 1);
  for (Workspace& work : workspaces_) {
    for (auto* points : {&work.r, &work.v, &work.w, &work.s, &work.dw, &work.u}) points->resize(most_points);
    work.mobility.resize(most_points);
    for (Packs* rods : {&work.rows, &work.length_second}) rods->resize(most_points);
  }
}

void TreeBranches::forget_findings() {
  for (Workspace& work : workspaces_) work.largest_inverse = {};
}

trees::LargestInverse TreeBranches::largest_inverse() const {
  trees::LargestInverse all;
  for (const Workspace& work : workspaces_) all.see(work.largest_inverse.value);
  return all;
}

}  // namespace tanor::detail
