#include "statics/mode_finder.hpp"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "base/text.hpp"

namespace tanor {

using Eigen::MatrixXd, Eigen::VectorXd;
using Rows = Eigen::Index;

namespace {

/// Shifts are tried from the least one on, each so much larger than the one before.
constexpr double growth_of_shift = 8.0;
/// Of the scale of omega^2: so near to 0 that the lowest modes stand well apart, so far that zero modes do not drown
/// the others' digits.
constexpr double least_shift = 1e-9;
/// Modes beyond those that are wanted: the bound below which all are counted finds a gap among them.
constexpr std::size_t num_guards = 2;
/// Dimensions of the Krylov space beyond twice the modes that are sought.
constexpr std::size_t spare_dimensions = 10;
constexpr Rows most_restarts = 300;
/// Inverse iterations on all modes together after Lanczos' method, and the residual that needs no more.
constexpr int most_refinements = 4;
/// Of a solve with the KKT matrix; in Lanczos' method one round is enough, since Rayleigh-Ritz with W itself follows.
constexpr int full_refinements = 3;
constexpr double small_residual = 1e-12;
/// A gap this much larger than omega^2 + s tells two modes apart for certain.
constexpr double clear_gap = 1e-5;
constexpr std::size_t most_searches = 8;

ModeSet end_without_modes(Status status, std::string what) {
  return {{status, std::move(what)}, {}, {}, 0.0, 0};
}

MatrixXd random_matrix(Rows rows, Rows columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

}  // namespace

ModeFinder::ModeFinder(const EquilibriumEquations& equations, KktSolver& kkt, std::size_t freedoms)
    : equations_(equations), kkt_(kkt), freedoms_(freedoms), mass_(static_cast<Rows>(equations.size())) {
  for (Rows i = 0; i < mass_.size(); ++i) mass_[i] = equations.model().mass[static_cast<std::size_t>(i) / 3];
  root_mass_ = mass_.cwiseSqrt();
  find_stiffness_scale();
}

/// The largest |W_ii| over the mass; 1/s^2 where nothing is stiff.
void ModeFinder::find_stiffness_scale() {
  const StiffnessMatrix& W = equations_.stiffness();
  double largest = 0.0;
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (auto k = static_cast<std::size_t>(W.start()[i]); k < static_cast<std::size_t>(W.start()[i + 1]); ++k) {
      if (W.columns()[k] != static_cast<int>(i)) continue;
      for (const double value : W.blocks()[k].entries)
        largest = std::max(largest, std::abs(value) / equations_.model().mass[i]);
    }
  }
  if (largest > 0.0) scale_ = largest;
}

/// Finds a shift at which W + s M is positive definite where K'x = 0, and its factor.
bool ModeFinder::factorize_below_all(double first_shift) {
  for (shift_ = first_shift; shift_ < 1e6 * scale_; shift_ *= growth_of_shift) {
    if (kkt_.factorize(shift_)) return true;
  }
  return false;
}

VectorXd ModeFinder::solve(const VectorXd& force, int refinements, VectorXd* multipliers) {
  VectorXd x = force;
  multipliers->setZero(static_cast<Rows>(equations_.model().num_rows()));
  kkt_.solve(x.data(), multipliers->data(), refinements);
  ++solves_;
  return x;
}

// ---- few freedoms ----

ModeSet ModeFinder::find_all() {
  const auto s = static_cast<Rows>(freedoms_);
  if (s == 0) return {{}, VectorXd(0), MatrixXd(mass_.size(), 0), 0.0, 0};
  // With W + s M near a multiple of M, solutions are almost projections: of random vectors they span all that can move.
  if (!factorize_below_all(10.0 * scale_))
    return end_without_modes(Status::Singular, "the stiffness matrix has no factor");
  MatrixXd Z = random_matrix(mass_.size(), s, 1);
  VectorXd multipliers;
  for (Rows j = 0; j < s; ++j)
    Z.col(j) = root_mass_.cwiseProduct(solve(mass_.cwiseProduct(Z.col(j)), full_refinements, &multipliers));
  const Eigen::HouseholderQR<MatrixXd> qr(Z);
  Z = qr.householderQ() * MatrixXd::Identity(mass_.size(), s);
  Z = root_mass_.cwiseInverse().asDiagonal() * Z;

  MatrixXd WZ(mass_.size(), s);
  for (Rows j = 0; j < s; ++j) equations_.stiffness().multiply(Z.col(j).data(), WZ.col(j).data());
  MatrixXd stiffness = Z.transpose() * WZ;
  stiffness = 0.5 * (stiffness + stiffness.transpose()).eval();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(stiffness);
  const VectorXd& omega2 = eigen.eigenvalues();
  const MatrixXd rest = stiffness * eigen.eigenvectors() - eigen.eigenvectors() * omega2.asDiagonal();
  const double largest = std::max(omega2.cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
  return {{}, omega2, Z * eigen.eigenvectors(), rest.colwise().norm().maxCoeff() / largest, solves_};
}

// ---- many freedoms ----

/// What Lanczos' method sees, in the form that Spectra wants: y = M^1/2 Z (Z'(W + s M)Z)^-1 Z' M^1/2 x, without what
/// was found before.
class ModeFinder::Operator {
 public:
  using Scalar = double;

  Operator(ModeFinder& finder, const MatrixXd& found)
      : finder_(finder), found_(finder.root_mass_.asDiagonal() * found) {}

  Rows rows() const { return finder_.mass_.size(); }
  Rows cols() const { return rows(); }
  void perform_op(const double* x_in, double* y_out) const {
    const Eigen::Map<const VectorXd> x(x_in, rows());
    Eigen::Map<VectorXd> y(y_out, rows());
    VectorXd multipliers;
    y = finder_.root_mass_.cwiseProduct(finder_.solve(finder_.root_mass_.cwiseProduct(x), 1, &multipliers));
    if (found_.cols() > 0) y -= found_ * (found_.transpose() * y);
  }

 private:
  ModeFinder& finder_;
  MatrixXd found_;
};

/// The `count` lowest modes that are M-orthogonal to those `found`, M-orthonormal by columns; fewer where it stalls.
MatrixXd ModeFinder::run_lanczos(std::size_t count, double tolerance, const MatrixXd& found) {
  const std::size_t left = freedoms_ - static_cast<std::size_t>(found.cols());
  count = std::min(count, left - 1);
  if (count == 0) return MatrixXd(mass_.size(), 0);
  const auto dimension = static_cast<Rows>(std::min(2 * count + spare_dimensions, left));
  Operator op(*this, found);
  Spectra::SymEigsSolver<Operator> solver(op, static_cast<Rows>(count), dimension);
  const VectorXd start = random_matrix(mass_.size(), 1, static_cast<unsigned>(2 + found.cols()));
  solver.init(start.data());
  solver.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance);
  return root_mass_.cwiseInverse().asDiagonal() * solver.eigenvectors();
}

VectorXd ModeFinder::rayleigh_quotients(const MatrixXd& x) const {
  VectorXd result(x.cols()), Wx(x.rows());
  for (Rows j = 0; j < x.cols(); ++j) {
    equations_.stiffness().multiply(x.col(j).data(), Wx.data());
    result[j] = x.col(j).dot(Wx) / x.col(j).cwiseAbs2().dot(mass_);
  }
  return result;
}

/// Rayleigh-Ritz: the best modes that the columns of x span. The residual is that of the lowest `wanted` ones.
ModeSet ModeFinder::rotate(Pairs pairs, std::size_t wanted) const {
  const Rows count = pairs.x.cols();
  MatrixXd Wx(mass_.size(), count);
  for (Rows j = 0; j < count; ++j) {
    const double norm = std::sqrt(pairs.x.col(j).cwiseAbs2().dot(mass_));
    pairs.x.col(j) /= norm;
    pairs.multipliers.col(j) /= norm;
    equations_.stiffness().multiply(pairs.x.col(j).data(), Wx.col(j).data());
  }
  const MatrixXd Mx = mass_.asDiagonal() * pairs.x;
  const MatrixXd stiffness = pairs.x.transpose() * Wx, masses = pairs.x.transpose() * Mx;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(0.5 * (stiffness + stiffness.transpose()),
                                                                 0.5 * (masses + masses.transpose()));
  const MatrixXd& rotation = eigen.eigenvectors();
  ModeSet result{{}, eigen.eigenvalues(), pairs.x * rotation, 0.0, solves_};
  MatrixXd rest = Wx * rotation - (Mx * rotation) * result.omega2.asDiagonal();
  const MatrixXd multipliers = pairs.multipliers * rotation;
  const Rows last = std::min(count, static_cast<Rows>(wanted));
  for (Rows j = 0; j < last; ++j) {
    equations_.add_reactions(multipliers.col(j).data(), rest.col(j).data());
    const double length = rest.col(j).cwiseQuotient(root_mass_).norm();
    result.residual = std::max(result.residual, length);
  }
  result.residual /= std::max(result.omega2.head(last).cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
  return result;
}

/// Inverse iteration on all columns together: (W + s M) y + K mu = M x, K'y = 0, then the best modes that y spans.
ModeSet ModeFinder::refine(MatrixXd x, std::size_t wanted) {
  ModeSet best;
  for (int k = 0; k < most_refinements; ++k) {
    Pairs pairs{x, MatrixXd(static_cast<Rows>(equations_.model().num_rows()), x.cols())};
    VectorXd multipliers;
    for (Rows j = 0; j < x.cols(); ++j) {
      pairs.x.col(j) = solve(mass_.cwiseProduct(x.col(j)), full_refinements, &multipliers);
      pairs.multipliers.col(j) = multipliers;
    }
    ModeSet next = rotate(std::move(pairs), wanted);
    const bool is_better = k == 0 || next.residual < 0.5 * best.residual;
    if (k == 0 || next.residual < best.residual) best = std::move(next);
    if (!is_better || best.residual <= small_residual) break;
    x = best.shapes;
  }
  return best;
}

/// A number between the omega^2 of two modes that stand clearly apart, at or behind the last one that is wanted.
ModeFinder::Bound ModeFinder::choose_bound(const VectorXd& omega2, std::size_t count) const {
  double widest = clear_gap;
  Bound bound;
  for (auto k = static_cast<Rows>(count); k < omega2.size(); ++k) {
    const double gap = (omega2[k] - omega2[k - 1]) / (std::abs(omega2[k]) + shift_);
    if (gap <= widest) continue;
    widest = gap;
    bound = {0.5 * (omega2[k] + omega2[k - 1]), static_cast<std::size_t>(k)};
  }
  if (bound.modes > 0) return bound;
  // The last mode that is wanted and those behind it are equal: what lies below all of these is counted.
  Rows k = static_cast<Rows>(count) - 1;
  const double little = clear_gap * (std::abs(omega2[k]) + shift_);
  while (k > 0 && omega2[k] - omega2[k - 1] < little) --k;
  return {omega2[k] - 0.5 * little, static_cast<std::size_t>(k)};
}

ModeSet ModeFinder::find_lowest(std::size_t count, double tolerance) {
  if (!factorize_below_all(least_shift * scale_))
    return end_without_modes(Status::Singular, "the stiffness matrix has no factor");
  const MatrixXd none(mass_.size(), 0);
  MatrixXd found = run_lanczos(std::min(count + num_guards, freedoms_ - 1), tolerance, none);
  std::size_t searches = 0;
  while (static_cast<std::size_t>(found.cols()) >= count) {
    ModeSet modes = refine(std::move(found), count);
    const Bound bound = choose_bound(modes.omega2, count);
    // In(A - omega^2 M): a pivot that vanishes says nothing, but one more search does.
    const std::optional<std::size_t> counted = kkt_.count_below(bound.omega2);
    const std::size_t below = counted.value_or(bound.modes + 1);
    const std::size_t missing = below > bound.modes ? std::min(below - bound.modes, count) : 0;
    const MatrixXd more =
        missing > 0 && searches < most_searches ? run_lanczos(missing, tolerance, modes.shapes) : none;
    ++searches;
    const bool finds_none = more.cols() > 0 && rayleigh_quotients(more).minCoeff() > bound.omega2;
    if (missing > 0 && (more.cols() == 0 || (finds_none && counted)))
      return end_without_modes(Status::NotConverged, std::to_string(bound.modes) + " of " + std::to_string(below) +
                                                         " modes below omega^2 = " + text(bound.omega2) +
                                                         " 1/s^2 were found");
    if (missing == 0 || finds_none) {
      modes.omega2.conservativeResize(static_cast<Rows>(count));
      modes.shapes.conservativeResize(Eigen::NoChange, static_cast<Rows>(count));
      return modes;
    }
    found.resize(mass_.size(), modes.shapes.cols() + more.cols());
    found << modes.shapes, more;
    // The lowest ones are kept, with as many behind them as before.
    const ModeSet merged =
        rotate({found, MatrixXd::Zero(static_cast<Rows>(equations_.model().num_rows()), found.cols())}, count);
    found = merged.shapes.leftCols(std::min(found.cols(), static_cast<Rows>(count + num_guards)));
  }
  return end_without_modes(Status::NotConverged, "Lanczos' method found " + std::to_string(found.cols()) + " of " +
                                                     std::to_string(count) + " modes");
}

}  // namespace tanor
