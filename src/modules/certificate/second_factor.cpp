#include "certificate/second_factor.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/numbers.hpp"
#include "base/power_iteration.hpp"
#include "factor/dependent_columns.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t most_rows_of_qr = 200000;  // limit for systems with fill, by the memory of R

using Sparse = Eigen::SparseMatrix<double>;

TrianglePattern pattern_of(const Sparse& A) {
  const int *const start = A.outerIndexPtr(), *const rows = A.innerIndexPtr();
  return {{start, start + A.cols() + 1}, {rows, rows + A.nonZeros()}};
}

}  // namespace

SecondFactor::SecondFactor(const Model& model, const double* blocks, std::span<const double> weights,
                           std::span<const Ordering> first_orderings, SecondFactorization by) {
  const SparseColumns C = scaled_columns(model, blocks, weights);
  const std::size_t d = C.num_columns();
  const bool makes_no_fill = first_orderings.size() == 1 && first_orderings[0] == Ordering::Natural;
  is_qr_ =
      by == SecondFactorization::Qr || (by == SecondFactorization::Auto && (makes_no_fill || d <= most_rows_of_qr));
  if (is_qr_) {
    const double tolerance = 20.0 * static_cast<double>(d + 3 * model.num_points()) * eps;
    R_ = makes_no_fill ? merge_rows(C, tolerance) : find_independent_columns(C, tolerance).factor;
    if (R_.independent.size() < C.num_columns()) keep_apart(model, blocks, weights, C);
    row_of_ = R_.independent;
  } else {
    factorize(C, std::ranges::count(first_orderings, Ordering::Metis) > 0 ? Ordering::Nesdis : Ordering::Metis);
  }
  for (int& row : row_of_) row = row_of_column_[static_cast<std::size_t>(row)];
  packed_.resize(row_of_.size());
}

/// Takes those columns as independent that K itself keeps apart, where weights alone bring them together: two rods at a
/// point of next to no mass are parallel in W^1/2 K to the last digit.
void SecondFactor::keep_apart(const Model& model, const double* blocks, std::span<const double> weights,
                              const SparseColumns& C) {
  constexpr double unequal = 1e6;
  std::vector<double> equal(weights.begin(), weights.end());
  double least = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (double& weight : equal) {
    if (weight == 0.0) continue;
    least = std::min(least, weight);
    largest = std::max(largest, weight);
    weight = 1.0;
  }
  if (!(largest > unequal * least)) return;
  const SecondFactor of_K(model, blocks, equal, std::array{Ordering::Auto}, SecondFactorization::Qr);
  if (of_K.row_of_.size() <= R_.independent.size()) return;
  std::vector<int> apart = of_K.row_of_, left_out;
  std::ranges::sort(apart);
  for (std::size_t column = 0; column < C.num_columns(); ++column)
    if (!std::ranges::binary_search(apart, row_of_column_[column])) left_out.push_back(static_cast<int>(column));
  R_ = factorize_without(left_out, C, -1.0, factorize_qr);
}

/// Factorizes C'C in its own ordering.
void SecondFactor::factorize(const SparseColumns& columns, Ordering ordering) {
  const auto d = static_cast<Eigen::Index>(columns.num_columns());
  const Eigen::Map<const Sparse> C(columns.num_rows, d, static_cast<Eigen::Index>(columns.values.size()),
                                   columns.start.data(), columns.rows.data(), columns.values.data());
  const Sparse product = C.transpose() * C, lower = product.triangularView<Eigen::Lower>();
  const SymbolicAnalysis analysis = analyze(pattern_of(lower), ordering);
  row_of_ = analysis.permutation;
  if (row_of_.empty()) {
    row_of_.resize(columns.num_columns());
    std::iota(row_of_.begin(), row_of_.end(), 0);
  }
  const Eigen::PermutationMatrix<Eigen::Dynamic> order(Eigen::Map<const Eigen::VectorXi>(row_of_.data(), d)),
      place(order.transpose());
  Sparse turned, half;
  turned = product.twistedBy(place);
  const Sparse ordered = turned.transpose();  // sorts each column
  if (analysis.supernodal)
    half = ordered.triangularView<Eigen::Lower>();
  else
    half = ordered.triangularView<Eigen::Upper>();
  L_.emplace(pattern_of(half), analysis.supernodal);
  std::copy_n(half.valuePtr(), half.nonZeros(), L_->values());
  if (!L_->factorize().positive_definite) trouble_ = "K'K is singular to rounding, and too large for a QR";
}

/// Returns the columns of W^1/2 K, scaled to unit length, of the rows that take part. Contact rows without a gradient
/// have none.
SparseColumns SecondFactor::scaled_columns(const Model& model, const double* blocks, std::span<const double> weights) {
  const std::size_t d = model.numbering.first_idle_row();
  SparseColumns C = collect_columns(d, [&](const auto& add) {
    for (const Incidence& i : model.incidences) {
      const double weight = weights[static_cast<std::size_t>(i.point)];
      if (weight != 0.0) add(i.row, PointEntry{i.point, (i.sign * std::sqrt(weight)) * load(blocks, i.block)});
    }
  });
  C.num_rows = 3 * static_cast<int>(model.num_moving());
  for (std::size_t row = 0; row < d; ++row) {
    bool has_gradient = !model.numbering.is_contact_row(row);
    for_each_entry(C, static_cast<int>(row), [&](int, double value) { has_gradient = has_gradient || value != 0.0; });
    if (has_gradient) row_of_column_.push_back(static_cast<int>(row));
  }
  if (row_of_column_.size() < d) C = columns_of(C, row_of_column_);
  lengths_.assign(model.num_rows(), 1.0);
  const std::vector<double> lengths = normalize_columns(&C);
  std::vector<double> row_sums(static_cast<std::size_t>(C.num_rows), 0.0);
  for (std::size_t column = 0; column < lengths.size(); ++column) {
    lengths_[static_cast<std::size_t>(row_of_column_[column])] = lengths[column];
    double column_sum = 0.0;
    for_each_entry(C, static_cast<int>(column), [&](int row, double value) {
      row_sums[static_cast<std::size_t>(row)] += std::abs(value);
      column_sum += std::abs(value);
    });
    largest_column_sum_ = std::max(largest_column_sum_, column_sum);
  }
  // |C'C|_1 <= |C|_1 |C|_oo
  if (!row_sums.empty()) largest_column_sum_ *= *std::ranges::max_element(row_sums);
  return C;
}

void SecondFactor::solve() {
  if (!is_qr_) return L_->solve(packed_.data());
  R_.solve_transposed(packed_.data());
  R_.solve(packed_.data());
}

void SecondFactor::solve_negative(double* rows) {
  for (std::size_t k = 0; k < packed_.size(); ++k) {
    const auto row = static_cast<std::size_t>(row_of_[k]);
    packed_[k] = -rows[row] / lengths_[row];
  }
  solve();
  std::fill_n(rows, lengths_.size(), 0.0);
  for (std::size_t k = 0; k < packed_.size(); ++k) {
    const auto row = static_cast<std::size_t>(row_of_[k]);
    rows[row] = packed_[k] / lengths_[row];
  }
}

double SecondFactor::estimate_reciprocal_condition() {
  constexpr int iterations = 3;
  const double inverse = estimate_norm(&packed_, iterations, [&] { solve(); });
  return inverse > 0.0 ? 1.0 / (largest_column_sum_ * inverse) : 1.0;
}

}  // namespace tanor::detail
