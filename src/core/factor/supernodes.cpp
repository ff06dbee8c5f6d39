#include "factor/supernodes.hpp"

#include <algorithm>
#include <utility>

#include "base/check.hpp"
#include "base/groups.hpp"
#include "factor/cholmod_common.hpp"
#include "factor/front_kernels.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

/// Returns the columns left of the diagonal, row by row.
Groups<int> columns_by_row(const TrianglePattern& lower) {
  return {lower.size(), [&](const auto& add) {
            for (std::size_t j = 0; j < lower.size(); ++j) {
              for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]);
                   ++e) {
                if (lower.rows[e] > static_cast<int>(j)) add(lower.rows[e], static_cast<int>(j));
              }
            }
          }};
}

/// The columns of L.
struct Columns {
  std::vector<int> parent;  // in the elimination tree: the first row below the diagonal, or -1
  std::vector<int> count;   // entries, with the diagonal
};

Columns analyze_columns(const TrianglePattern& lower, const Groups<int>& by_row) {
  const std::size_t n = lower.size();
  Columns columns{std::vector<int>(n), std::vector<int>(n)};
  if (n == 0) return columns;  // CHOLMOD takes no arrays without memory
  std::vector<int> postorder(n), first(n), level(n);
  const TrianglePattern upper{by_row.start, by_row.entries};
  cholmod_sparse L = cholmod_view(lower, -1), U = cholmod_view(upper, 1);
  CholmodCommon common;
  cholmod_etree(&U, columns.parent.data(), &common.c);
  cholmod_postorder(columns.parent.data(), n, nullptr, postorder.data(), &common.c);
  cholmod_rowcolcounts(&L, nullptr, 0, columns.parent.data(), postorder.data(), nullptr, columns.count.data(),
                       first.data(), level.data(), &common.c);
  common.check();
  return columns;
}

/// Consecutive columns, stored as one front.
struct Run {
  std::size_t first, columns, rows;

  /// Returns how many numbers the columns take in a front, where they have whole lanes of rows.
  std::size_t size() const {
    constexpr std::size_t width = kernels::front_width;
    return columns * ((rows + width - 1) / width * width);
  }
};

/// Returns the runs of columns whose patterns are the same below the run. The kept ones are one run.
std::vector<Run> find_equal_columns(const Columns& columns, std::size_t num_kept) {
  std::vector<Run> runs;
  const std::size_t first_kept = columns.count.size() - num_kept;
  for (std::size_t j = 0; j < first_kept; ++j) {
    const bool goes_on =
        j > 0 && columns.parent[j - 1] == static_cast<int>(j) && columns.count[j - 1] == columns.count[j] + 1;
    if (goes_on)
      ++runs.back().columns;
    else
      runs.push_back({j, 1, static_cast<std::size_t>(columns.count[j])});
  }
  if (num_kept > 0) runs.push_back({first_kept, num_kept, num_kept});
  return runs;
}

/// Merges runs with the one that follows, from the roots down, where reading the zeros that this adds takes less time
/// than a front of its own, but for the kept ones. The result is in reverse order.
std::vector<Run> merge_runs(const std::vector<Run>& runs, const std::vector<int>& parent, std::size_t num_kept) {
  std::vector<Run> merged;
  for (std::size_t s = runs.size(); s-- > 0;) {
    Run run = runs[s];
    while (!merged.empty()) {
      const Run& next = merged.back();
      const int above = parent[next.first - 1];
      if (next.first + num_kept >= parent.size() || above < 0 ||
          static_cast<std::size_t>(above) >= next.first + next.columns)
        break;
      const Run both{run.first, run.columns + next.columns, run.columns + next.rows};
      if (both.size() > run.size() + next.size() + plan::numbers_worth_a_front) break;
      run = both;
      merged.pop_back();
    }
    merged.push_back(run);
  }
  return merged;
}

}  // namespace

double Supernodes::num_stored() const {
  double sum = 0.0;
  for (std::size_t s = 0; s < size(); ++s) {
    const auto columns = static_cast<double>(num_columns(s));
    sum += columns * (static_cast<double>(rows_of(s).size()) - 0.5 * (columns - 1.0));
  }
  return sum;
}

Supernodes find_supernodes(const TrianglePattern& lower, std::size_t num_kept) {
  const Groups<int> by_row = columns_by_row(lower);
  const Columns columns = analyze_columns(lower, by_row);
  const std::vector<Run> reversed = merge_runs(find_equal_columns(columns, num_kept), columns.parent, num_kept);
  Supernodes result;
  result.rows_start.push_back(0);
  std::vector<int> supernode_of(lower.size());
  for (auto run = reversed.rbegin(); run != reversed.rend(); ++run) {
    std::fill_n(supernode_of.begin() + static_cast<std::ptrdiff_t>(run->first), run->columns,
                static_cast<int>(result.first_column.size()));
    result.first_column.push_back(static_cast<int>(run->first));
    result.rows_start.push_back(result.rows_start.back() + run->rows);
  }
  result.first_column.push_back(static_cast<int>(lower.size()));
  result.rows.resize(result.rows_start.back());

  result.parent.assign(result.size(), -1);
  std::vector<std::size_t> next(result.size());
  for (std::size_t s = 0; s < result.size(); ++s) {
    next[s] = result.rows_start[s];
    for (int j = result.first_column[s]; j < result.first_column[s + 1]; ++j) result.rows[next[s]++] = j;
    if (const int above = columns.parent[static_cast<std::size_t>(result.first_column[s + 1]) - 1]; above >= 0)
      result.parent[s] = supernode_of[static_cast<std::size_t>(above)];
  }
  // A row is in all supernodes of its subtree: those of its columns, and all between them and its own one.
  std::vector<int> seen(result.size(), -1);
  for (int row = 0; row < static_cast<int>(lower.size()); ++row) {
    for (const int column : by_row[static_cast<std::size_t>(row)]) {
      auto s = static_cast<std::size_t>(supernode_of[static_cast<std::size_t>(column)]);
      const auto own = static_cast<std::size_t>(supernode_of[static_cast<std::size_t>(row)]);
      for (; s != own && std::exchange(seen[s], row) != row; s = static_cast<std::size_t>(result.parent[s]))
        result.rows[next[s]++] = row;
    }
  }
  for (std::size_t s = 0; s < result.size(); ++s)
    ensure(next[s] == result.rows_start[s + 1], "a supernode has the rows that were counted");
  return result;
}

}  // namespace tanor::detail
