#include "statics/unsymmetric_kkt.hpp"

#include <algorithm>

namespace tanor::detail {

Eigen::SparseMatrix<double> UnsymmetricKkt::assemble() const {
  constexpr double compliance = 1e-14;  // relative to the inverse of the largest stiffness
  const StiffnessMatrix& W = equations_.stiffness();
  const std::size_t n = equations_.size(), rows = equations_.num_rows();
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](std::size_t row, std::size_t column, double value) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
  };
  W.for_each_block([&](std::size_t i, std::size_t j, std::size_t k) {
    for (std::size_t entry = 0; entry < 9; ++entry)
      add(3 * i + entry / 3, 3 * j + entry % 3, W.blocks()[k].entries[entry]);
  });
  for (std::size_t i = 0; i < n; ++i) add(i, i, shift_ * model_.mass[i / 3]);
  for (Eigen::Index j = 0; damped_.damping != nullptr && j < damped_.damping->outerSize(); ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(*damped_.damping, j); entry; ++entry)
      add(static_cast<std::size_t>(entry.row()), static_cast<std::size_t>(j), damped_.rate * entry.value());
  }
  for (const Incidence& incidence : model_.incidences) {
    const std::size_t row = n + static_cast<std::size_t>(incidence.row),
                      first = 3 * static_cast<std::size_t>(incidence.point);
    if (row >= n + rows || first >= n) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double g = incidence.sign * equations_.gradients()[3 * static_cast<std::size_t>(incidence.block) + c];
      add(first + c, row, g);
      add(row, first + c, g);
    }
  }
  const double stiffness = std::max(W.largest(), 1e-300);
  for (std::size_t row = n; row < n + rows; ++row) add(row, row, -compliance / stiffness);
  const auto size = static_cast<Eigen::Index>(n + rows);
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());  // keeps entries that vanish
  return result;
}

bool UnsymmetricKkt::factorize(double shift, const Damped& damped) {
  shift_ = shift;
  damped_ = damped;
  const Eigen::SparseMatrix<double> A = assemble();
  const int* const start = A.outerIndexPtr();
  const int* const rows = A.innerIndexPtr();
  if (factor_ == nullptr || pattern_version_ != equations_.stiffness().pattern_version())
    factor_ =
        std::make_unique<SparseLu<double>>(SquarePattern{{start, start + A.cols() + 1}, {rows, rows + A.nonZeros()}});
  pattern_version_ = equations_.stiffness().pattern_version();
  std::copy_n(A.valuePtr(), A.nonZeros(), factor_->values());
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
