#include "statics/unsymmetric_kkt.hpp"

#include <algorithm>

namespace tanor::detail {

UnsymmetricKkt::UnsymmetricKkt(const EquilibriumEquations& equations)
    : equations_(equations), model_(equations.model()) {
  make_pattern();
}

void UnsymmetricKkt::make_pattern() {
  const StiffnessMatrix& W = equations_.stiffness();
  pattern_version_ = W.pattern_version();
  pattern_ = {};
  stiffness_slots_.clear();
  gradient_slots_.clear();
  const std::size_t n = equations_.size(), rows = equations_.num_rows();
  std::vector<std::vector<int>> columns(n + rows);
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(W.columns()[static_cast<std::size_t>(k)]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        columns[3 * j + entry % 3].push_back(static_cast<int>(3 * i + entry / 3));
    }
  }
  const auto takes_part = [&](const Incidence& incidence) {
    return static_cast<std::size_t>(incidence.row) < rows && 3 * static_cast<std::size_t>(incidence.point) < n;
  };
  for (const Incidence& incidence : model_.incidences) {
    if (!takes_part(incidence)) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t point = 3 * static_cast<std::size_t>(incidence.point) + c;
      const std::size_t row = n + static_cast<std::size_t>(incidence.row);
      columns[row].push_back(static_cast<int>(point));
      columns[point].push_back(static_cast<int>(row));
    }
  }
  for (std::size_t row = n; row < n + rows; ++row) columns[row].push_back(static_cast<int>(row));
  for (std::vector<int>& column : columns) {
    std::sort(column.begin(), column.end());
    column.erase(std::unique(column.begin(), column.end()), column.end());
    pattern_.rows.insert(pattern_.rows.end(), column.begin(), column.end());
    pattern_.start.push_back(static_cast<int>(pattern_.rows.size()));
  }
  for (std::size_t i = 0; i < W.num_points(); ++i) {
    for (int k = W.start()[i]; k < W.start()[i + 1]; ++k) {
      const auto j = static_cast<std::size_t>(W.columns()[static_cast<std::size_t>(k)]);
      for (std::size_t entry = 0; entry < 9; ++entry)
        stiffness_slots_.push_back(slot(3 * i + entry / 3, 3 * j + entry % 3));
    }
  }
  for (const Incidence& incidence : model_.incidences) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t point = 3 * static_cast<std::size_t>(incidence.point) + c;
      const std::size_t row = n + static_cast<std::size_t>(incidence.row);
      gradient_slots_.push_back(takes_part(incidence) ? std::array{slot(point, row), slot(row, point)}
                                                      : std::array{-1, -1});
    }
  }
  factor_ = std::make_unique<SparseLu<double>>(pattern_);
}

int UnsymmetricKkt::slot(std::size_t row, std::size_t column) const {
  const auto begin = pattern_.rows.begin() + pattern_.start[column];
  const auto end = pattern_.rows.begin() + pattern_.start[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, static_cast<int>(row)) - pattern_.rows.begin());
}

void UnsymmetricKkt::assemble() {
  constexpr double compliance = 1e-14;  // relative to the inverse of the largest stiffness
  const StiffnessMatrix& W = equations_.stiffness();
  if (pattern_version_ != W.pattern_version()) make_pattern();
  const std::size_t n = equations_.size();
  double* const values = factor_->values();
  std::fill_n(values, pattern_.rows.size(), 0.0);
  for (std::size_t k = 0; k < stiffness_slots_.size(); ++k)
    values[stiffness_slots_[k]] += W.blocks()[k / 9].entries[k % 9];
  for (std::size_t i = 0; i < n; ++i) values[slot(i, i)] += shift_ * model_.mass[i / 3];
  if (damped_.damping != nullptr) {
    for (Eigen::Index j = 0; j < damped_.damping->outerSize(); ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator entry(*damped_.damping, j); entry; ++entry)
        values[slot(static_cast<std::size_t>(entry.row()), static_cast<std::size_t>(j))] +=
            damped_.rate * entry.value();
    }
  }
  for (std::size_t k = 0; k < gradient_slots_.size(); ++k) {
    const auto [of_k, transposed] = gradient_slots_[k];
    if (of_k < 0) continue;
    const Incidence& incidence = model_.incidences[k / 3];
    const double g = incidence.sign * equations_.gradients()[3 * static_cast<std::size_t>(incidence.block) + k % 3];
    values[of_k] += g;
    values[transposed] += g;
  }
  const double stiffness = std::max(W.largest(), 1e-300);
  for (std::size_t row = n; row < pattern_.size(); ++row) values[slot(row, row)] = -compliance / stiffness;
}

bool UnsymmetricKkt::factorize(double shift, const Damped& damped) {
  shift_ = shift;
  damped_ = damped;
  assemble();
  return factor_->factorize();
}

void UnsymmetricKkt::multiply(const std::vector<double>& x, std::vector<double>* y) const {
  y->resize(x.size());
  equations_.stiffness().multiply(x.data(), y->data());
  for (std::size_t i = 0; i < x.size(); ++i) (*y)[i] += shift_ * model_.mass[i / 3] * x[i];
  if (damped_.damping == nullptr) return;
  const auto size = static_cast<Eigen::Index>(x.size());
  Eigen::Map<Eigen::VectorXd>(y->data(), size) +=
      damped_.rate * (*damped_.damping * Eigen::Map<const Eigen::VectorXd>(x.data(), size));
}

void UnsymmetricKkt::solve(std::vector<double>* x, std::vector<double>* mu) {
  constexpr int rounds = 3;
  const std::size_t n = equations_.size(), rows = equations_.num_rows();
  const std::vector<double> b = *x, c = *mu;
  std::fill(x->begin(), x->end(), 0.0);
  std::fill(mu->begin(), mu->end(), 0.0);
  std::vector<double> image, residual(n + rows), reactions(model_.num_rows()), of_rows(model_.num_rows());
  for (int round = 0; round < rounds; ++round) {
    multiply(*x, &image);
    for (std::size_t i = 0; i < n; ++i) residual[i] = b[i] - image[i];
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
