#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "statics/equilibrium_equations.hpp"
#include "statics/kkt_solver.hpp"

namespace tanor::detail {

/// Some modes of Z'WZ q = omega^2 Z'MZ q, K'Z = 0, in the inner order of points.
struct ModeSet {
  Outcome outcome;
  Eigen::VectorXd omega2{};  ///< increasing, 1/s^2
  Eigen::MatrixXd shapes{};  ///< x = Zq by columns, [3 moving points x modes], x'Mx = 1
  double residual = 0.0;     ///< largest |M^-1/2 (W x + K mu - omega^2 M x)| over the largest |omega^2|
};

/// Finds modes about the configuration at which the equations were linearised last. `freedoms` is 3n - rank K.
/// `dependent` [rows of the model] lists rows that depend on others; each adds one freedom to its island. With few
/// freedoms each island is solved by itself, so that a stiff one takes no digits from a soft one.
class ModeFinder {
 public:
  /// `equations` and `kkt` must outlive the finder.
  ModeFinder(const EquilibriumEquations& equations, KktSolver& kkt, std::size_t freedoms,
             const std::vector<std::size_t>& dependent = {});

  /// Returns the scale of omega^2: the largest |W_ij| over the mass of point i, 1/s^2; 1 if nothing is stiff.
  double scale() const { return scale_; }

  /// Returns s of the last search, 1/s^2.
  double shift() const { return shift_; }

  /// Returns a basis of all moves that break no constraint, M-orthonormal by columns, or nothing if the matrix has no
  /// factor.
  std::optional<Eigen::MatrixXd> find_basis();
  /// Finds all modes from a dense basis Z of the possible moves; suited to few freedoms.
  ModeSet find_all();
  /// Finds the lowest `count` modes, at most half of the freedoms, by Lanczos' method with implicit restarts (Spectra),
  /// of the matrix
  ///
  ///   M^1/2 Z (Z'(W + s M)Z)^-1 Z' M^1/2,   whose eigenvalues are 1/(omega^2 + s),
  ///
  /// with -s below the lowest omega^2, and by inverse iteration. The number of negative pivots of a second factor
  /// (Sylvester's law of inertia) proves that none is missing, such as one of several equal ones, of which a Krylov
  /// space sees one. Missing modes are sought among the vectors M-orthogonal to the modes that were found.
  ModeSet find_lowest(std::size_t count, double tolerance);
  /// Finds some of the lowest modes without counting them, with the current factor, which is of the shift s. It finds
  /// one copy of a mode, and fewer than `count` modes if Lanczos' method stalls.
  ModeSet find_some_lowest(double shift, std::size_t count);

  /// Returns the rounding error of |M^-1/2 (W x + K mu - omega^2 M x)|, 1/s^2. If the lowest mode is next to the shift,
  /// the other modes lose digits.
  double residual_to_rounding(double lowest_omega2) const;

  /// The shift s of the first search relative to the scale of omega^2. It is so near to 0 that the lowest modes are
  /// well separated, and so far from it that zero modes do not take digits from the others.
  static constexpr double least_shift = 1e-9;

 private:
  struct Pairs {
    Eigen::MatrixXd x, multipliers;  // columns; of the KKT matrix, K mu = M x - (W + s M) x
  };

  bool factorize_below_all(double first_shift);
  void group_by_islands(const std::vector<std::size_t>& dependent);
  Pairs solve(Eigen::MatrixXd forces, KktSolver::Accuracy accuracy);
  void apply(const double* from, double* to);
  Eigen::MatrixXd search(std::size_t count, double tolerance, const Eigen::MatrixXd& found);
  Eigen::MatrixXd search_missing(const ModeSet& modes, std::size_t count, std::size_t missing, double tolerance);
  ModeSet refine(Eigen::MatrixXd x, std::size_t wanted, double tolerance);
  ModeSet refine_or_search(Eigen::MatrixXd x, std::size_t wanted, double tolerance);
  bool meets(const ModeSet& modes, std::size_t wanted, double tolerance) const;
  ModeSet rotate(Pairs pairs, std::size_t wanted) const;
  /// The claim that so many modes lie below omega2.
  struct Bound {
    double omega2 = 0.0;
    std::size_t modes = 0;
  };
  std::optional<std::size_t> count_below(const Bound& bound);
  Bound choose_bound(const Eigen::VectorXd& omega2, std::size_t count) const;
  Eigen::VectorXd rayleigh_quotients(const Eigen::MatrixXd& x) const;

  const EquilibriumEquations& equations_;
  KktSolver& kkt_;
  std::size_t freedoms_;
  Eigen::VectorXd mass_, root_mass_;  // [3 moving points]
  struct Island {
    std::vector<Eigen::Index> coordinates;
    Eigen::Index first = 0, freedoms = 0;
    auto columns() const { return Eigen::seqN(first, freedoms); }  // of a basis
  };
  std::vector<Island> islands_;
  double scale_ = 1.0;  // of omega^2, 1/s^2
  double shift_ = 0.0;
  bool is_precise_ = false;
};

}  // namespace tanor::detail
