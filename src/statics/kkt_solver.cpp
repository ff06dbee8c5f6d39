#include "statics/kkt_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/eight.hpp"
#include "factor/inertia.hpp"

namespace tanor {

using Eigen::MatrixXd, Eigen::VectorXd;

namespace {

/// C over the stiffness of its points: conjugate residuals then take two or three steps, and half of the digits that it
/// costs come back by one refinement.
constexpr double penalty = 1e5;

double largest(const Eigen::Ref<const MatrixXd>& a) {
  return a.size() > 0 ? a.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() : 0.0;
}

/// Pairs (column, row) of a triangle of points.
TrianglePattern make_triangle(std::size_t size, std::vector<std::pair<int, int>> entries) {
  TrianglePattern result;
  compress_pairs(size, std::move(entries), &result.start, &result.rows);
  return result;
}

/// visit(a, b) for all pairs of blocks in one row of K.
template <class Visit>
void for_pairs_of_rows(const Groups<Incidence>& by_row, const Visit& visit) {
  for (std::size_t row = 0; row < by_row.size(); ++row) {
    for (const Incidence& a : by_row[row]) {
      for (const Incidence& b : by_row[row]) visit(a, b);
    }
  }
}

}  // namespace

KktSolver::KktSolver(const EquilibriumEquations& equations, Ordering ordering)
    : equations_(equations), model_(equations.model()), ordering_(ordering), penalties_(model_.num_rows(), 0.0) {
  make_pattern();
}

void KktSolver::make_pattern() {
  pattern_version_ = equations_.stiffness().pattern_version();
  products_.clear();
  transposed_.clear();
  upper_ = lower_ = {};
  std::vector<std::pair<int, int>> entries;
  for_each_stiffness_block([&](int i, int j, std::size_t) { entries.push_back(std::minmax(i, j)); });
  const Groups<Incidence> by_row = group_by_row();
  for_pairs_of_rows(by_row,
                    [&](const Incidence& a, const Incidence& b) { entries.push_back(std::minmax(a.point, b.point)); });
  order_points(std::move(entries));

  stiffness_slots_.assign(equations_.stiffness().columns().size(), -1);
  for_each_stiffness_block([&](int i, int j, std::size_t k) { stiffness_slots_[k] = slot(i, j); });
  for_pairs_of_rows(by_row, [&](const Incidence& a, const Incidence& b) {
    if (const int at = slot(a.point, b.point); at >= 0)
      products_.push_back({a.row, a.block, b.block, a.sign * b.sign, at});
  });
  expand_pattern();
  factor_.emplace(lower_);
}

/// visit(i, j, k) for block k of W, on point i in the place of point j.
template <class Visit>
void KktSolver::for_each_stiffness_block(const Visit& visit) const {
  const StiffnessMatrix& W = equations_.stiffness();
  for (int i = 0; i < static_cast<int>(W.num_points()); ++i) {
    const auto begin = static_cast<std::size_t>(W.start()[static_cast<std::size_t>(i)]);
    const auto end = static_cast<std::size_t>(W.start()[static_cast<std::size_t>(i) + 1]);
    for (std::size_t k = begin; k < end; ++k) visit(i, W.columns()[k], k);
  }
}

/// The blocks of K of moving points, row by row.
Groups<Incidence> KktSolver::group_by_row() const {
  const std::size_t n = equations_.stiffness().num_points(), num_rows = equations_.num_rows();
  return {num_rows, [&](const auto& add) {
            for (const Incidence& incidence : model_.incidences) {
              if (static_cast<std::size_t>(incidence.row) < num_rows && static_cast<std::size_t>(incidence.point) < n)
                add(incidence.row, incidence);
            }
          }};
}

/// Finds the order of elimination and the blocks of A in it. `entries`: pairs of points that have a block.
void KktSolver::order_points(std::vector<std::pair<int, int>> entries) {
  const std::size_t n = equations_.stiffness().num_points();
  const SymbolicAnalysis order = analyze(make_triangle(n, entries), ordering_);
  place_.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    place_[order.permutation.empty() ? k : static_cast<std::size_t>(order.permutation[k])] = static_cast<int>(k);

  for (auto& [i, j] : entries) {
    const auto [row, column] = std::minmax(place_[static_cast<std::size_t>(i)], place_[static_cast<std::size_t>(j)]);
    i = column, j = row;
  }
  const TrianglePattern points = make_triangle(n, std::move(entries));
  start_ = points.start;
  rows_ = points.rows;
  blocks_.resize(rows_.size());
}

/// From blocks to numbers: the upper triangle, and the lower one that is factorized.
void KktSolver::expand_pattern() {
  // Column c of point j: 3 rows of each block above the diagonal, then the rows up to c of the diagonal's.
  for (std::size_t j = 0; j + 1 < start_.size(); ++j) {
    for (int c = 0; c < 3; ++c) {
      for (int k = start_[j]; k < start_[j + 1]; ++k) {
        const int first = 3 * rows_[static_cast<std::size_t>(k)], count = k + 1 < start_[j + 1] ? 3 : c + 1;
        for (int row = 0; row < count; ++row) upper_.rows.push_back(first + row);
      }
      upper_.start.push_back(static_cast<int>(upper_.rows.size()));
    }
  }
  values_.resize(upper_.rows.size());
  // The lower triangle: the transpose, by counting.
  const Groups<std::pair<int, int>> lower(upper_.size(), [&](const auto& add) {
    for (std::size_t column = 0; column < upper_.size(); ++column) {
      for (int k = upper_.start[column]; k < upper_.start[column + 1]; ++k)
        add(upper_.rows[static_cast<std::size_t>(k)], std::pair{static_cast<int>(column), k});
    }
  });
  lower_.start.assign(lower.start.begin(), lower.start.end());
  for (const auto& [row, k] : lower.entries) {
    lower_.rows.push_back(row);
    transposed_.push_back(k);
  }
}

/// Of the block (i, j) where it is in the upper triangle, else -1.
int KktSolver::slot(int i, int j) const {
  const int row = place_[static_cast<std::size_t>(i)], column = place_[static_cast<std::size_t>(j)];
  if (row > column) return -1;
  const auto begin = rows_.begin() + start_[static_cast<std::size_t>(column)];
  const auto end = rows_.begin() + start_[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin());
}

/// C_a = penalty (stiffness of the row's points)/|gradient|^2.
void KktSolver::find_penalties(const std::vector<double>& shifts, double stiffer) {
  const StiffnessMatrix& W = equations_.stiffness();
  std::vector<double> stiffness(W.num_points());
  double most = 0.0;
  for (std::size_t i = 0; i < stiffness.size(); ++i) {
    const Block3& own = blocks_[static_cast<std::size_t>(start_[static_cast<std::size_t>(place_[i]) + 1] - 1)];
    // Of W and of s M, which may cancel each other.
    const double mass = shifts[i] * model_.mass[i];
    for (int row = 0; row < 3; ++row) {
      for (int c = 0; c < 3; ++c)
        stiffness[i] = std::max(stiffness[i], std::abs(own(row, c) - (row == c ? mass : 0.0)) + std::abs(mass));
    }
    most = std::max(most, stiffness[i]);
  }
  const double least = most > 0.0 ? 1e-6 * most : 1.0;
  std::vector<double> squares(penalties_.size(), 0.0);
  std::fill(penalties_.begin(), penalties_.end(), least);
  for (const Incidence& incidence : model_.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), point = static_cast<std::size_t>(incidence.point);
    if (point >= stiffness.size()) continue;
    const Vec3 gradient = load(equations_.gradients().data(), incidence.block);
    squares[row] = std::max(squares[row], tanor::dot(gradient, gradient));
    penalties_[row] = std::max(penalties_[row], stiffness[point]);
  }
  for (std::size_t row = 0; row < penalties_.size(); ++row)
    penalties_[row] = squares[row] > 0.0 ? stiffer * penalty * penalties_[row] / squares[row] : 0.0;
}

void KktSolver::assemble(const std::vector<double>& shifts, double stiffer) {
  const StiffnessMatrix& W = equations_.stiffness();
  if (pattern_version_ != W.pattern_version()) make_pattern();
  const double* const K = equations_.gradients().data();
  std::fill(blocks_.begin(), blocks_.end(), Block3{});
  for (std::size_t k = 0; k < stiffness_slots_.size(); ++k) {
    if (stiffness_slots_[k] >= 0) blocks_[static_cast<std::size_t>(stiffness_slots_[k])] = W.blocks()[k];
  }
  for (std::size_t i = 0; i < place_.size(); ++i)
    blocks_[static_cast<std::size_t>(start_[static_cast<std::size_t>(place_[i]) + 1] - 1)].add_identity(shifts[i] *
                                                                                                        model_.mass[i]);
  find_penalties(shifts, stiffer);
  // += C g_a g_b'
  for (const auto& [row, a, b, sign, at] : products_)
    blocks_[static_cast<std::size_t>(at)].add_product(sign * penalties_[static_cast<std::size_t>(row)], load(K, a),
                                                      load(K, b));
  expand(values_.data());
}

void KktSolver::expand(double* values) const {
  for (std::size_t j = 0; j + 1 < start_.size(); ++j) {
    for (int c = 0; c < 3; ++c) {
      for (int k = start_[j]; k < start_[j + 1]; ++k) {
        const int count = k + 1 < start_[j + 1] ? 3 : c + 1;
        for (int row = 0; row < count; ++row) *values++ = blocks_[static_cast<std::size_t>(k)](row, c);
      }
    }
  }
}

bool KktSolver::factorize(double shift) {
  return factorize(std::vector<double>(place_.size(), shift));
}

bool KktSolver::factorize(std::vector<double> shifts) {
  shifts_ = std::move(shifts);
  assemble(shifts_, 1.0);
  std::vector<double> values(transposed_.size());
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = values_[static_cast<std::size_t>(transposed_[k])];
  return factor_->factorize(lower_, values.data(), model_.parallel.threads()) == lower_.size();
}

std::optional<std::size_t> KktSolver::count_below(double omega2, double stiffer) {
  return count_below(std::vector<double>(place_.size(), omega2), stiffer);
}

std::optional<std::size_t> KktSolver::count_below(std::vector<double> omega2, double stiffer) {
  const std::vector<double> of_factor = penalties_;  // which solve() goes on with
  for (double& each : omega2) each = -each;
  assemble(omega2, stiffer);
  penalties_ = of_factor;
  return count_negative_eigenvalues(upper_, values_);
}

/// x := A^-1 x, of many columns by eight at once.
void KktSolver::apply_inverse(MatrixXd* x) {
  const int threads = model_.parallel.threads();
  const std::size_t n = place_.size(), columns = static_cast<std::size_t>(x->cols());
  if (columns == 1) {
    ordered_.resize(3 * n);
    for (std::size_t i = 0; i < n; ++i) store(ordered_.data(), place_[i], load(x->data(), i));
    factor_->solve(ordered_.data(), threads);
    for (std::size_t i = 0; i < n; ++i) store(x->data(), i, load(ordered_.data(), place_[i]));
    return;
  }
  model_.parallel.for_ranges((columns + num_lanes - 1) / num_lanes,
                             [&](std::size_t begin, std::size_t end) {
                               const std::size_t size = 3 * n * num_lanes;
                               std::vector<double> lanes((end - begin) * size);
                               const auto for_numbers = [&](const auto& visit) {
                                 for (std::size_t j = begin * num_lanes; j < std::min(end * num_lanes, columns); ++j) {
                                   double* const own = lanes.data() + (j / num_lanes - begin) * size + j % num_lanes;
                                   double* const column = x->col(static_cast<Eigen::Index>(j)).data();
                                   for (std::size_t i = 0; i < n; ++i) {
                                     double* const at = own + 3 * num_lanes * static_cast<std::size_t>(place_[i]);
                                     for (std::size_t axis = 0; axis < 3; ++axis)
                                       visit(column[3 * i + axis], at[num_lanes * axis]);
                                   }
                                 }
                               };
                               for_numbers([](double& given, double& own) { own = given; });
                               factor_->solve_eights(lanes.data(), end - begin);
                               for_numbers([](double& found, double& own) { found = own; });
                             },
                             1);
}

/// y += K lambda, and rows = K'x, by columns.
void KktSolver::add_reactions(const MatrixXd& lambda, MatrixXd* y) const {
  for (Eigen::Index j = 0; j < lambda.cols(); ++j) equations_.add_reactions(lambda.col(j).data(), y->col(j).data());
}
void KktSolver::apply_transposed(const MatrixXd& x, MatrixXd* rows) const {
  rows->resize(static_cast<Eigen::Index>(penalties_.size()), x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) equations_.apply_transposed(x.col(j).data(), rows->col(j).data());
  for (std::size_t row = 0; row < penalties_.size(); ++row) {
    if (penalties_[row] == 0.0) rows->row(static_cast<Eigen::Index>(row)).setZero();
  }
}

/// One round: x = A^-1(a + K(Cb - y)).
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

/// y by conjugate residuals, which C preconditions, each column for itself; x -= A^-1 K y. What is left of the rows, in
/// the norm of C, falls with every step, and no more where b is none of K'x.
void KktSolver::find_multipliers(MatrixXd* x, MatrixXd* y, double of_rows) {
  constexpr int most_steps = 12;
  constexpr double least_gain = 0.9;
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
      if (!(now[j] > of_rows * first[j]) || (step > 0 && now[j] > least_gain * before[j])) done = 1;
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

}  // namespace tanor
