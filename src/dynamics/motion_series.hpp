#pragma once

#include <span>
#include <string>
#include <vector>

#include "assembly/reactions.hpp"
#include "dynamics/workspace.hpp"
#include "evaluate/constraint_series.hpp"
#include "evaluate/force_series.hpp"

namespace tanor {

/// K_0 and the factor of its S, where a series begins.
class SeriesFactor {
 public:
  /// Brings what other processes find of coefficients [3n] that are not complete yet.
  virtual void complete(double* points) = 0;
  /// rows := K_0'points + shift [d]
  virtual void apply_transposed(const double* points, const double* shift, double* rows) = 0;
  /// rows := -S^-1 rows [d], points += M^-1 K_0 rows [3n]
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
/// The unknown lambda_k stands beside K_0 alone, so every order is one solve with the factor of S(r_0).
class MotionSeries {
 public:
  explicit MotionSeries(Workspace& work);

  /// Why the system has no series; empty: it has.
  const std::string& obstacle() const;

  /// Coefficients of r around t, whose first three are known; with lambda_0, and `passes` solves an order. Returns the
  /// time beyond which no series holds, s.
  double expand(double t, const std::vector<double>& lambda, int passes, SeriesFactor& factor,
                std::span<double* const> coefficients);

  /// What constraints put in where they depend on time or hold moving supports, W, at the time t of the last series,
  /// whose first `terms` after r_0 place the points at r. `v_supports` [3n]: 0 but at moving supports. Rows that are
  /// counted elsewhere are left out.
  double power_of_constraints(double t, const double* r, const double* v_supports, int terms,
                              std::span<const std::size_t> counted_elsewhere = {});

 private:
  void begin(double t, std::span<double* const> coefficients);
  void advance(int k, std::span<double* const> coefficients);
  void solve_order(int k, int passes, SeriesFactor& factor, double* next);

  Workspace& work_;
  const Model& model_;
  ConstraintSeries constraints_;
  ForceSeries forces_;
  ReactionGather gather_;  // blocks of constraints, those of forces behind them
  struct Support {
    VectorFunction displacement;
    std::vector<Index> points;  // inner
  };
  std::vector<Support> supports_;
  std::string obstacle_;
  double smooth_until_ = 0.0;
  std::size_t first_force_;  // block
  std::vector<double> blocks_, ones_;
  std::vector<double> lambda_;             // [d] lambda_k of the last order
  double begun_at_ = 0.0;                  // s
  std::vector<double> multipliers_;        // [order][d] all lambda_k, where constraints may do work; else none
  std::vector<double> right_side_, rows_;  // [d] scratch
};

/// coefficients[0], [1] and [2] of a motion that is at (x, v) with the accelerations w, which may stand in the last.
void write_first_coefficients(const Kinematics& at, const double* w, std::size_t size,
                              std::span<double* const> coefficients);
bool is_finite(std::span<const double> numbers);

}  // namespace tanor
