#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "base/pack.hpp"
#include "schur/island_solver.hpp"

namespace tanor::detail {

/// Solves points on guides of their own (planes, spheres, lines, circles; up to three rows a point) that nothing else
/// joins. Each point is solved by itself in closed form, all in one pass, eight side by side. The gradients G of a
/// point of mass m have unit columns:
///
///   x = -(G'G)^-1 b,   lambda = m x,   w = w0 + G x
class PointSolver final : public IslandSolver {
 public:
  /// Takes the islands that are such points out of `islands`. Returns null if there are none.
  static std::unique_ptr<PointSolver> make(const SchurProblem& problem, std::vector<Index>* islands);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks, double* scratch,
                    double* lambda, double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;

 private:
  static constexpr std::size_t most_rows = 3, most_groups = 8, most_points = most_groups * num_lanes;
  /// Consecutive points that have guides of the same kinds in the same order, and consecutive rows.
  struct Chunk {
    std::size_t first_point, first_row, num_rows, num_points = 0, first_gradient = 0;
    std::array<bool, most_rows> has_one_guide{true, true, true};   // [row] true if one guide serves all points
    std::array<bool, most_rows> are_neighbours{true, true, true};  // [row] true if blocks follow one another

    std::size_t num_groups() const { return (num_points + num_lanes - 1) / num_lanes; }
    bool is_full() const { return num_points % num_lanes == 0; }
  };
  class Work;

  PointSolver(IslandGroup points, std::vector<Index> block, std::vector<Chunk> chunks)
      : IslandSolver(std::move(points)), block_(std::move(block)), chunks_(std::move(chunks)) {}
  template <class Visit>
  Elimination for_each_chunk(const Parallel& parallel, const Visit& visit);

  std::vector<Index> block_;  // [row]; -1 where it belongs to no guide
  std::vector<Chunk> chunks_;
  std::vector<Pack3<>> gradients_;  // [row][group] of each chunk of several rows: their factor is as soon made as read
};

}  // namespace tanor::detail
