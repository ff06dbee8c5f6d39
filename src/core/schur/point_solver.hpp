#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "schur/island_solver.hpp"
#include "schur/point_kernels.hpp"

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
  static constexpr std::size_t most_rows = 3;
  enum class Guide { None, Plane, Sphere, Line, Circle };
  struct Member {
    Guide guide = Guide::None;
    Index number = -1;  // number in its family
    Index point = -1;
    Index num_rows = 0;
    Index first_block = -1;
    bool is_still = true;  // true if its guide does not move
    Index slot = -1;       // slot of its guide's geometry
  };
  /// Consecutive points [first, end) that have guides of the same kinds in the same order. The numbers of their members
  /// grow by `stride` from point to point. Groups of eight are counted from the first point on.
  struct Run {
    Index first, end, first_row;
    std::size_t first_group = 0;
    Index num_rows = 0;
    std::size_t num_members = 0;
    std::array<Member, most_rows> members{};
    std::array<Index, most_rows> stride{};
    std::array<bool, most_rows> has_one_guide{};  // true if one guide serves all points

    std::size_t num_groups() const { return (static_cast<std::size_t>(end - first) + num_lanes - 1) / num_lanes; }
  };
  struct Chunk;

  explicit PointSolver(const Constraints& constraints) : constraints_(constraints) {}
  static std::vector<Member> read_members(const Constraints& constraints, std::size_t num_rows);
  bool append_point(std::span<const Member> rows, Index first_row);
  template <class Work>
  Elimination for_each_chunk(const Parallel& parallel, const Work& work) const;
  PointFactor* factors_of(Chunk* chunk);
  template <class Kernel>
  void evaluate_moving(const Family<Kernel>& family, const FreeMotion& motion, std::size_t row, Chunk* chunk) const;
  struct Guides;
  void evaluate(const FreeMotion& motion, std::size_t member, std::size_t row, Chunk* chunk) const;
  void evaluate_straight(Guide guide, const Guides& guides, bool is_still, const FreeMotion& motion, std::size_t row,
                         Chunk* chunk) const;
  void evaluate_round(Guide guide, const Guides& guides, bool is_still, const FreeMotion& motion, std::size_t row,
                      Chunk* chunk) const;

  const Constraints& constraints_;
  std::span<const double> inverse_mass_;
  std::vector<Run> runs_;
  std::vector<PointFactor> factors_;  // [group]; empty if every point has one row
};

}  // namespace tanor::detail
