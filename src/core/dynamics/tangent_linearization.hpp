#pragma once

#include <vector>

#include "dynamics/workspace.hpp"
#include "schur/gram_solver.hpp"

namespace tanor::detail {

/// The state of the points by coordinates at one instant: r(q, t), v and psi [3n], A = dr/dq' as blocks, and the factor
/// of H = A'MA. H has one block for each member of the coordinates.
class TangentLinearization {
 public:
  TangentLinearization(Workspace& work, const SolverOptions& options);

  /// Evaluates r, v and psi at (t, q, q_dot), and A if `with_blocks` is true.
  void evaluate(double t, const double* q, const double* q_dot, bool with_blocks);
  /// Writes the prescribed motion of supports at t into r and v.
  void prescribe(double t);
  /// Factorizes H with the present A.
  Outcome factorize(double t);
  /// Factorizes H again without counting it or checking its condition, which was good before.
  void factorize_again();
  /// Notes that A and the factor of H do not belong to the last accelerations, which leave them out but know the
  /// condition of H.
  void leave_out_blocks(double reciprocal_condition) {
    has_blocks_ = false;
    reciprocal_condition_ = reciprocal_condition;
  }
  bool has_blocks() const { return has_blocks_; }
  /// 1/cond(H), for H scaled to a unit diagonal.
  double reciprocal_condition() const { return reciprocal_condition_; }

  const std::vector<double>& r() const { return r_; }
  const std::vector<double>& v() const { return v_; }
  const std::vector<double>& psi() const { return psi_; }
  const std::vector<double>& blocks() const { return blocks_; }

  /// Computes x := -H^-1 x [s].
  void solve_negative(double* x) { solver_.solve_negative(model_.parallel, x, x); }
  /// The solver of H.
  GramSolver& gram() { return solver_; }
  double estimate_reciprocal_condition() { return solver_.estimate_reciprocal_condition(); }
  /// Computes points = A x [3n], for moving points.
  void apply(const double* x, double* points) const {
    work_.coordinates.apply(model_.parallel, blocks_.data(), x, points);
  }
  /// Computes x = A'points [s].
  void apply_transposed(const double* points, double* x) const {
    work_.coordinates.apply_transposed(model_.parallel, blocks_.data(), points, x);
  }

  /// Solves H q_dot = A'M (v - r_t) for the rates [s] at (t, q) nearest to v [3n] in the M-norm.
  Outcome find_rates(double t, const double* v, const double* q, double* q_dot);
  /// Computes eta = [I - M A H^-1 A'] force [3n] (24), refined to rounding. At supports it is the force of the
  /// coordinates.
  void find_reactions(const double* force, double* eta);

  void describe(PlanSummary* plan) const { describe_factor(solver_.summary().factor, plan); }
  /// Returns the predicted flops of one evaluation and solve.
  double predicted_flops() const;

 private:
  TangentLinearization(Workspace& work, const SolverOptions& options, const std::vector<Product>& products);

  Workspace& work_;
  const Model& model_;
  const std::size_t num_products_;
  GramSolver solver_;
  bool has_blocks_ = true;
  double reciprocal_condition_ = 1.0;
  std::vector<double> blocks_;          // A
  std::vector<double> r_, v_, psi_;     // [3n]
  std::vector<double> points_, moved_;  // [3n] scratch
  std::vector<double> columns_;         // [s] scratch
};

}  // namespace tanor::detail
