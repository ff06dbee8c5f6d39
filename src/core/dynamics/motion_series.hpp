#pragma once

#include <span>
#include <string>
#include <vector>

#include "assembly/reactions.hpp"
#include "base/index_ranges.hpp"
#include "dynamics/workspace.hpp"
#include "evaluate/constraint_series.hpp"
#include "evaluate/force_series.hpp"

namespace tanor::detail {

/// K_0 and the factor of its S at the beginning of a series.
class SeriesFactor {
 public:
  /// Computes rows := K_0'points + shift [d].
  virtual void apply_transposed(const double* points, const double* shift, double* rows) = 0;
  /// Computes rows := -S^-1 rows [d], and adds M^-1 K_0 rows to points [3n].
  virtual void correct(double* rows, double* points) = 0;

 protected:
  ~SeriesFactor() = default;
};

/// The motion as a power series in time, with its multipliers:
///
///   r(t0 + s) = sum r_k s^k,   lambda(t0 + s) = sum lambda_k s^k
///   (k+1)(k+2) M r_{k+2} = f_k + sum over j = 0 … k of K_j lambda_{k-j}
///   coefficient k + 2 of xi = 0:   K_0'r_{k+2} = -(what the lower ones make)
///
/// The unknown lambda_k is multiplied by K_0 alone, so every order is one solve with the factor of S(r_0).
class MotionSeries {
 public:
  explicit MotionSeries(Workspace& work) : MotionSeries(work, {}, IndexRanges(work.model().num_moving())) {}
  /// Describes some islands: rods with a `takes_part` [row] of 0 are left out, and the factor must leave them out too.
  /// `points` are the moving points of the islands and those in none.
  MotionSeries(Workspace& work, std::span<const char> takes_part, IndexRanges points);

  /// Returns the reason why the system has no series, or an empty string if it has one.
  const std::string& obstacle() const;

  /// Computes the coefficients of r around t, of which the first three are known, from lambda_0, with `passes` solves
  /// for each order. Returns the time beyond which no series holds, s.
  double expand(double t, const std::vector<double>& lambda, int passes, SeriesFactor& factor,
                std::span<double* const> coefficients);

  /// Returns the power that enters through constraints that depend on time or hold moving supports, W, at the time t in
  /// the last series. The first `terms` of that series after r_0 give the positions r. `v_supports` [3n] is 0 except at
  /// moving supports.
  double power_of_constraints(double t, const double* r, const double* v_supports, int terms);

 private:
  void begin(double t, std::span<double* const> coefficients);
  void advance(int k, std::span<double* const> coefficients);
  void solve_order(int k, int passes, SeriesFactor& factor, double* next);

  Workspace& work_;
  const Model& model_;
  ConstraintSeries constraints_;
  ForceSeries forces_;
  ReactionGather gather_;  // blocks of constraints, then those of forces
  IndexRanges points_;     // moving points that it moves
  struct Support {
    VectorFunction displacement;
    std::vector<Index> points;  // inner
  };
  std::vector<Support> supports_;
  std::string obstacle_;
  double smooth_until_ = 0.0;
  std::size_t first_force_;  // index of the first block of forces
  std::vector<double> blocks_;
  std::vector<double> lambda_;             // [d] lambda_k of the last order
  double begun_at_ = 0.0;                  // s
  std::vector<double> multipliers_;        // [order][d] all lambda_k if constraints may do work; otherwise empty
  std::vector<double> right_side_, rows_;  // [d] scratch
};

/// Writes coefficients[0], [1] and [2] of a motion at (x, v) with the accelerations w, which may be the array of the
/// last.
void write_first_coefficients(const Kinematics& at, const double* w, std::size_t size,
                              std::span<double* const> coefficients);
bool is_finite(std::span<const double> numbers);

}  // namespace tanor::detail
