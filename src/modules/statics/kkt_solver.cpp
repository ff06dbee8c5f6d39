#include "statics/kkt_solver.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/pack.hpp"

namespace tanor::detail {

using Eigen::MatrixXd, Eigen::VectorXd;

namespace {

double largest(const Eigen::Ref<const MatrixXd>& a) {
  return a.size() > 0 ? a.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() : 0.0;
}

}  // namespace

KktSolver::KktSolver(const EquilibriumEquations& equations, Ordering ordering)
    : equations_(equations), model_(equations.model()), ordering_(ordering), penalties_(model_.num_rows(), 0.0) {
  follow_pattern();
}

/// Rebuilds matrix and factor if the pattern of W has changed, as it does when pairs come within the cutoff or leave
/// it.
void KktSolver::follow_pattern() {
  if (matrix_ && matrix_->pattern_version() == equations_.stiffness().pattern_version()) return;
  matrix_.emplace(equations_, ordering_);
  factor_.emplace(matrix_->lower());
}

bool KktSolver::factorize(double shift) {
  return factorize(std::vector<double>(matrix_->num_points(), shift));
}

bool KktSolver::factorize(std::vector<double> shifts) {
  shifts_ = std::move(shifts);
  follow_pattern();
  matrix_->assemble(shifts_, 1.0, &penalties_);
  return factor_->factorize(matrix_->lower_values().data(), model_.parallel.threads()).positive_definite;
}

std::optional<std::size_t> KktSolver::count_below(double omega2, double stiffer) {
  return count_below(std::vector<double>(matrix_->num_points(), omega2), stiffer);
}

std::optional<std::size_t> KktSolver::count_below(std::vector<double> omega2, double stiffer) {
  std::vector<double> penalties;  // kept apart from the factor's penalties, which `solve` still needs
  for (double& each : omega2) each = -each;
  follow_pattern();
  matrix_->assemble(omega2, stiffer, &penalties);
  const TrianglePattern& lower = matrix_->lower();
  const auto size = static_cast<Eigen::Index>(lower.size()), nonzeros = static_cast<Eigen::Index>(lower.rows.size());
  const Eigen::SparseMatrix<double> upper =
      Eigen::Map<const Eigen::SparseMatrix<double>>(size, size, nonzeros, lower.start.data(), lower.rows.data(),
                                                    matrix_->lower_values().data())
          .transpose();
  const int *const start = upper.outerIndexPtr(), *const rows = upper.innerIndexPtr();
  return count_negative_eigenvalues({{start, start + size + 1}, {rows, rows + nonzeros}},
                                    {upper.valuePtr(), upper.valuePtr() + nonzeros});
}

/// Computes x := A^-1 x, of many columns eight at once.
void KktSolver::apply_inverse(MatrixXd* x) {
  const std::size_t n = matrix_->num_points(), columns = static_cast<std::size_t>(x->cols());
  const std::size_t width = columns == 1 ? 1 : num_lanes, size = 3 * n * width;
  const std::size_t groups = (columns + width - 1) / width;
  lanes_.assign(groups * size, 0.0);
  const auto solve_groups = [&](std::size_t begin, std::size_t end) {
    double* const lanes = lanes_.data() + begin * size;
    const auto for_numbers = [&](const auto& visit) {
      for (std::size_t j = begin * width; j < std::min(end * width, columns); ++j) {
        double* const own = lanes_.data() + j / width * size + j % width;
        double* const column = x->col(static_cast<Eigen::Index>(j)).data();
        for (std::size_t i = 0; i < n; ++i) {
          double* const at = own + 3 * width * matrix_->place(i);
          for (std::size_t axis = 0; axis < 3; ++axis) visit(column[3 * i + axis], at[width * axis]);
        }
      }
    };
    for_numbers([](double& given, double& own) { own = given; });
    if (width == 1)
      factor_->solve(lanes, model_.parallel.threads());
    else
      factor_->solve_packs(lanes, end - begin);
    for_numbers([](double& found, double& own) { found = own; });
  };
  model_.parallel.for_ranges(groups, solve_groups, 1);
}

/// Compute y += K lambda, and rows = K'x, column by column.
void KktSolver::add_reactions(const MatrixXd& lambda, MatrixXd* y) const {
  for (Eigen::Index j = 0; j < lambda.cols(); ++j) equations_.add_reactions(lambda.col(j).data(), y->col(j).data());
}
void KktSolver::apply_transposed(const MatrixXd& x, MatrixXd* rows) const {
  rows->resize(static_cast<Eigen::Index>(penalties_.size()), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) equations_.apply_transposed(x.col(j).data(), rows->col(j).data());
}

/// Performs one round: x = A^-1(a + K(Cb - y)).
void KktSolver::solve_shifted(MatrixXd* x, MatrixXd* y, double of_rows) {
  const Eigen::Map<const VectorXd> C(penalties_.data(), static_cast<Eigen::Index>(penalties_.size()));
  // x = A^-1 (a + K C b), residual = K'x - b
  scaled_ = C.asDiagonal() * *y;
  add_reactions(scaled_, x);
  apply_inverse(x);
  apply_transposed(*x, &rows_residual_);
  rows_residual_ -= *y;
  find_multipliers(x, y, of_rows);
}

void KktSolver::solve_roughly(MatrixXd* x) {
  const Eigen::Map<const VectorXd> C(penalties_.data(), static_cast<Eigen::Index>(penalties_.size()));
  apply_inverse(x);
  // x -= A^-1 K C K'x
  apply_transposed(*x, &rows_residual_);
  scaled_ = C.asDiagonal() * rows_residual_;
  move_.setZero(x->rows(), x->cols());
  add_reactions(scaled_, &move_);
  apply_inverse(&move_);
  *x -= move_;
}

/// Finds y by conjugate residuals preconditioned by C, separately for each column, and subtracts A^-1 K y from x. The
/// residual of the rows in the norm of C falls with every step until its part outside the range of K' is left.
void KktSolver::find_multipliers(MatrixXd* x, MatrixXd* y, double of_rows) {
  constexpr int most_steps = 12;
  constexpr double least_gain = 0.9;
  constexpr double nothing = 1e-200;  // smaller squares lose their digits
  const Eigen::Map<const VectorXd> C(penalties_.data(), static_cast<Eigen::Index>(penalties_.size()));
  const Eigen::Index columns = x->cols();
  y->setZero();
  VectorXd first(columns), before(columns), curvature_before(columns);
  std::vector<char> is_done(static_cast<std::size_t>(columns), 0);
  for (int step = 0; step < most_steps; ++step) {
    scaled_ = C.asDiagonal() * rows_residual_;
    const VectorXd now = scaled_.cwiseProduct(rows_residual_).colwise().sum();
    if (step == 0) first = now;
    for (Eigen::Index j = 0; j < columns; ++j) {
      char& done = is_done[static_cast<std::size_t>(j)];
      if (!(now[j] > std::max(nothing, of_rows * first[j])) || (step > 0 && now[j] > least_gain * before[j])) done = 1;
      if (done != 0) scaled_.col(j).setZero();
    }
    if (std::ranges::all_of(is_done, [](char done) { return done != 0; })) break;
    before = now;
    move_.setZero(x->rows(), columns);
    add_reactions(scaled_, &move_);
    apply_inverse(&move_);
    apply_transposed(move_, &image_);
    if (step == 0) {
      direction_.resizeLike(scaled_);
      direction_image_.resizeLike(image_);
      direction_move_.resizeLike(move_);
    }
    for (Eigen::Index j = 0; j < columns; ++j) {
      const double curvature = scaled_.col(j).dot(image_.col(j));
      if (is_done[static_cast<std::size_t>(j)] != 0 || !(curvature > 0.0)) {
        is_done[static_cast<std::size_t>(j)] = 1;
        continue;
      }
      const auto extend = [&](const auto& part, auto direction) {
        if (step == 0)
          direction = part;
        else
          direction = part + curvature / curvature_before[j] * direction;
      };
      extend(scaled_.col(j), direction_.col(j));
      extend(image_.col(j), direction_image_.col(j));
      extend(move_.col(j), direction_move_.col(j));
      curvature_before[j] = curvature;
      const double length = curvature / direction_image_.col(j).cwiseAbs2().dot(C);
      y->col(j) += length * direction_.col(j);
      rows_residual_.col(j) -= length * direction_image_.col(j);
      x->col(j) -= length * direction_move_.col(j);
    }
  }
}

double KktSolver::solve(double* x, double* y, int refinements) {
  return solve(Eigen::Map<MatrixXd>(x, static_cast<Eigen::Index>(equations_.size()), 1),
               Eigen::Map<MatrixXd>(y, static_cast<Eigen::Index>(penalties_.size()), 1), {.refinements = refinements});
}

double KktSolver::solve(Eigen::Ref<MatrixXd> x, Eigen::Ref<MatrixXd> y, Accuracy accuracy) {
  const Eigen::Map<const VectorXd> C(penalties_.data(), static_cast<Eigen::Index>(penalties_.size()));
  const MatrixXd given = x, rows_given = C.cwiseSign().asDiagonal() * y;
  MatrixXd dx = given, dy = y;
  x.setZero();
  y.setZero();
  double residual = 0.0, rows_before = 0.0;
  for (int round = 0; round < accuracy.refinements; ++round) {
    solve_shifted(&dx, &dy, accuracy.of_rows);
    x += dx;
    y += dy;
    // a - (W + s M) x - K y, and b - K'x
    double worst = 0.0;
    for (Eigen::Index j = 0; j < x.cols(); ++j) {
      equations_.stiffness().multiply(x.col(j).data(), dx.col(j).data());
      const double scale = std::max(largest(given.col(j)), largest(dx.col(j)));
      for (Eigen::Index i = 0; i < dx.rows(); ++i)
        dx(i, j) = given(i, j) - dx(i, j) -
                   shifts_[static_cast<std::size_t>(i) / 3] * model_.mass[static_cast<std::size_t>(i) / 3] * x(i, j);
      scaled_.col(j) = -y.col(j);
      equations_.add_reactions(scaled_.col(j).data(), dx.col(j).data());
      if (scale > 0.0) worst = larger(worst, largest(dx.col(j)) / scale);
    }
    apply_transposed(x, &dy);
    dy = rows_given - dy;
    const double rows_now = largest(dy), wanted = largest(rows_given);
    const bool is_better = round == 0 || worst < 0.5 * residual || rows_now < 0.5 * rows_before;
    residual = worst;
    rows_before = rows_now;
    row_residual_ = wanted > 0.0 ? rows_now / wanted : 0.0;
    if ((worst < 1e-15 && rows_now < 1e-15 * wanted) || !is_better) break;
  }
  return residual;
}

}  // namespace tanor::detail
