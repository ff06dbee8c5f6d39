#pragma once

#include <vector>

#include "base/parallel.hpp"
#include "friction/laws.hpp"
#include "friction/response.hpp"

namespace tanor {

/// Iterations for lambda = lambda(tau(lambda)), (43) in its smallest form (*). Unknowns y are the multipliers that the
/// laws read; a workspace that is kept.
class FixedPoint {
 public:
  FixedPoint(const FrictionLaws& laws, Response& response, std::size_t num_rows);

  struct Result {
    bool has_converged = false;
    int iterations = 0;        // solves
    double contraction = 0.0;  // largest ratio of two distances that followed each other, while they were plain steps
    double change = 0.0;       // last |F(y) - y| over |y|
  };

  /// `lambda` [rows]: the guess, then the answer. `depth`: steps that Anderson's method looks back; 0: plain (43).
  Result iterate(const Parallel& parallel, int depth, double* lambda);
  /// Semismooth Newton: (I - F'(y)) dy = F(y) - y by GMRES, until |dy| <= `wanted` |y|. Its iterations are such steps.
  Result solve_by_newton(const Parallel& parallel, double* lambda, double wanted = tolerance);
  /// tau [3 contacts] at lambda.
  const std::vector<double>& friction(const Parallel& parallel, const double* lambda);

  static constexpr double tolerance = 1e-12;

 private:
  void evaluate(const Parallel& parallel, const std::vector<double>& y, std::vector<double>* image);
  double find_newton_step(const Parallel& parallel, const std::vector<double>& y, const std::vector<double>& defect,
                          std::vector<double>* step, int* iterations);
  void read(const double* lambda, std::vector<double>* y) const;
  void write(const std::vector<double>& y, double* lambda) const;

  const FrictionLaws& laws_;
  Response& response_;
  std::vector<double> tau_;      // [3 contacts]
  std::vector<double> lambda_;   // [rows] at y
  std::vector<double> image_;    // [rows] of the last evaluation
  std::vector<double> dlambda_;  // [rows]
};

}  // namespace tanor
