#include "factor/cholesky.hpp"
#include "ranks/cut_factor.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

namespace {

TrianglePattern dense_pattern(std::size_t num_rows) {
  TrianglePattern pattern;
  for (std::size_t j = 0; j < num_rows; ++j) {
    for (std::size_t i = j; i < num_rows; ++i) pattern.rows.push_back(static_cast<int>(i));
    pattern.start.push_back(static_cast<int>(pattern.rows.size()));
  }
  return pattern;
}

class ReplicatedRows final : public SharedRows {
 public:
  ReplicatedRows(Ranks& ranks, std::size_t num_rows, std::span<const std::size_t> own, int threads)
      : ranks_(ranks),
        own_(own.begin(), own.end()),
        threads_(threads),
        factor_(dense_pattern(num_rows), true),
        scale_(num_rows),
        x_(num_rows) {}

  double factorize(std::span<const double> triangle) override {
    const std::size_t n = x_.size();
    if (n == 0) return 1.0;
    const std::span<double> sum(factor_.values(), n * (n + 1) / 2);
    std::ranges::fill(sum, 0.0);
    auto next = triangle.begin();
    for (std::size_t j = 0; j < own_.size(); ++j)
      for (std::size_t i = j; i < own_.size(); ++i) sum[entry(own_[i], own_[j])] = *next++;
    ranks_.sum(sum);
    double least = 1.0;
    for (std::size_t j = 0; j < n; ++j) {
      const double diagonal = sum[entry(j, j)];
      least = std::min(least, diagonal);
      if (!(diagonal > 0.0 && std::isfinite(diagonal))) return 0.0;
      scale_[j] = 1.0 / std::sqrt(diagonal);
    }
    double* value = sum.data();
    for (std::size_t j = 0; j < n; ++j)
      for (std::size_t i = j; i < n; ++i) *value++ *= scale_[i] * scale_[j];
    const Cholesky::Quality quality = factor_.factorize(threads_);
    return quality.positive_definite ? std::min(quality.reciprocal_condition, least) : 0.0;
  }

  void solve(std::span<double> x) override {
    if (x_.empty()) return;
    std::ranges::fill(x_, 0.0);
    for (std::size_t k = 0; k < own_.size(); ++k) x_[own_[k]] = x[k];
    ranks_.sum(x_);
    for (std::size_t k = 0; k < x_.size(); ++k) x_[k] *= scale_[k];
    factor_.solve(x_.data(), threads_);
    for (std::size_t k = 0; k < own_.size(); ++k) x[k] = scale_[own_[k]] * x_[own_[k]];
  }

 private:
  /// Returns the place of entry (i, j), i >= j, in the lower triangle of all rows.
  std::size_t entry(std::size_t i, std::size_t j) const { return j * (2 * x_.size() - j + 1) / 2 + i - j; }

  Ranks& ranks_;
  std::vector<std::size_t> own_;
  int threads_;
  Cholesky factor_;  // factor of one dense front
  std::vector<double> scale_, x_;
};

}  // namespace

std::unique_ptr<SharedRows> make_replicated_rows(Ranks& ranks, std::size_t num_rows, std::span<const std::size_t> own,
                                                 int threads) {
  return std::make_unique<ReplicatedRows>(ranks, num_rows, own, threads);
}

}  // namespace tanor::detail
