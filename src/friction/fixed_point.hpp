#pragma once

#include <limits>
#include <memory>
#include <vector>

#include "base/parallel.hpp"
#include "friction/laws.hpp"
#include "friction/response.hpp"

namespace tanor {

/// Iterations for x = x(lambda(x)), (43) in its smallest form (*) with the sizes of friction as unknowns; a workspace
/// that is kept.
class FixedPoint {
 public:
  FixedPoint(const FrictionLaws& laws, Response& response, std::size_t num_rows);
  /// Parts of different groups [part] do not feel each other: each group is solved to the tolerance of its own
  /// friction, or of the force `least` [group], N, where that is more: rounding makes forces as well.
  void set_groups(const std::vector<Index>& group_of_part, const std::vector<double>& least);
  ~FixedPoint();

  struct Result {
    bool has_converged = false;
    int iterations = 0;        // evaluations of F, one solve each; or steps of Newton's method, which take more
    double contraction = 0.0;  // largest ratio of two distances that followed each other, while they were plain steps
    double change = 0.0;       // last |F(x) - x| over |F(x)|, of the worst group
  };

  static constexpr int most_depth = 10;
  /// `lambda` [rows]: the guess, then the answer; of no use without convergence. `depth` <= most_depth: steps that
  /// Anderson's method looks back; 0: plain (43).
  /// Gives up at once where the contraction is worse than `poor`.
  Result iterate(const Parallel& parallel, int depth, double* lambda,
                 double poor = std::numeric_limits<double>::infinity());
  /// Semismooth Newton: (I - F'(x)) dx = F(x) - x by GMRES, one solve for each of its directions, until
  /// |F(x) - x| <= `wanted` |F(x)|. Its iterations are steps dx.
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

  const FrictionLaws& laws_;
  Response& response_;
  std::unique_ptr<History> history_;  // of Anderson's method, once it was asked
  std::unique_ptr<Krylov> krylov_;    // of Newton's
  Parts x_, image_;                   // in units, …
  Parts inverse_unit_, plain_;        // … of each part; empty: N. And in N, scratch
  std::vector<Index> group_of_part_;
  std::vector<double> least_, units_;  // [group] N
  std::vector<double> dlambda_;        // [rows]
};

}  // namespace tanor
