#pragma once

#include <algorithm>

#include "schur/batch_kernels.hpp"
#include "schur/schur_solver.hpp"
#include "schur/tree_branches.hpp"

/// \file The operations of TreeSolver and TreeSeries on branches, batch by batch.
namespace tanor::detail {

/// One batch in the lanes of a workspace.
class TreeBranches::Lanes {
 public:
  Lanes(TreeBranches* all, std::size_t batch, TreePoints* joints, std::size_t workspace)
      : all_(*all),
        number_(batch),
        batch_(all->plan_.batches[batch]),
        joints_(*joints),
        work_(all->workspaces_[workspace]) {}

  /// Reads r, v and w0 of the points and l'' of the rods.
  trees::BranchMotion read_motion(const FreeMotion& motion) {
    read_points(motion.r, &work_.r);
    read_points(motion.v, &work_.v);
    if (motion.uniform == nullptr) read_points(motion.w0, &work_.w);
    return {.r = work_.r.data(),
            .v = work_.v.data(),
            .w0 = motion.uniform == nullptr ? work_.w.data() : nullptr,
            .offset = offsets(),
            .length_second = read_length_seconds()};
  }
  void evaluate(const trees::BranchMotion& motion) {
    Largest right_side;
    trees::evaluate(shape_, motion, rods(), rows(), &right_side);
    note_right_side(right_side);
  }
  void eliminate() { trees::eliminate(shape_, points(), rods(), &work_.largest_inverse); }
  void evaluate_and_eliminate(const trees::BranchMotion& motion) {
    Largest right_side;
    trees::evaluate_and_eliminate(shape_, motion, points(), rods(), rows(), &right_side, &work_.largest_inverse);
    note_right_side(right_side);
  }
  void substitute_up() {
    std::fill_n(work_.s.begin(), shape_.num_points(), Pack3<>{});
    trees::substitute_up(shape_, points(), rods(), rows());
  }
  /// Substitutes down. The forces on the roots stand in the place of their dw and are replaced by it.
  void substitute_down() {
    std::fill_n(work_.dw.begin(), shape_.num_points(), Pack3<>{});
    Pack3<>& pull = work_.dw[shape_.num_rods];
    for (std::size_t lane = 0; lane < num_lanes; ++lane) set_lane(&pull, lane, load(joints_.dw.data(), root(lane)));
    trees::substitute_down(shape_, masses(), rods(), rows(), work_.dw.data());
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      store(joints_.dw.data(), root(lane), {pull.x[lane], pull.y[lane], pull.z[lane]});
  }
  void find_residual() {
    Largest residual;
    trees::find_residual(shape_, rods(), rows(), work_.dw.data(), &residual);
    pack_to(&all_.residual_[number_ * num_lanes]) = residual.value + residual.zero;
  }

  /// Computes points += M^-1 K rows.
  void add_reactions(const double* rows, double* points) {
    gather_sequences(rows, batch_.first_row.data(), 1, shape_.num_rods, 1.0, work_.rows.data());
    trees::find_reactions(shape_, masses(), rods(), work_.rows.data(), work_.dw.data());
    add_accelerations(points);
  }
  /// Evaluates the violation at the positions or velocities that `read` or `add_accelerations` left behind.
  void evaluate_values() {
    Largest largest;
    trees::evaluate_values(shape_, work_.dw.data(), offsets(), &all_.length_.data()[batch_.first_rod], rows(),
                           &largest);
    note_right_side(largest);
  }
  void evaluate_rates(const double* r) {
    Largest largest;
    read_points(r, &work_.r);
    trees::evaluate_rates(shape_, work_.r.data(), work_.dw.data(), offsets(), rows(), &largest);
    note_right_side(largest);
  }
  void read(const double* points) { read_points(points, &work_.dw); }
  void add_multipliers(double* sum) {
    Pack<>* const lanes = work_.rows.data();
    gather_sequences(sum, batch_.first_row.data(), 1, shape_.num_rods, 1.0, lanes);
    for (std::size_t k = 0; k < shape_.num_rods; ++k) lanes[k] += rows()[k].z;
    scatter_sequences(lanes, batch_.first_row.data(), 1, shape_.num_rods, 1.0, sum);
  }

  /// Evaluates the directions at r.
  void find_directions(const double* r) {
    read_points(r, &work_.r);
    trees::find_directions(shape_, work_.r.data(), offsets(), rods());
  }
  void read_directions(const double* blocks) {
    gather_blocks(blocks, block_numbers(), shape_.num_rods, work_.u.data());
    for (std::size_t k = 0; k < shape_.num_rods; ++k) work_.u[k].write(&rods()[k].u);
  }
  void write_directions(double* blocks) {
    for (std::size_t k = 0; k < shape_.num_rods; ++k) rods()[k].u.write(&work_.u[k]);
    scatter_blocks(work_.u.data(), block_numbers(), shape_.num_rods, blocks);
  }
  void read_right_side(const double* b) {
    gather_sequences(b, batch_.first_row.data(), 1, shape_.num_rods, 1.0, work_.rows.data());
    for (std::size_t k = 0; k < shape_.num_rods; ++k) rows()[k].b = work_.rows.data()[k];
  }
  void write_multipliers(double* x) {
    for (std::size_t k = 0; k < shape_.num_rods; ++k) work_.rows.data()[k] = rows()[k].z;
    scatter_sequences(work_.rows.data(), batch_.first_row.data(), 1, shape_.num_rods, 1.0, x);
  }
  /// Hands W of the roots over to the trunks; `hand_over_answers` hands over their s.
  void hand_over_mobilities() {
    const trees::Mobility<Pack3<>>& W = work_.mobility[shape_.num_rods];
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      joints_.mobility[root(lane)] = {W.xx[lane], W.xy[lane], W.xz[lane], W.yy[lane], W.yz[lane], W.zz[lane]};
  }
  void hand_over_answers() {
    const Pack3<>& s = work_.s[shape_.num_rods];
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      store(joints_.s.data(), root(lane), {s.x[lane], s.y[lane], s.z[lane]});
  }
  /// Writes w := w0 + dw.
  void write_accelerations(Vec3 w0, double* w) {
    add(w0, shape_.num_points(), work_.dw.data());
    write_points(w);
  }
  /// Computes w += dw.
  void add_accelerations(double* w) {
    read_points(w, &work_.w);
    add(work_.w.data(), shape_.num_points(), work_.dw.data());
    write_points(w);
  }
  void write(const Pack3<>* points, double* to) const {
    scatter_sequences(&points->x, batch_.first_point.data(), 3, 3 * shape_.num_points(), 1.0, to);
  }
  /// Prefetches the points of an array while something else is computed.
  void call_for(const double* points) const {
    call_for_sequences(points, batch_.first_point.data(), 3, 3 * shape_.num_points());
  }

  // The arrays of the batch:
  const trees::Shape& shape() const { return shape_; }
  trees::BranchRod* rods() { return &all_.rods_[batch_.first_rod]; }
  trees::BranchRow* rows() { return &all_.rows_[batch_.first_rod]; }
  const Pack3<>* offsets() const { return all_.offsets_.empty() ? nullptr : &all_.offsets_[batch_.first_rod]; }
  const Pack<>* masses() { return all_.inverse_mass_.data() + batch_.first_place; }
  const Pack3<>* dw() const { return work_.dw.data(); }
  trees::BranchPoints points() { return {masses(), work_.mobility.data(), work_.s.data()}; }

 private:
  const Index* block_numbers() const { return &all_.blocks_[batch_.first_rod * num_lanes]; }
  std::size_t root(std::size_t lane) const {
    return static_cast<std::size_t>(batch_.first_point[lane]) + shape_.num_rods;
  }
  void note_right_side(const Largest& found) {
    pack_to(&all_.right_side_[number_ * num_lanes]) = found.value + found.zero;
  }

  void read_points(const double* from, std::vector<Pack3<>>* to) const {
    gather_sequences(from, batch_.first_point.data(), 3, 3 * shape_.num_points(), 1.0, &to->data()->x);
  }
  void write_points(double* to) const { write(work_.dw.data(), to); }
  const Pack<>* read_length_seconds() {
    if (all_.moving_lengths_.empty()) return nullptr;
    for (std::size_t k = 0; k < shape_.num_rods; ++k) {
      for (std::size_t lane = 0; lane < num_lanes; ++lane) {
        const MovingScalar* const length = all_.moving_lengths_[(batch_.first_rod + k) * num_lanes + lane];
        work_.length_second.data()[k][lane] = length != nullptr ? length->second : 0.0;
      }
    }
    return work_.length_second.data();
  }

  TreeBranches& all_;
  std::size_t number_;
  const BranchBatch& batch_;
  TreePoints& joints_;
  Workspace& work_;
  trees::Shape shape_ = all_.plan_.shape(batch_);
};

}  // namespace tanor::detail
