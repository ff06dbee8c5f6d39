#include "schur/multiplier_history.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

MultiplierHistory::MultiplierHistory(std::size_t num_rows) {
  for (Solution& solution : solutions_) solution = {0.0, std::vector<double>(num_rows, 0.0)};
}

void MultiplierHistory::add(double t, const std::vector<double>& lambda) {
  // A solution at the same time is replaced.
  const auto end = solutions_.begin() + static_cast<std::ptrdiff_t>(size_);
  auto place = std::find_if(solutions_.begin(), end, [&](const Solution& each) { return each.t == t; });
  if (place == end) {
    size_ = std::min(most, size_ + 1);
    place = solutions_.begin() + static_cast<std::ptrdiff_t>(size_ - 1);
  }
  std::rotate(solutions_.begin(), place, place + 1);
  solutions_.front().t = t;
  std::copy(lambda.begin(), lambda.end(), solutions_.front().lambda.begin());
}

/// Computes lambda(t) = sum_j lambda_j prod_(k != j) (t - t_k)/(t_j - t_k) from as many solutions as do not magnify
/// their errors too much.
void MultiplierHistory::extrapolate(const Parallel& parallel, double t, std::vector<double>* lambda) const {
  constexpr double most_magnified = 20.0;
  if (size_ == 0) return;
  std::array<double, most> weights{};
  double magnified = HUGE_VAL;
  for (std::size_t count = size_; magnified > most_magnified; --count) {
    magnified = 0.0;
    weights = {};
    for (std::size_t j = 0; j < count; ++j) {
      weights[j] = 1.0;
      for (std::size_t k = 0; k < count; ++k) {
        if (k != j) weights[j] *= (t - solutions_[k].t) / (solutions_[j].t - solutions_[k].t);
      }
      magnified += std::abs(weights[j]);
    }
  }
  const double *const a = solutions_[0].lambda.data(), *const b = solutions_[1].lambda.data(),
                      *const c = solutions_[2].lambda.data();
  parallel.for_ranges(lambda->size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) (*lambda)[i] = weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i];
  });
}

void MultiplierHistory::exchange_memory(Memory& memory) {
  memory.exchange(size_);
  for (Solution& solution : solutions_) memory.exchange(solution.t, solution.lambda);
  if (size_ > most) memory.refuse();
  // Two solutions at one time would divide by 0.
  for (std::size_t k = 1; k < std::min(size_, most); ++k) {
    for (std::size_t j = 0; j < k; ++j) {
      if (solutions_[j].t == solutions_[k].t) memory.refuse();
    }
  }
}

}  // namespace tanor::detail
