#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "base/parallel.hpp"
#include "dynamics/workspace.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// Finds how the reactions of a constrained system respond to forces at its contacts. S is factorized, so that one call
/// is one solve. Forces come as parts, tau = sum of x_p e_p (see FrictionLaws).
///
///   lambda(x) = -S^-1 (b + K'M^-1 tau(x)),   b = phi + K'M^-1 f                    (*)
class Response {
 public:
  virtual ~Response() = default;

  /// Finds lambda [rows] for x [parts].
  virtual void find_multipliers(const double* x, double* lambda) = 0;
  /// Finds the change -S^-1 K'M^-1 tau(x) of lambda.
  virtual void find_change(const double* x, double* lambda) = 0;
};

/// The scales of changes of friction. Each change is measured by the largest friction of its own neighbourhood, so that
/// a heavy part of a scene does not hide a light one. The neighbourhoods that have contacts are numbered as *groups*.
class FrictionScales {
 public:
  FrictionScales(const Workspace& work, const FrictionLaws& laws);

  /// Sets the forces that measure friction where it vanishes, from the `accelerations` [neighbourhood] around it,
  /// m/s^2.
  void set_accelerations(const std::vector<double>& accelerations);

  bool are_several() const { return neighbourhoods_.size() > 1; }
  const std::vector<Index>& group_of_part() const { return group_of_part_; }
  /// The smallest force that counts in each group, N.
  const std::vector<double>& least() const { return least_; }

  /// Returns |x - before| over the largest friction, of the worst group; both are [parts].
  double relative_change(const std::vector<double>& x, const std::vector<double>& before);

 private:
  const Workspace& work_;
  const Model& model_;
  const FrictionLaws& laws_;
  std::vector<Index> group_of_part_;
  std::vector<std::size_t> neighbourhoods_;       // [group]
  std::vector<double> least_;                     // [group] N
  std::vector<double> largest_, largest_change_;  // [group] N, scratch
};

/// Return the largest |x_i| or |a_i - b_i|, or NaN if there is any.
double largest_of(const std::vector<double>& x);
double largest_difference(const std::vector<double>& a, const std::vector<double>& b);

/// Solves x = x(lambda(x)) iteratively, which is (43) in its smallest form (*) with the sizes of friction as unknowns.
/// The workspace is kept.
class FixedPoint {
 public:
  /// Each group of `scales` is solved to the tolerance of its own friction, or of the least force that counts in it, if
  /// that is larger, since rounding makes forces as well. All arguments but the last must outlive this object.
  FixedPoint(const FrictionLaws& laws, const FrictionScales& scales, Response& response, std::size_t num_rows);
  ~FixedPoint();

  struct Result {
    bool has_converged = false;
    int iterations = 0;        // evaluations of F, one solve each, or Newton steps, which take more
    double contraction = 0.0;  // largest ratio of two successive distances, of plain steps only
    double change = 0.0;       // last |F(x) - x| over |F(x)|, of the worst group
  };

  static constexpr int most_depth = 10;
  /// Iterates from `lambda` [rows], which is the guess, then the answer, and of no use without convergence. `depth` <=
  /// most_depth is the number of steps that Anderson's method uses; 0 means plain (43). Gives up at once if the
  /// contraction is worse than `poor`.
  Result iterate(const Parallel& parallel, int depth, double* lambda,
                 double poor = std::numeric_limits<double>::infinity());
  /// Solves by a semismooth Newton method: (I - F'(x)) dx = F(x) - x by GMRES, one solve for each of its directions,
  /// until |F(x) - x| <= `wanted` |F(x)|. Its iterations are steps dx.
  Result solve_by_newton(const Parallel& parallel, double* lambda, double wanted = tolerance);

  static constexpr double tolerance = 1e-12;

 private:
  using Parts = std::vector<double>;
  class History;
  struct Krylov;
  void evaluate(const Parallel& parallel, const Parts& x, double* lambda, Parts* image);
  void apply_derivative(const Parallel& parallel, const double* lambda, const double* dx, Parts* image);
  double find_newton_step(const Parallel& parallel, const double* lambda);
  void choose_units(Parts* x, Parts* image);
  const double* in_newtons(const double* x);

  const FrictionLaws& laws_;
  const FrictionScales& scales_;
  Response& response_;
  std::unique_ptr<History> history_;  // of Anderson's method, made on first use
  std::unique_ptr<Krylov> krylov_;    // of Newton's method, made on first use
  Parts x_, image_;                   // in the units of `inverse_unit_`
  Parts inverse_unit_, plain_;        // 1/unit of each part, empty for N; scratch in N
  std::vector<double> units_;         // [group] N
  std::vector<double> dlambda_;       // [rows]
};

}  // namespace tanor::detail
