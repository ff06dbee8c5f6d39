#include "factor/partial_cholesky.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "factor/supernodes.hpp"

namespace tanor::detail {

namespace {

/// Makes one supernode of the last rows. A supernode that holds columns on both sides is cut, since its rows are those
/// of its first columns anyway.
Supernodes keep_last_rows(const Supernodes& all, std::size_t num_kept) {
  const auto n = static_cast<std::size_t>(all.first_column.back());
  const auto first_kept = static_cast<int>(n - num_kept);
  if (num_kept == 0) return all;
  Supernodes result{{}, {0}, {}};
  for (std::size_t s = 0; s < all.size() && all.first_column[s] < first_kept; ++s) {
    result.first_column.push_back(all.first_column[s]);
    result.rows.insert(result.rows.end(), all.rows.begin() + static_cast<std::ptrdiff_t>(all.rows_start[s]),
                       all.rows.begin() + static_cast<std::ptrdiff_t>(all.rows_start[s + 1]));
    result.rows_start.push_back(result.rows.size());
  }
  result.first_column.push_back(first_kept);
  result.first_column.push_back(static_cast<int>(n));
  result.rows.resize(result.rows.size() + num_kept);
  std::iota(result.rows.end() - static_cast<std::ptrdiff_t>(num_kept), result.rows.end(), first_kept);
  result.rows_start.push_back(result.rows.size());
  return result;
}

}  // namespace

std::vector<int> order_keeping(const TrianglePattern& lower, std::span<const char> is_kept, Ordering wanted) {
  std::vector<int> place(lower.size(), -1), eliminated, kept;
  for (std::size_t row = 0; row < lower.size(); ++row) {
    if (is_kept[row] == 0) place[row] = static_cast<int>(eliminated.size());
    (is_kept[row] != 0 ? kept : eliminated).push_back(static_cast<int>(row));
  }
  TrianglePattern others;
  for (const int column : eliminated) {
    const auto j = static_cast<std::size_t>(column);
    for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]); ++e) {
      if (const int row = place[static_cast<std::size_t>(lower.rows[e])]; row >= 0) others.rows.push_back(row);
    }
    others.start.push_back(static_cast<int>(others.rows.size()));
  }
  std::vector<int> result = eliminated;
  if (const std::vector<int> order = analyze(others, wanted).permutation; !order.empty()) {
    for (std::size_t k = 0; k < order.size(); ++k) result[k] = eliminated[static_cast<std::size_t>(order[k])];
  }
  result.insert(result.end(), kept.begin(), kept.end());
  return result;
}

PartialCholesky::PartialCholesky(TrianglePattern lower, std::size_t num_kept)
    : pattern_(std::move(lower)),
      num_kept_(num_kept),
      values_(pattern_.rows.size()),
      fronts_(pattern_, keep_last_rows(find_supernodes(pattern_), num_kept), num_kept) {}

Cholesky::Quality PartialCholesky::factorize(int threads) {
  const std::size_t done = fronts_.factorize(pattern_, values_.data(), threads);
  if (done < num_eliminated()) return {false, done, 0.0};
  if (num_eliminated() == 0) return {};
  const auto begin = fronts_.pivots().begin();
  const auto [weakest, strongest] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(num_eliminated()));
  const double ratio = *weakest / *strongest;
  return {true, static_cast<std::size_t>(weakest - begin), ratio * ratio};
}

void PartialCholesky::write_complement(double* packed) const {
  for (std::size_t j = 0; j < num_kept_; ++j) packed = std::copy_n(fronts_.kept_column(j), num_kept_ - j, packed);
}

}  // namespace tanor::detail
