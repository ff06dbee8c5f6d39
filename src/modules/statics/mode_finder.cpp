#include "statics/mode_finder.hpp"

#include <Spectra/SymEigsSolver.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "base/dense.hpp"
#include "base/text.hpp"
#include "statics/deflated.hpp"
#include "statics/islands.hpp"

namespace tanor::detail {

using Eigen::MatrixXd, Eigen::VectorXd;
using Rows = Eigen::Index;

namespace {

/// Shifts are tried from the smallest on; each is larger than the one before by this factor.
constexpr double growth_of_shift = 8.0;
/// Modes computed beyond the wanted ones. The bound below which all modes are counted is put into a gap among them.
constexpr std::size_t num_guards = 2;
/// Columns of the Krylov space beyond twice the number of modes, and restarts after which the modes that have converged
/// are set aside.
constexpr Rows spare_columns = 20;
constexpr Rows most_restarts = 50;
/// Part of the tolerance to which Lanczos' method, and the inverse iterations on all modes after it, converge. Beside a
/// large shift the eigenvalues of the inverse lie close together, and shapes have fewer digits than eigenvalues.
constexpr double part_of_tolerance = 0.1;
constexpr int most_refinements = 8;
/// Accuracies of a solve with the KKT matrix: for moves of any kind; for modes, which inverse iteration refines
/// further; and for modes to a tolerance below 1e-10 or with a badly conditioned K.
constexpr KktSolver::Accuracy of_moves{3, 1e-24}, of_modes{2, 1e-8}, of_precise_modes{8, 1e-24};
constexpr double least_usual_tolerance = 1e-10;
/// Rounding error in residuals of modes far from the shift, relative to the scale of omega^2.
constexpr double rounding_of_residual = 1e-12;
/// A gap that exceeds this part of omega^2 + s separates two modes for certain. With constraints as penalties of 1e5
/// the second factor knows omega^2 to 1e-5.
constexpr double clear_gap = 1e-3;
/// Gaps must also exceed this part of the scale of omega^2, which is lost in rounding.
constexpr double least_gap = 1e-9;
constexpr std::size_t most_searches = 8;
/// Modes nearer to each other than this part of omega^2 + s are copies of one.
constexpr double equal_to = 1e-6;

MatrixXd random_matrix(Rows rows, Rows columns, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

}  // namespace

ModeFinder::ModeFinder(const EquilibriumEquations& equations, KktSolver& kkt, std::size_t freedoms,
                       const std::vector<std::size_t>& dependent)
    : equations_(equations), kkt_(kkt), freedoms_(freedoms), mass_(equations.masses()), root_mass_(mass_.cwiseSqrt()) {
  double largest = 0.0;
  for (std::size_t i = 0; i < equations.stiffness().num_points(); ++i)
    largest = std::max(largest, equations.stiffness().largest_of(i) / equations.model().mass[i]);
  if (largest > 0.0) scale_ = largest;
  group_by_islands(dependent);
}

/// Groups coordinates and freedoms by islands. All form one group if the dependent rows do not tell which freedoms
/// belong to which island.
void ModeFinder::group_by_islands(const std::vector<std::size_t>& dependent) {
  std::vector<char> counts(equations_.model().num_rows(), 1);
  for (const std::size_t row : dependent) counts[row] = 0;
  Rows sum = 0;
  for (const StaticsIsland& island : StaticsIslands(equations_).list) {
    const auto rows = std::ranges::count_if(island.rows, [&](std::size_t row) { return counts[row] != 0; });
    Island own{island.coordinates(), sum, static_cast<Rows>(3 * island.points.size()) - rows};
    sum += own.freedoms;
    if (own.freedoms > 0) islands_.push_back(std::move(own));
  }
  if (sum == static_cast<Rows>(freedoms_)) return;
  islands_.resize(1);
  islands_[0] = {{}, 0, static_cast<Rows>(freedoms_)};
  for (Rows i = 0; i < mass_.size(); ++i) islands_[0].coordinates.push_back(i);
}

/// Finds a shift at which W + s M is positive definite where K'x = 0, and its factor.
bool ModeFinder::factorize_below_all(double first_shift) {
  for (shift_ = first_shift; shift_ < 1e6 * scale_; shift_ *= growth_of_shift) {
    if (kkt_.factorize(shift_)) return true;
  }
  return false;
}

/// Solves (W + s M) x + K mu = forces, K'x = 0.
ModeFinder::Pairs ModeFinder::solve(MatrixXd forces, KktSolver::Accuracy accuracy) {
  MatrixXd none = MatrixXd::Zero(static_cast<Rows>(equations_.model().num_rows()), forces.cols());
  Pairs result{std::move(forces), std::move(none)};
  kkt_.solve(result.x, result.multipliers, accuracy);
  return result;
}

// ---- few freedoms ----

std::optional<MatrixXd> ModeFinder::find_basis() {
  const auto s = static_cast<Rows>(freedoms_);
  if (s == 0) return MatrixXd(mass_.size(), 0);
  // With W + s M near a multiple of M, solutions are almost projections: those of random vectors span all possible
  // moves.
  if (!factorize_below_all(10.0 * scale_)) return std::nullopt;
  MatrixXd forces = random_matrix(mass_.size(), s, 1);
  for (const Island& island : islands_) {
    const MatrixXd own = forces(island.coordinates, island.columns());
    forces(Eigen::all, island.columns()).setZero();
    forces(island.coordinates, island.columns()) = own;
  }
  // The forces s M x give solutions of the size of the projected x.
  const MatrixXd moves = root_mass_.asDiagonal() * solve(shift_ * mass_.asDiagonal() * forces, of_moves).x;
  MatrixXd basis = MatrixXd::Zero(mass_.size(), s);
  for (const Island& island : islands_)
    basis(island.coordinates, island.columns()) = dense::find_thin_qr(moves(island.coordinates, island.columns())).Q;
  return MatrixXd(root_mass_.cwiseInverse().asDiagonal() * basis);
}

ModeSet ModeFinder::find_all() {
  const std::optional<MatrixXd> basis = find_basis();
  if (!basis) return {.outcome = {Status::Singular, "the stiffness matrix has no factor"}};
  const MatrixXd& Z = *basis;
  if (Z.cols() == 0) return {{}, VectorXd(0), Z};
  MatrixXd stiffness = Z.transpose() * equations_.stiffness().multiply(Z);
  stiffness = 0.5 * (stiffness + stiffness.transpose()).eval();
  VectorXd omega2(Z.cols());
  MatrixXd shapes(mass_.size(), Z.cols());
  double rest = 0.0;
  for (const Island& island : islands_) {
    const MatrixXd own = stiffness(island.columns(), island.columns());
    const dense::SymmetricEigen eigen = dense::find_eigen(own);
    omega2(island.columns()) = eigen.values;
    shapes(Eigen::all, island.columns()) = Z(Eigen::all, island.columns()) * eigen.vectors;
    rest =
        std::max(rest, (own * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).colwise().norm().maxCoeff());
  }
  std::vector<Rows> order(static_cast<std::size_t>(omega2.size()));
  std::iota(order.begin(), order.end(), Rows{0});
  std::ranges::stable_sort(order, {}, [&](Rows k) { return omega2[k]; });
  const double largest = std::max(omega2.cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
  return {{}, omega2(order), shapes(Eigen::all, order), rest / largest};
}

// ---- many freedoms ----

/// Applies M^1/2 Z (Z'(W + s M)Z)^-1 Z' M^1/2 with the current factor.
void ModeFinder::apply(const double* from, double* to) {
  const auto x = Eigen::Map<const VectorXd>(from, mass_.size());
  MatrixXd y = root_mass_.cwiseProduct(x);
  if (is_precise_)
    y = solve(std::move(y), of_precise_modes).x;
  else
    kkt_.solve_roughly(&y);
  Eigen::Map<VectorXd>(to, mass_.size()) = root_mass_.cwiseProduct(y.col(0));
}

/// Returns the `count` lowest modes that are M-orthogonal to those `found`, M-orthonormal by columns. Returns fewer if
/// the iteration stalls with precise products too. What has converged is deflated before the rest is sought, because it
/// takes digits from all that lies further from the shift.
MatrixXd ModeFinder::search(std::size_t count, double tolerance, const MatrixXd& found) {
  MatrixXd V = root_mass_.asDiagonal() * found;
  const Rows size = mass_.size(), last = std::min(V.cols() + static_cast<Rows>(count), static_cast<Rows>(freedoms_));
  while (V.cols() < last) {
    const Rows wanted = std::min(last - V.cols(), size - 1);
    double unit = 1.0;
    Deflated operation(V, [&](const double* from, double* to) {
      apply(from, to);
      Eigen::Map<VectorXd>(to, size) /= unit;
    });
    const VectorXd start = find_start(operation, random_matrix(size, 1, static_cast<unsigned>(2 + V.cols())), &unit);
    if (!(unit > 0.0) || !std::isfinite(unit)) break;
    Spectra::SymEigsSolver lanczos(operation, wanted, std::min(size, 2 * wanted + spare_columns));
    lanczos.init(start.data());
    const Rows converged = lanczos.compute(Spectra::SortRule::LargestAlge, most_restarts, tolerance);
    if (converged == 0 && std::exchange(is_precise_, true)) break;
    V.conservativeResize(Eigen::NoChange, V.cols() + converged);
    V.rightCols(converged) = lanczos.eigenvectors();
  }
  return root_mass_.cwiseInverse().asDiagonal() * V.rightCols(V.cols() - found.cols());
}

/// Returns modes that are M-orthogonal to those of `modes`, until the lowest of what is left is no lower than the
/// `count` lowest ones. Of a mode that stands many times each search finds one copy, and those of higher modes; so only
/// as many are sought as were among the lowest before.
MatrixXd ModeFinder::search_missing(const ModeSet& modes, std::size_t count, std::size_t missing, double tolerance) {
  MatrixXd all = modes.shapes;
  std::vector<double> omega2(modes.omega2.begin(), modes.omega2.end());
  while (missing > 0) {
    const MatrixXd more = search(missing, tolerance, all);
    const VectorXd own = rayleigh_quotients(more);
    omega2.insert(omega2.end(), own.begin(), own.end());
    std::ranges::sort(omega2);
    const double last = omega2[count - 1], clearly_below = last - equal_to * (std::abs(last) + std::abs(shift_));
    missing = static_cast<std::size_t>((own.array() < clearly_below).count());
    all.conservativeResize(Eigen::NoChange, all.cols() + more.cols());
    all.rightCols(more.cols()) = more;
  }
  return all.rightCols(all.cols() - modes.shapes.cols());
}

VectorXd ModeFinder::rayleigh_quotients(const MatrixXd& x) const {
  const VectorXd stiffness = x.cwiseProduct(equations_.stiffness().multiply(x)).colwise().sum();
  const VectorXd masses = x.cwiseAbs2().transpose() * mass_;
  return stiffness.cwiseQuotient(masses);
}

/// Performs a Rayleigh-Ritz step: finds the best modes that the columns of x span. The residual is that of the lowest
/// `wanted` ones.
ModeSet ModeFinder::rotate(Pairs pairs, std::size_t wanted) const {
  const Rows count = pairs.x.cols();
  ModeSet result;
  result.shapes.resize(mass_.size(), 0);
  if (count == 0) return result;
  const VectorXd scale = (pairs.x.cwiseAbs2().transpose() * mass_).cwiseSqrt().cwiseInverse();
  pairs.x *= scale.asDiagonal();
  pairs.multipliers *= scale.asDiagonal();
  const MatrixXd Wx = equations_.stiffness().multiply(pairs.x);
  const MatrixXd Mx = mass_.asDiagonal() * pairs.x;
  const MatrixXd stiffness = pairs.x.transpose() * Wx, masses = pairs.x.transpose() * Mx;
  const dense::SymmetricEigen eigen =
      dense::find_eigen(0.5 * (stiffness + stiffness.transpose()), 0.5 * (masses + masses.transpose()));
  const MatrixXd& rotation = eigen.vectors;
  result.omega2 = eigen.values;
  result.shapes = pairs.x * rotation;
  MatrixXd rest = Wx * rotation - mass_.asDiagonal() * result.shapes * result.omega2.asDiagonal();
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

/// Performs inverse iteration on all columns together: (W + s M) y + K mu = M x, K'y = 0, then Rayleigh-Ritz on y.
ModeSet ModeFinder::refine(MatrixXd x, std::size_t wanted, double tolerance) {
  ModeSet best;
  for (int k = 0; k < most_refinements; ++k) {
    ModeSet next = rotate(solve(mass_.asDiagonal() * x, is_precise_ ? of_precise_modes : of_modes), wanted);
    const bool is_better = k == 0 || next.residual < 0.8 * best.residual;
    if (k == 0 || next.residual < best.residual) best = std::move(next);
    if (!is_better || best.residual <= part_of_tolerance * tolerance) break;
    x = best.shapes;
  }
  return best;
}

double ModeFinder::residual_to_rounding(double lowest_omega2) const {
  const double nearest = std::max(lowest_omega2 + shift_, least_shift * scale_);
  return (rounding_of_residual + std::numeric_limits<double>::epsilon() * scale_ / nearest) * scale_;
}

/// Returns true if the worst residual is within the tolerance or within rounding.
bool ModeFinder::meets(const ModeSet& modes, std::size_t wanted, double tolerance) const {
  const double largest = modes.omega2.head(static_cast<Rows>(wanted)).cwiseAbs().maxCoeff();
  return modes.residual * largest <=
         std::max(tolerance * (largest + std::abs(shift_)), residual_to_rounding(modes.omega2[0]));
}

/// Refines the modes. If K is so badly conditioned that products had too few digits, a search with precise ones
/// precedes.
ModeSet ModeFinder::refine_or_search(MatrixXd x, std::size_t wanted, double tolerance) {
  const auto sought = static_cast<std::size_t>(x.cols());
  ModeSet modes = refine(std::move(x), wanted, tolerance);
  if (is_precise_ || meets(modes, wanted, tolerance)) return modes;
  is_precise_ = true;
  MatrixXd again = search(sought, part_of_tolerance * tolerance, MatrixXd(mass_.size(), 0));
  if (static_cast<std::size_t>(again.cols()) < wanted) return modes;
  return refine(std::move(again), wanted, tolerance);
}

/// Returns a number between the omega^2 of two clearly separate modes, at or behind the last wanted one.
ModeFinder::Bound ModeFinder::choose_bound(const VectorXd& omega2, std::size_t count) const {
  const auto apart = [&](double value) { return std::abs(value) + std::abs(shift_); };
  const double least = least_gap * scale_;
  double widest = clear_gap;
  Bound bound;
  for (auto k = static_cast<Rows>(count); k < omega2.size(); ++k) {
    const double step = omega2[k] - omega2[k - 1], gap = step / apart(omega2[k]);
    if (gap <= widest || step <= least) continue;
    widest = gap;
    bound = {0.5 * (omega2[k] + omega2[k - 1]), static_cast<std::size_t>(k)};
  }
  if (bound.modes > 0) return bound;
  // The last wanted mode and those behind it are equal, so the bound lies below all of these.
  Rows k = static_cast<Rows>(count) - 1;
  const double little = std::max(clear_gap * apart(omega2[k]), least);
  while (k > 0 && omega2[k] - omega2[k - 1] < little) --k;
  return {omega2[k] - 0.5 * little, static_cast<std::size_t>(k)};
}

ModeSet ModeFinder::find_some_lowest(double shift, std::size_t count) {
  constexpr double tolerance = 1e-8;  // the errors of Rayleigh quotients are its square
  shift_ = shift;
  MatrixXd found = search(count, tolerance, MatrixXd(mass_.size(), 0));
  if (found.cols() == 0) return {};
  const auto wanted = static_cast<std::size_t>(found.cols());
  return refine(std::move(found), wanted, tolerance);
}

/// Counts the modes below the bound. If none is expected there, a Cholesky factorization by fronts proves it sooner
/// than the pivots do, and the current one may have proved it already.
std::optional<std::size_t> ModeFinder::count_below(const Bound& bound) {
  if (bound.modes == 0 && bound.omega2 <= -shift_) return 0;
  if (bound.modes == 0 && kkt_.factorize(-bound.omega2)) return 0;
  if (bound.modes == 0 && !kkt_.factorize(shift_)) return std::nullopt;
  // Clear gaps tolerate the rounding errors of a larger C, whereas a badly conditioned K does not tolerate a small C.
  constexpr double stiffer = 100.0;
  return kkt_.count_below(bound.omega2, stiffer);
}

ModeSet ModeFinder::find_lowest(std::size_t count, double tolerance) {
  is_precise_ = tolerance < least_usual_tolerance;
  if (!factorize_below_all(least_shift * scale_))
    return {.outcome = {Status::Singular, "the stiffness matrix has no factor"}};
  const MatrixXd none(mass_.size(), 0);
  MatrixXd found = search(count + num_guards, part_of_tolerance * tolerance, none);
  for (std::size_t searches = 0; static_cast<std::size_t>(found.cols()) >= count; ++searches) {
    ModeSet modes = refine_or_search(std::move(found), count, tolerance);
    const Bound bound = choose_bound(modes.omega2, count);
    // The inertia of A - omega^2 M counts the modes. A vanishing pivot leaves it unknown, and one more search decides.
    const std::optional<std::size_t> counted = count_below(bound);
    const std::size_t below = counted.value_or(bound.modes + 1);
    const std::size_t missing = below > bound.modes ? std::min(below - bound.modes, count) : 0;
    const MatrixXd more = missing > 0 && searches < most_searches
                              ? search_missing(modes, count, missing, part_of_tolerance * tolerance)
                              : none;
    const bool finds_none = more.cols() > 0 && rayleigh_quotients(more).minCoeff() > bound.omega2;
    if (missing > 0 && (more.cols() == 0 || (finds_none && counted)))
      return {.outcome = {Status::NotConverged, std::to_string(bound.modes) + " of " + std::to_string(below) +
                                                    " modes below omega^2 = " + text(bound.omega2) + " were found"}};
    if (missing == 0 || finds_none) {
      modes.omega2.conservativeResize(static_cast<Rows>(count));
      modes.shapes.conservativeResize(Eigen::NoChange, static_cast<Rows>(count));
      return modes;
    }
    found.resize(mass_.size(), modes.shapes.cols() + more.cols());
    found << modes.shapes, more;
    // Keep the lowest ones, with as many guards as before.
    const ModeSet merged =
        rotate({found, MatrixXd::Zero(static_cast<Rows>(equations_.model().num_rows()), found.cols())}, count);
    found = merged.shapes.leftCols(std::min(found.cols(), static_cast<Rows>(count + num_guards)));
  }
  return {.outcome = {Status::NotConverged, "Lanczos' method found " + std::to_string(found.cols()) + " of " +
                                                std::to_string(count) + " modes"}};
}

}  // namespace tanor::detail
