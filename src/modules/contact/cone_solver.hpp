#pragma once

#include <vector>

#include "contact/cone_problem.hpp"

namespace tanor::detail {

struct ConeOptions {
  double tolerance = 1e-12;  ///< of error_of_contacts()
  int most_sweeps = 200;     ///< of exact solves contact by contact, before Newton's method
  int most_factorizations = 2000;
  double seconds = 0.0;  ///< of the processor, after which the best r is returned; 0 for no limit
};

struct ConeReport {
  double error = 0.0;  ///< error_of_contacts() of the r that is returned, the smallest one found
  int sweeps = 0, factorizations = 0;
  bool is_solved = false;  ///< the error is within the tolerance
};

/// Solves a problem of contacts from the guess r [3 contacts], and replaces it by the best r that was found:
///
/// 1. sweeps of exact solves contact by contact (nonsmooth Gauss-Seidel, Jean and Moreau 1992);
/// 2. a proximal point method, whose steps add alpha (r - r_k) to u, and semismooth Newton steps on
///    F(r) = r - P(r - u) in each of them (Alart and Curnier 1991), with a line search that allows F to grow for a
///    while. alpha makes the forces of hyperstatic contacts unique, and falls while Newton's method converges.
ConeReport solve_contacts(const ConeProblem& problem, const ConeOptions& options, std::vector<double>* r);

}  // namespace tanor::detail
