#include "host/schur_determinant.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace tanor::detail {

SchurDeterminant::SchurDeterminant(const Workspace& work)
    : work_(work),
      model_(work.model()),
      by_point_(model_.num_moving(),
                [this](const auto& add) {
                  for (const Incidence& incidence : model_.incidences) {
                    if (static_cast<std::size_t>(incidence.point) < model_.num_moving())
                      add(incidence.point, Entry{incidence.row, incidence.block, incidence.sign});
                  }
                }),
      diagonal_(model_.numbering.first_idle_row()),
      inverse_diagonal_(diagonal_.size()) {
  plan_pattern();
  lower_.resize(pattern_.entries.size());
  inverse_lower_.resize(lower_.size());
}

/// Column j of L has the rows of S below it, and the rows of the columns whose first row below the diagonal is j.
void SchurDeterminant::plan_pattern() {
  std::vector<std::set<Index>> rows(diagonal_.size());
  for (std::size_t i = 0; i < by_point_.size(); ++i) {
    for (const Entry& a : by_point_[i]) {
      for (const Entry& b : by_point_[i]) {
        if (b.row > a.row) rows[static_cast<std::size_t>(a.row)].insert(b.row);
      }
    }
  }
  for (std::set<Index>& own : rows) {
    for (const Index row : own) pattern_.entries.push_back(row);
    pattern_.end_group();
    if (own.empty()) continue;
    std::set<Index>& parent = rows[static_cast<std::size_t>(*own.begin())];
    parent.insert(std::next(own.begin()), own.end());
    own.clear();
  }
}

/// Returns the number of the entry at (row, column).
std::size_t SchurDeterminant::place(std::size_t column, Index row) const {
  const std::span<const Index> rows = below(column);
  const auto found = std::lower_bound(rows.begin(), rows.end(), row);
  return static_cast<std::size_t>(pattern_.start[column]) + static_cast<std::size_t>(found - rows.begin());
}

/// Assembles S_ab = sum over the points of K_a'K_b/m.
void SchurDeterminant::assemble(const double* blocks) {
  std::fill(lower_.begin(), lower_.end(), 0.0);
  std::fill(diagonal_.begin(), diagonal_.end(), 0.0);
  for (std::size_t i = 0; i < by_point_.size(); ++i) {
    for (const Entry& a : by_point_[i]) {
      for (const Entry& b : by_point_[i]) {
        if (b.row < a.row) continue;
        const double product =
            model_.inverse_mass[i] * a.sign * b.sign * dot(load(blocks, a.block), load(blocks, b.block));
        const auto column = static_cast<std::size_t>(a.row);
        (a.row == b.row ? diagonal_[column] : lower_[place(column, b.row)]) += product;
      }
    }
  }
}

double SchurDeterminant::evaluate(const double* blocks) {
  constexpr double rounding = 1e-13;
  assemble(blocks);
  const std::vector<double> of_s = diagonal_;
  double result = 0.0;
  // The elimination is right-looking: the outer product of column j is subtracted from the columns behind it.
  for (std::size_t j = 0; j < diagonal_.size(); ++j) {
    if (!(diagonal_[j] > rounding * of_s[j])) {
      dependent_row_ = j;
      return -std::numeric_limits<double>::infinity();
    }
    result += std::log(diagonal_[j]);
    const auto first = static_cast<std::size_t>(pattern_.start[j]);
    const std::span<const Index> rows = below(j);
    for (std::size_t p = 0; p < rows.size(); ++p) {
      const double factor = lower_[first + p] / diagonal_[j];
      const auto column = static_cast<std::size_t>(rows[p]);
      diagonal_[column] -= factor * lower_[first + p];
      for (std::size_t q = p + 1; q < rows.size(); ++q) lower_[place(column, rows[q])] -= factor * lower_[first + q];
    }
    for (std::size_t p = 0; p < rows.size(); ++p) lower_[first + p] /= diagonal_[j];
  }
  return result;
}

/// Computes Z from the last column on: Z_ij = -sum over k of L_kj Z_ik, Z_jj = 1/D_j - sum over k of L_kj Z_kj.
void SchurDeterminant::invert() {
  for (std::size_t j = diagonal_.size(); j-- > 0;) {
    const auto first = static_cast<std::size_t>(pattern_.start[j]);
    const std::span<const Index> rows = below(j);
    double sum = 1.0 / diagonal_[j];
    for (std::size_t p = rows.size(); p-- > 0;) {
      double z = 0.0;
      for (std::size_t q = 0; q < rows.size(); ++q) {
        const auto [low, high] = std::minmax(rows[p], rows[q]);
        const auto column = static_cast<std::size_t>(low);
        z -= lower_[first + q] * (low == high ? inverse_diagonal_[column] : inverse_lower_[place(column, high)]);
      }
      inverse_lower_[first + p] = z;
      sum -= lower_[first + p] * z;
    }
    inverse_diagonal_[j] = sum;
  }
}

/// With y_a = M^-1 K Z_a, the gradient is the sum of 2 Hess(xi_a) y_a over all rows.
const std::vector<double>& SchurDeterminant::find_gradient(const double* r, const double* blocks) {
  invert();
  const auto entry = [&](Index a, Index b) {
    const auto [low, high] = std::minmax(a, b);
    const auto column = static_cast<std::size_t>(low);
    return low == high ? inverse_diagonal_[column] : inverse_lower_[place(column, high)];
  };
  std::vector<double> moves(3 * work_.constraints.num_blocks(), 0.0);
  for (std::size_t i = 0; i < by_point_.size(); ++i) {
    for (const Entry& a : by_point_[i]) {
      for (const Entry& b : by_point_[i]) {
        const double factor = 2.0 * a.sign * b.sign * model_.inverse_mass[i] * entry(a.row, b.row);
        add_to(moves.data(), a.block, factor * load(blocks, b.block));
      }
    }
  }
  gradient_.assign(3 * model_.num_points(), 0.0);
  work_.constraints.add_hessian_products(r, moves.data(), gradient_.data());
  return gradient_;
}

}  // namespace tanor::detail
