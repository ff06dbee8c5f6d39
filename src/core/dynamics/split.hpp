#pragma once

#include <memory>
#include <vector>

#include "dynamics/linearization.hpp"
#include "dynamics/workspace.hpp"
#include "schur/gram_solver.hpp"

/// \file The Euclidean split u = u_T + u_N (16) of R^{3n}, which does not depend on masses. Rows of supports take no
/// part.
namespace tanor::detail {

/// The space N spanned by K: u_N = K Gamma^-1 K'u (15), Gamma = K'K. Gamma has the pattern of S, so the solver of S
/// with unit masses serves.
class NormalSpace {
 public:
  /// `one_mass` is null, or the linearization of a system whose masses are all m. Then Gamma = m S (36), and its factor
  /// of S is used. It must be at the same configuration.
  explicit NormalSpace(Workspace& work, Linearization* one_mass = nullptr);

  /// Factorizes Gamma at (t, r), with K as blocks, which must live as long as the factor. Dependent rows take no part.
  Outcome factorize(double t, const double* r, const double* blocks);
  /// Computes the least x [3n] with K'x = c, x = K mu, mu = Gamma^-1 c [d], refined to rounding.
  void find_least(const double* c, double* x, double* mu);
  /// Computes u_N = K mu, mu = Gamma^-1 K'u.
  void project(const double* u, double* u_N, double* mu);

 private:
  Workspace& work_;
  const Model& model_;
  Linearization* one_mass_;
  std::vector<double> unit_;            // [point] 1; supports: 0
  std::unique_ptr<GramSolver> solver_;  // null with one mass
  Dependences dependences_;             // of K'K
  const double* blocks_ = nullptr;
  std::vector<double> c_, rows_;  // [d] scratch
  std::vector<double> points_;    // [3n] scratch
};

/// The space T spanned by A: u_T = A G^-1 A'u (15), where G = A'A is H with unit masses.
class TangentSpace {
 public:
  explicit TangentSpace(Workspace& work);

  /// Factorizes G at t, with A as blocks, which must live as long as the factor.
  Outcome factorize(double t, const double* blocks);
  /// Computes u_T = A x [3n], refined to rounding, and x = G^-1 A'u [s] unless it is null.
  void project(const double* u, double* u_T, double* x = nullptr);

 private:
  Workspace& work_;
  const Model& model_;
  GramSolver solver_;
  const double* blocks_ = nullptr;
  std::vector<double> columns_;        // [s] scratch
  std::vector<double> points_, rest_;  // [3n] scratch
};

/// Returns true if all moving points have one mass.
bool has_one_mass(const Model& model);

}  // namespace tanor::detail
