#include "statics/unsymmetric_kkt.hpp"

#include <algorithm>
#include <utility>

#include "base/groups.hpp"

namespace tanor::detail {

/// Calls visit(row, column, value) for all terms of the entries, in an order that depends on the pattern alone.
template <class Visit>
void UnsymmetricKkt::for_each_term(const Visit& visit) const {
  constexpr double compliance = 1e-14;  // relative to the inverse of the largest stiffness
  const StiffnessMatrix& W = equations_.stiffness();
  const std::size_t n = equations_.size(), rows = equations_.num_rows();
  W.for_each_block([&](std::size_t i, std::size_t j, std::size_t k) {
    for (std::size_t entry = 0; entry < 9; ++entry)
      visit(3 * i + entry / 3, 3 * j + entry % 3, W.blocks()[k].entries[entry]);
  });
  for (std::size_t i = 0; i < n; ++i) visit(i, i, shift_ * model_.mass[i / 3]);
  for (Eigen::Index j = 0; damped_.damping != nullptr && j < damped_.damping->outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(*damped_.damping, j); entry; ++entry)
      visit(static_cast<std::size_t>(entry.row()), static_cast<std::size_t>(j), damped_.rate * entry.value());
  }
  for (const Incidence& incidence : model_.incidences) {
    const std::size_t row = n + static_cast<std::size_t>(incidence.row),
                      first = 3 * static_cast<std::size_t>(incidence.point);
    if (row >= n + rows || first >= n) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double g = incidence.sign * equations_.gradients()[3 * static_cast<std::size_t>(incidence.block) + c];
      visit(first + c, row, g);
      visit(row, first + c, g);
    }
  }
  const double stiffness = std::max(W.largest(), 1e-300);
  for (std::size_t row = n; row < n + rows; ++row) visit(row, row, -compliance / stiffness);
}

void UnsymmetricKkt::make_pattern() {
  pattern_version_ = equations_.stiffness().pattern_version();
  std::vector<std::pair<int, int>> entries;
  for_each_term([&](std::size_t row, std::size_t column, double) {
    entries.push_back({static_cast<int>(column), static_cast<int>(row)});
  });
  SquarePattern pattern;
  compress_pairs(equations_.size() + equations_.num_rows(), entries, &pattern.start, &pattern.rows);
  slots_.clear();
  for (const auto& [column, row] : entries) slots_.push_back(find_slot(pattern.start, pattern.rows, column, row));
  factor_ = std::make_unique<SparseLu<double>>(std::move(pattern));
}

bool UnsymmetricKkt::factorize(double shift, const Damped& damped) {
  const bool is_known = factor_ != nullptr && damped.damping == damped_.damping &&
                        pattern_version_ == equations_.stiffness().pattern_version();
  shift_ = shift;
  damped_ = damped;
  if (!is_known) make_pattern();
  double* const values = factor_->values();
  std::fill_n(values, factor_->pattern().rows.size(), 0.0);
  const int* slot = slots_.data();
  for_each_term([&](std::size_t, std::size_t, double value) { values[*slot++] += value; });
  return factor_->factorize();
}

void UnsymmetricKkt::solve(std::vector<double>* x, std::vector<double>* mu) {
  constexpr int rounds = 3;
  const std::size_t n = equations_.size(), rows = equations_.num_rows();
  const auto as_eigen = [n](double* y) { return Eigen::Map<Eigen::VectorXd>(y, static_cast<Eigen::Index>(n)); };
  const std::vector<double> b = *x, c = *mu;
  std::fill(x->begin(), x->end(), 0.0);
  std::fill(mu->begin(), mu->end(), 0.0);
  std::vector<double> image(n), residual(n + rows), reactions(model_.num_rows()), of_rows(model_.num_rows());
  for (int round = 0; round < rounds; ++round) {
    equations_.stiffness().multiply(x->data(), image.data());
    for (std::size_t i = 0; i < n; ++i) residual[i] = b[i] - image[i] - shift_ * model_.mass[i / 3] * (*x)[i];
    if (damped_.damping != nullptr)
      as_eigen(residual.data()) -= damped_.rate * (*damped_.damping * as_eigen(x->data()));
    for (std::size_t a = 0; a < rows; ++a) reactions[a] = -(*mu)[a];
    equations_.add_reactions(reactions.data(), residual.data());
    equations_.apply_transposed(x->data(), of_rows.data());
    for (std::size_t a = 0; a < rows; ++a) residual[n + a] = c[a] - of_rows[a];
    factor_->solve(residual.data());
    for (std::size_t i = 0; i < n; ++i) (*x)[i] += residual[i];
    for (std::size_t a = 0; a < rows; ++a) (*mu)[a] += residual[n + a];
  }
}

}  // namespace tanor::detail
