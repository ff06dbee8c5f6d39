#include "factor/partial_cholesky.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "factor/supernodes.hpp"

namespace tanor::detail {

namespace {

/// Makes one supernode of the last rows. A supernode that holds columns on both sides is cut, since its rows are those
/// of its first columns anyway.
Supernodes keep_last_rows(Supernodes all, std::size_t num_kept) {
  if (num_kept == 0) return all;
  const int n = all.first_column.back(), first_kept = n - static_cast<int>(num_kept);
  const auto cut = std::ranges::lower_bound(all.first_column, first_kept);
  const auto last = static_cast<std::size_t>(cut - all.first_column.begin());
  all.first_column.resize(last);
  all.first_column.insert(all.first_column.end(), {first_kept, n});
  all.rows_start.resize(last + 1);
  all.rows.resize(all.rows_start.back() + num_kept);
  std::iota(all.rows.end() - static_cast<std::ptrdiff_t>(num_kept), all.rows.end(), first_kept);
  all.rows_start.push_back(all.rows.size());
  all.parent.resize(last + 1);
  all.parent.back() = -1;
  for (std::size_t s = 0; s < last; ++s) {
    const std::span<const int> below = all.rows_below(s);
    if (!below.empty() && below.front() >= first_kept) all.parent[s] = static_cast<int>(last);
  }
  return all;
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
  return Cholesky::quality_of(std::span(fronts_.pivots()).first(num_eliminated()));
}

void PartialCholesky::write_complement(double* packed) const {
  for (std::size_t j = 0; j < num_kept_; ++j) packed = std::copy_n(fronts_.kept_column(j), num_kept_ - j, packed);
}

}  // namespace tanor::detail
