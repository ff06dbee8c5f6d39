#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "schur/schur_solver.hpp"
#include "schur/tree_branches.hpp"

namespace tanor::detail {

/// The findings in a tree, or the worst of several.
struct TreeFindings {
  trees::LargestInverse largest_inverse;
  double right_side = 0.0, residual = 0.0, own_residual = 0.0;

  void include(const TreeFindings& other);
};

/// The trunks of trees: the rods that are in none of the equal branches, on which these hang. They are eliminated rod
/// by rod, after the branches, and their multipliers are found before those of the branches.
class TreeTrunks {
 public:
  /// Keeps a reference to `inverse_mass` [inner point]. Points from `num_moving` on are supports.
  TreeTrunks(std::span<const RodTree> trees, const EqualBranches& branches, const RodRows& given,
             std::span<const double> inverse_mass, std::size_t num_moving);

  std::size_t size() const { return trunks_.size(); }
  std::size_t num_rods() const { return rods_.size(); }
  Index num_moving() const { return num_moving_; }
  bool has_moving_lengths() const { return !moving_lengths_.empty(); }
  /// Brings the moving points of the whole tree.
  void bring(const Parallel& parallel, std::size_t trunk, const PointSource* source) const {
    const auto& [first, end] = trunks_[trunk].points_of_tree;
    detail::bring(parallel, source, static_cast<std::size_t>(first), static_cast<std::size_t>(end));
  }
  void read_offsets(std::span<const Vec3> by_row);

  // ---- the parts of a trunk ----

  /// The rods, from the leaves to the root.
  std::span<const trees::Rod> rods(std::size_t trunk) const { return of_rods(trunk, rods_); }
  /// Their directions [rod].
  std::span<const Vec3> directions(std::size_t trunk) const { return of_rods(trunk, u_); }
  /// Their parts of the distance from the child to the parent [rod]; empty if there are none.
  std::span<const Vec3> offsets(std::size_t trunk) const {
    return offset_.empty() ? std::span<const Vec3>() : of_rods(trunk, offset_);
  }
  /// The points but for the roots of branches.
  std::span<const Index> points(std::size_t trunk) const {
    return std::span(points_).subspan(trunks_[trunk].first_point,
                                      trunks_[trunk].end_point - trunks_[trunk].first_point);
  }
  struct Branch {
    std::size_t batch, lane;
    Index root;
  };
  /// The branches that hang on the trunk.
  std::span<const Branch> branches(std::size_t trunk) const {
    return std::span(roots_).subspan(trunks_[trunk].first_root, trunks_[trunk].end_root - trunks_[trunk].first_root);
  }

  /// Takes l'' of the lengths that move.
  void take_lengths() {
    for (const auto& [rod, length] : moving_lengths_) length_second_[rod] = length->second;
  }

  // ---- the factor: each of these goes from the leaves of a trunk to its root ----

  void read_directions(std::size_t trunk, const double* blocks);
  /// Evaluates the directions at r, and writes them as blocks unless `blocks` is null.
  void find_directions(std::size_t trunk, const double* r, double* blocks);
  void eliminate(std::size_t trunk, TreePoints* points, TreeFindings* found);
  /// Computes z [row] from b [row]; z may be b.
  void substitute_up(std::size_t trunk, const double* b, TreePoints* points, double* z);
  /// Computes the directions, `blocks` and b = phi + K'w0. Then it eliminates and substitutes up, or only substitutes
  /// if the factor is kept.
  void solve_up(std::size_t trunk, const FreeMotion& motion, FactorUse use, double* blocks, double* b,
                TreePoints* points, double* z, TreeFindings* found);
  /// Writes lambda in z's place. Leaves in points.dw the forces on the roots of branches, and dw of other points.
  void substitute_down(std::size_t trunk, TreePoints* points, double* z);

  // ---- what is done with dw ----

  /// Computes to += dw.
  void move(std::size_t trunk, const TreePoints& points, double* to) const;
  /// Computes w := w0 + dw. Without `uniform`, w holds w0.
  void accelerate(std::size_t trunk, const TreePoints& points, const Vec3* uniform, double* w) const;
  /// Includes |K'dw + b| of the rods, and the findings of the branches.
  void find_residual(std::size_t trunk, const TreePoints& points, const double* b, const TreeBranches& branches,
                     TreeFindings* found) const;
  /// Computes points += M^-1 K rows.
  void add_reactions(std::size_t trunk, const double* rows, double* points) const;

  // ---- what is violated, lengths being constant; the branches' largest is included ----

  void find_values(std::size_t trunk, const double* r, double* xi, const TreeBranches& branches,
                   TreeFindings* found) const;
  void find_rates(std::size_t trunk, const double* r, const double* v, double* rates, const TreeBranches& branches,
                  TreeFindings* found) const;
  void add_rows(std::size_t trunk, const double* rows, double* sum) const;

 private:
  /// The ranges [first, end) of a tree in the lists below.
  struct Trunk {
    std::size_t first_rod, end_rod, first_point, end_point, first_root, end_root;
    std::array<Index, 2> points_of_tree;  // first and end
  };
  template <class Number>
  std::span<const Number> of_rods(std::size_t trunk, const std::vector<Number>& numbers) const {
    return std::span(numbers).subspan(trunks_[trunk].first_rod, trunks_[trunk].end_rod - trunks_[trunk].first_rod);
  }

  void list_trunks(std::span<const RodTree> trees, const EqualBranches& branches);
  void read_rods(const RodRows& given);
  trees::Tree tree(const Trunk& trunk);
  trees::Motion motion_of(const Trunk& trunk, const FreeMotion& motion, double* blocks, double* b) const;
  void forget_rods(const Trunk& trunk, TreePoints* points) const;
  void clear(const Trunk& trunk, std::vector<double>* points) const;
  void include_branches(const Trunk& trunk, const TreeBranches& branches, TreeFindings* found) const;
  Vec3 distance(std::size_t rod, const double* r) const;

  std::span<const double> inverse_mass_;
  Index num_moving_;
  std::vector<Trunk> trunks_;
  std::vector<Index> points_;  // points of trunks but for the roots of branches
  std::vector<Branch> roots_;

  // [rod]
  std::vector<trees::Rod> rods_;
  std::vector<signed char> sign_;  // sign of its block, from the child to the parent
  std::vector<std::size_t> block_;
  std::vector<Vec3> offset_;  // from the child to the parent; empty if there are none
  std::vector<double> length_;
  std::vector<double> length_second_;                                        // l''; empty if all are 0
  std::vector<std::pair<std::size_t, const MovingScalar*>> moving_lengths_;  // lengths that depend on time, by rod
  std::vector<Vec3> u_, h_;                                                  // the factor, as in trees::Tree
  std::vector<double> inverse_pivot_;
};

}  // namespace tanor::detail
