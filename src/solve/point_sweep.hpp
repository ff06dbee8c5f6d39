#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "solve/sweep.hpp"

namespace tanor {

/// Points on guides of their own (planes, spheres, lines, circles; up to three rows a point), joined to nothing else:
/// each is solved by itself, in closed form, in one pass. Gradients G of a point of mass m have unit columns:
///
///   x = -(G'G)^-1 b,   lambda = m x,   w = w0 + G x
class PointSweep final : public Sweep {
 public:
  /// Null where some row belongs to something else, or a point has more than three.
  static std::unique_ptr<PointSweep> make(const Constraints& constraints, const Numbering& numbering,
                                          std::span<const double> inverse_mass);

  Elimination solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b, double* lambda,
                    double* w) override;
  Elimination factorize(const Parallel& parallel, const double* blocks) override;
  void solve_negative(const Parallel& parallel, const double* b, double* x) override;
  const Summary& summary() const override { return summary_; }

 private:
  static constexpr int most_rows = 3;
  enum class Guide { None, Plane, Sphere, Line, Circle };
  struct Member {
    Guide guide = Guide::None;
    Index number = -1;  // in its family
    Index point = -1;
    int num_rows = 0;
    Index first_block = -1;
  };
  /// Points [first, end), one after the other, that have guides of the same kinds in the same order; the numbers of
  /// their members grow by `stride` from point to point.
  struct Run {
    Index first, end, first_row;
    int num_rows = 0, num_members = 0;
    std::array<Member, most_rows> members{};
    std::array<Index, most_rows> stride{};
  };
  /// G'G = L D L', D_0 = 1.
  struct Factor {
    double l10 = 0.0, l20 = 0.0, l21 = 0.0, inverse_d1 = 0.0, inverse_d2 = 0.0;
  };

  explicit PointSweep(const Constraints& constraints) : constraints_(constraints) {}
  static std::vector<Member> read_members(const Constraints& constraints, std::size_t num_rows);
  bool append_point(std::span<const Member> members, Index first_row);
  template <class Visitor>
  void visit(Guide guide, const Visitor& visitor) const;
  template <int R>
  void solve(const Run& run, Index begin, Index end, const FreeMotion& motion, double* blocks, double* b,
             double* lambda, double* w, Elimination* found);
  template <class Work>
  Elimination for_each_part(const Parallel& parallel, const Work& work);

  const Constraints& constraints_;
  std::span<const double> inverse_mass_;
  std::vector<Run> runs_;
  std::vector<Factor> factors_;  // [point]; empty: every point has one row
  Summary summary_;
};

}  // namespace tanor
