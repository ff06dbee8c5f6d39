#include "statics/kkt_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/groups.hpp"
#include "factor/inertia.hpp"
#include "plan/thresholds.hpp"
#include "statics/dot.hpp"

namespace tanor {

namespace {

/// C over the stiffness of its points: conjugate gradients then take two or three steps, and half of the digits that it
/// costs come back by one refinement.
constexpr double penalty = 1e5;

double largest(const std::vector<double>& a) {
  double result = 0.0;
  for (const double x : a) result = larger(result, std::abs(x));
  return result;
}

/// Pairs (column, row) of a triangle of points, sorted, each once.
TrianglePattern make_triangle(std::size_t size, std::vector<std::pair<int, int>> entries) {
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  TrianglePattern result;
  result.start.assign(size + 1, 0);
  for (const auto& [column, row] : entries) {
    ++result.start[static_cast<std::size_t>(column) + 1];
    result.rows.push_back(row);
  }
  for (std::size_t j = 0; j < size; ++j) result.start[j + 1] += result.start[j];
  return result;
}

}  // namespace

KktSolver::KktSolver(const EquilibriumEquations& equations, Ordering ordering)
    : equations_(equations), model_(equations.model()), penalties_(model_.num_rows(), 0.0) {
  make_pattern(ordering);
  for (std::vector<double>* each : {&ordered_, &force_, &move_, &product_, &residual_, &given_})
    each->resize(equations_.size());
  for (std::vector<double>* each : {&rows_residual_, &direction_, &image_, &scaled_, &rows_given_})
    each->resize(model_.num_rows());
}

void KktSolver::make_pattern(Ordering ordering) {
  const StiffnessMatrix& W = equations_.stiffness();
  const std::size_t n = W.num_points(), num_rows = equations_.num_rows();
  const Groups<Incidence> by_row(num_rows, [&](const auto& add) {
    for (const Incidence& incidence : model_.incidences) {
      if (static_cast<std::size_t>(incidence.row) < num_rows && static_cast<std::size_t>(incidence.point) < n)
        add(incidence.row, incidence);
    }
  });
  const auto for_pairs_of_rows = [&](const auto& visit) {
    for (std::size_t row = 0; row < num_rows; ++row) {
      for (const Incidence& a : by_row[row]) {
        for (const Incidence& b : by_row[row]) visit(a, b);
      }
    }
  };

  std::vector<std::pair<int, int>> entries;
  for (int i = 0; i < static_cast<int>(n); ++i) {
    for (int k = W.start()[static_cast<std::size_t>(i)]; k < W.start()[static_cast<std::size_t>(i) + 1]; ++k)
      entries.push_back(std::minmax(i, W.columns()[static_cast<std::size_t>(k)]));
  }
  for_pairs_of_rows([&](const Incidence& a, const Incidence& b) { entries.push_back(std::minmax(a.point, b.point)); });

  const SymbolicAnalysis order = analyze(make_triangle(n, entries), ordering);
  // Blocks of 3 x 3: each operation on a point is 27 on numbers, and each entry 9.
  is_supernodal_ = 3.0 * order.flops > plan::flops_for_fronts * order.factor_nonzeros;
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

  stiffness_slots_.assign(W.columns().size(), -1);
  for (int i = 0; i < static_cast<int>(n); ++i) {
    for (int k = W.start()[static_cast<std::size_t>(i)]; k < W.start()[static_cast<std::size_t>(i) + 1]; ++k)
      stiffness_slots_[static_cast<std::size_t>(k)] = slot(i, W.columns()[static_cast<std::size_t>(k)]);
  }
  for_pairs_of_rows([&](const Incidence& a, const Incidence& b) {
    if (const int at = slot(a.point, b.point); at >= 0)
      products_.push_back({a.row, a.block, b.block, a.sign * b.sign, at});
  });

  // Column c of point j: 3 rows of each block above the diagonal, then the rows up to c of the diagonal's.
  for (std::size_t j = 0; j < n; ++j) {
    for (int c = 0; c < 3; ++c) {
      for (int k = start_[j]; k < start_[j + 1]; ++k) {
        const int first = 3 * rows_[static_cast<std::size_t>(k)], count = k + 1 < start_[j + 1] ? 3 : c + 1;
        for (int row = 0; row < count; ++row) upper_.rows.push_back(first + row);
      }
      upper_.start.push_back(static_cast<int>(upper_.rows.size()));
    }
  }
  values_.resize(upper_.rows.size());
  TrianglePattern pattern = upper_;
  if (is_supernodal_) {
    // The lower triangle: the transpose, by counting.
    const Groups<std::pair<int, int>> lower(upper_.size(), [&](const auto& add) {
      for (std::size_t column = 0; column < upper_.size(); ++column) {
        for (int k = upper_.start[column]; k < upper_.start[column + 1]; ++k)
          add(upper_.rows[static_cast<std::size_t>(k)], std::pair{static_cast<int>(column), k});
      }
    });
    pattern.start.assign(lower.start.begin(), lower.start.end());
    for (std::size_t k = 0; k < lower.entries.size(); ++k) {
      pattern.rows[k] = lower.entries[k].first;
      transposed_.push_back(lower.entries[k].second);
    }
  }
  factor_.emplace(std::move(pattern), is_supernodal_);
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
void KktSolver::find_penalties(double shift) {
  const StiffnessMatrix& W = equations_.stiffness();
  std::vector<double> stiffness(W.num_points());
  double most = 0.0;
  for (std::size_t i = 0; i < stiffness.size(); ++i) {
    const Block3& own = blocks_[static_cast<std::size_t>(start_[static_cast<std::size_t>(place_[i]) + 1] - 1)];
    for (const double entry : own.entries) stiffness[i] = std::max(stiffness[i], std::abs(entry));
    most = std::max(most, stiffness[i]);
  }
  const double least = most > 0.0 ? 1e-6 * most : std::max(std::abs(shift), 1.0);
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
    penalties_[row] = squares[row] > 0.0 ? penalty * penalties_[row] / squares[row] : 0.0;
}

void KktSolver::assemble(double shift) {
  const StiffnessMatrix& W = equations_.stiffness();
  const double* const K = equations_.gradients().data();
  std::fill(blocks_.begin(), blocks_.end(), Block3{});
  for (std::size_t k = 0; k < stiffness_slots_.size(); ++k) {
    if (stiffness_slots_[k] >= 0) blocks_[static_cast<std::size_t>(stiffness_slots_[k])] = W.blocks()[k];
  }
  for (std::size_t i = 0; i < place_.size(); ++i)
    blocks_[static_cast<std::size_t>(start_[static_cast<std::size_t>(place_[i]) + 1] - 1)].add_identity(shift *
                                                                                                        model_.mass[i]);
  find_penalties(shift);
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
  shift_ = shift;
  assemble(shift);
  double* const values = factor_->values();
  if (is_supernodal_) {
    for (std::size_t k = 0; k < transposed_.size(); ++k) values[k] = values_[static_cast<std::size_t>(transposed_[k])];
  } else {
    std::copy(values_.begin(), values_.end(), values);
  }
  const Cholesky::Quality quality = factor_->factorize(model_.parallel.threads());
  reciprocal_condition_ = quality.positive_definite ? quality.reciprocal_condition : 0.0;
  return quality.positive_definite;
}

std::optional<std::size_t> KktSolver::count_below(double omega2) {
  const std::vector<double> of_factor = penalties_;  // which solve() goes on with
  assemble(-omega2);
  penalties_ = of_factor;
  return count_negative_eigenvalues(upper_, values_);
}

/// to = A^-1 from
void KktSolver::apply_inverse(const double* from, double* to) {
  for (std::size_t i = 0; i < place_.size(); ++i) store(ordered_.data(), place_[i], load(from, i));
  factor_->solve(ordered_.data(), model_.parallel.threads());
  for (std::size_t i = 0; i < place_.size(); ++i) store(to, i, load(ordered_.data(), place_[i]));
}

/// One round: x = A^-1(a + K(Cb - y)) with y by conjugate gradients, which C preconditions.
void KktSolver::solve_shifted(double* x, double* y) {
  const std::size_t rows = rows_residual_.size();
  // x = A^-1 (a + K C b), residual = K'x - b
  for (std::size_t k = 0; k < rows; ++k) scaled_[k] = penalties_[k] * y[k];
  std::copy_n(x, force_.size(), force_.begin());
  equations_.add_reactions(scaled_.data(), force_.data());
  apply_inverse(force_.data(), x);
  equations_.apply_transposed(x, rows_residual_.data());
  for (std::size_t k = 0; k < rows; ++k) rows_residual_[k] = penalties_[k] > 0.0 ? rows_residual_[k] - y[k] : 0.0;
  std::fill_n(y, rows, 0.0);

  constexpr int most_steps = 12;
  constexpr double enough = 1e-24;  // of squares
  double before = 0.0, first = 0.0;
  for (int step = 0; step < most_steps; ++step) {
    for (std::size_t k = 0; k < rows; ++k) scaled_[k] = penalties_[k] * rows_residual_[k];
    const double now = dot(scaled_, rows_residual_);
    if (step == 0) first = now;
    if (!(now > enough * first) || (step > 0 && now > before)) break;
    for (std::size_t k = 0; k < rows; ++k) direction_[k] = scaled_[k] + (step > 0 ? now / before * direction_[k] : 0.0);
    before = now;
    std::fill(force_.begin(), force_.end(), 0.0);
    equations_.add_reactions(direction_.data(), force_.data());
    apply_inverse(force_.data(), move_.data());
    equations_.apply_transposed(move_.data(), image_.data());
    const double curvature = dot(direction_, image_);
    if (!(curvature > 0.0)) break;
    const double length = now / curvature;
    for (std::size_t k = 0; k < rows; ++k) {
      y[k] += length * direction_[k];
      rows_residual_[k] -= length * image_[k];
    }
    for (std::size_t i = 0; i < move_.size(); ++i) x[i] -= length * move_[i];
  }
}

double KktSolver::solve(double* x, double* y, int refinements) {
  std::copy_n(x, given_.size(), given_.begin());
  std::copy_n(y, rows_given_.size(), rows_given_.begin());
  std::vector<double>&dx = residual_, &dy = rows_step_;
  dx = given_;
  dy = rows_given_;
  std::fill_n(x, given_.size(), 0.0);
  std::fill_n(y, rows_given_.size(), 0.0);
  double residual = 1.0, rows_before = largest(rows_given_);
  for (int round = 0; round < refinements; ++round) {
    solve_shifted(dx.data(), dy.data());
    for (std::size_t i = 0; i < dx.size(); ++i) x[i] += dx[i];
    for (std::size_t k = 0; k < dy.size(); ++k) y[k] += dy[k];
    // a - (W + s M) x - K y, and b - K'x
    equations_.stiffness().multiply(x, product_.data());
    double scale = std::max(largest(given_), largest(product_));
    for (std::size_t i = 0; i < dx.size(); ++i) dx[i] = given_[i] - product_[i] - shift_ * model_.mass[i / 3] * x[i];
    for (std::size_t k = 0; k < dy.size(); ++k) scaled_[k] = -y[k];
    equations_.add_reactions(scaled_.data(), dx.data());
    equations_.apply_transposed(x, dy.data());
    for (std::size_t k = 0; k < dy.size(); ++k) dy[k] = penalties_[k] > 0.0 ? rows_given_[k] - dy[k] : 0.0;
    const double now = scale > 0.0 ? largest(dx) / scale : 0.0, rows_now = largest(dy);
    const bool is_better = now < 0.5 * residual || rows_now < 0.5 * rows_before;
    residual = now;
    rows_before = rows_now;
    const double rows_given = largest(rows_given_);
    row_residual_ = rows_given > 0.0 ? rows_now / rows_given : 0.0;
    if ((now < 1e-15 && rows_now < 1e-15 * largest(rows_given_)) || !is_better) break;
  }
  return residual;
}

}  // namespace tanor
