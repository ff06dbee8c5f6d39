#include "statics/augmented_stiffness.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::detail {

namespace {

/// Ratio of the penalty C to the stiffness of the row's points. With it conjugate residuals take two or three steps. It
/// costs some digits, and one refinement restores half of them.
constexpr double penalty = 1e5;

/// Returns the pattern of a triangle of points from pairs (column, row).
TrianglePattern make_triangle(std::size_t size, std::vector<std::pair<int, int>> entries) {
  TrianglePattern result;
  compress_pairs(size, std::move(entries), &result.start, &result.rows);
  return result;
}

/// Calls visit(a, b) for all pairs of blocks in one row of K.
template <class Visit>
void for_pairs_of_rows(const Groups<Incidence>& by_row, const Visit& visit) {
  for (std::size_t row = 0; row < by_row.size(); ++row) {
    for (const Incidence& a : by_row[row]) {
      for (const Incidence& b : by_row[row]) visit(a, b);
    }
  }
}

}  // namespace

// ---- the pattern ----

AugmentedStiffness::AugmentedStiffness(const EquilibriumEquations& equations, Ordering ordering)
    : equations_(equations), model_(equations.model()), pattern_version_(equations.stiffness().pattern_version()) {
  std::vector<std::pair<int, int>> entries;
  for_each_stiffness_block([&](int i, int j, std::size_t) { entries.push_back(std::minmax(i, j)); });
  const Groups<Incidence> by_row = group_by_row();
  for_pairs_of_rows(by_row,
                    [&](const Incidence& a, const Incidence& b) { entries.push_back(std::minmax(a.point, b.point)); });
  order_points(ordering, std::move(entries));

  stiffness_slots_.assign(equations_.stiffness().columns().size(), -1);
  for_each_stiffness_block([&](int i, int j, std::size_t k) { stiffness_slots_[k] = slot(i, j); });
  list_products(by_row);
  expand_pattern();
  transpose_pattern();
}

/// Calls visit(i, j, k) for block k of W, which stands in the row of point i and the column of point j.
template <class Visit>
void AugmentedStiffness::for_each_stiffness_block(const Visit& visit) const {
  const StiffnessMatrix& W = equations_.stiffness();
  for (int i = 0; i < static_cast<int>(W.num_points()); ++i) {
    const auto begin = static_cast<std::size_t>(W.start()[static_cast<std::size_t>(i)]);
    const auto end = static_cast<std::size_t>(W.start()[static_cast<std::size_t>(i) + 1]);
    for (std::size_t k = begin; k < end; ++k) visit(i, W.columns()[k], k);
  }
}

/// Returns the blocks of K that belong to moving points, row by row.
Groups<Incidence> AugmentedStiffness::group_by_row() const {
  const std::size_t n = equations_.stiffness().num_points(), num_rows = equations_.num_rows();
  return {num_rows, [&](const auto& add) {
            for (const Incidence& incidence : model_.incidences) {
              if (static_cast<std::size_t>(incidence.row) < num_rows && static_cast<std::size_t>(incidence.point) < n)
                add(incidence.row, incidence);
            }
          }};
}

/// Finds the elimination order and the blocks of A in it. `entries` are the pairs of points that have a block.
void AugmentedStiffness::order_points(Ordering ordering, std::vector<std::pair<int, int>> entries) {
  const std::size_t n = equations_.stiffness().num_points();
  const SymbolicAnalysis order = analyze(make_triangle(n, entries), ordering);
  place_.resize(n);
  for (std::size_t k = 0; k < n; ++k)
    place_[order.permutation.empty() ? k : static_cast<std::size_t>(order.permutation[k])] = static_cast<int>(k);

  for (auto& [i, j] : entries) {
    const auto [row, column] = std::minmax(place_[static_cast<std::size_t>(i)], place_[static_cast<std::size_t>(j)]);
    i = column, j = row;
  }
  const TrianglePattern points = make_triangle(n, std::move(entries));
  start_ = points.start;
  rows_ = points.rows;
  blocks_.resize(rows_.size());
}

void AugmentedStiffness::list_products(const Groups<Incidence>& by_row) {
  for_pairs_of_rows(by_row, [&](const Incidence& a, const Incidence& b) {
    if (const int at = slot(a.point, b.point); at >= 0)
      products_.push_back({a.row, a.block, b.block, a.sign * b.sign, at});
  });
}

/// Expands the pattern of blocks to numbers: column c of point j has 3 rows of each block above the diagonal, then rows
/// 0 to c of the diagonal block.
void AugmentedStiffness::expand_pattern() {
  for (std::size_t j = 0; j + 1 < start_.size(); ++j) {
    for (int c = 0; c < 3; ++c) {
      for (int k = start_[j]; k < start_[j + 1]; ++k) {
        const int first = 3 * rows_[static_cast<std::size_t>(k)], count = k + 1 < start_[j + 1] ? 3 : c + 1;
        for (int row = 0; row < count; ++row) upper_.rows.push_back(first + row);
      }
      upper_.start.push_back(static_cast<int>(upper_.rows.size()));
    }
  }
  values_.resize(upper_.rows.size());
}

/// Finds the lower triangle, the transpose of the upper one, by counting.
void AugmentedStiffness::transpose_pattern() {
  const Groups<std::pair<int, int>> lower(upper_.size(), [&](const auto& add) {
    for (std::size_t column = 0; column < upper_.size(); ++column) {
      for (int k = upper_.start[column]; k < upper_.start[column + 1]; ++k)
        add(upper_.rows[static_cast<std::size_t>(k)], std::pair{static_cast<int>(column), k});
    }
  });
  lower_.start.assign(lower.start.begin(), lower.start.end());
  for (const auto& [row, k] : lower.entries) {
    lower_.rows.push_back(row);
    transposed_.push_back(k);
  }
}

/// Returns the position of block (i, j) if it is in the upper triangle, else -1.
int AugmentedStiffness::slot(int i, int j) const {
  const int row = place_[static_cast<std::size_t>(i)], column = place_[static_cast<std::size_t>(j)];
  if (row > column) return -1;
  const auto begin = rows_.begin() + start_[static_cast<std::size_t>(column)];
  const auto end = rows_.begin() + start_[static_cast<std::size_t>(column) + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - rows_.begin());
}

/// Returns the position of the point's diagonal block, which is the last one of its column.
std::size_t AugmentedStiffness::own_slot(std::size_t point) const {
  return static_cast<std::size_t>(start_[place(point) + 1] - 1);
}

// ---- the values ----

void AugmentedStiffness::assemble(const std::vector<double>& shifts, double stiffer, std::vector<double>* penalties) {
  const StiffnessMatrix& W = equations_.stiffness();
  const double* const K = equations_.gradients().data();
  // A = W + s M
  std::fill(blocks_.begin(), blocks_.end(), Block3{});
  for (std::size_t k = 0; k < stiffness_slots_.size(); ++k) {
    if (stiffness_slots_[k] >= 0) blocks_[static_cast<std::size_t>(stiffness_slots_[k])] = W.blocks()[k];
  }
  for (std::size_t i = 0; i < num_points(); ++i) blocks_[own_slot(i)].add_identity(shifts[i] * model_.mass[i]);
  find_penalties(shifts, stiffer, penalties);
  // A += C g_a g_b'
  for (const auto& [row, a, b, sign, at] : products_)
    blocks_[static_cast<std::size_t>(at)].add_product(sign * (*penalties)[static_cast<std::size_t>(row)], load(K, a),
                                                      load(K, b));
  expand_values();
}

/// Sets C_a = penalty (stiffness of the row's points)/|gradient|^2, and 0 for a row that moves no point.
void AugmentedStiffness::find_penalties(const std::vector<double>& shifts, double stiffer,
                                        std::vector<double>* penalties) const {
  const std::vector<double> stiffness = stiffness_of_points(shifts);
  const double most = stiffness.empty() ? 0.0 : std::ranges::max(stiffness);
  const double least = most > 0.0 ? 1e-6 * most : 1.0;
  std::vector<double> squares(model_.num_rows(), 0.0);
  penalties->assign(model_.num_rows(), least);
  for (const Incidence& incidence : model_.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), point = static_cast<std::size_t>(incidence.point);
    if (point >= stiffness.size()) continue;
    const Vec3 gradient = load(equations_.gradients().data(), incidence.block);
    squares[row] = std::max(squares[row], detail::dot(gradient, gradient));
    (*penalties)[row] = std::max((*penalties)[row], stiffness[point]);
  }
  for (std::size_t row = 0; row < squares.size(); ++row)
    (*penalties)[row] = squares[row] > 0.0 ? stiffer * penalty * (*penalties)[row] / squares[row] : 0.0;
}

/// Returns the largest entry of each point's diagonal block. W and s M may cancel each other, so their absolute values
/// are summed.
std::vector<double> AugmentedStiffness::stiffness_of_points(const std::vector<double>& shifts) const {
  std::vector<double> result(num_points());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const Block3& own = blocks_[own_slot(i)];
    const double mass = shifts[i] * model_.mass[i];
    for (int row = 0; row < 3; ++row) {
      for (int c = 0; c < 3; ++c)
        result[i] = std::max(result[i], std::abs(own(row, c) - (row == c ? mass : 0.0)) + std::abs(mass));
    }
  }
  return result;
}

void AugmentedStiffness::expand_values() {
  double* value = values_.data();
  for (std::size_t j = 0; j + 1 < start_.size(); ++j) {
    for (int c = 0; c < 3; ++c) {
      for (int k = start_[j]; k < start_[j + 1]; ++k) {
        const int count = k + 1 < start_[j + 1] ? 3 : c + 1;
        for (int row = 0; row < count; ++row) *value++ = blocks_[static_cast<std::size_t>(k)](row, c);
      }
    }
  }
}

std::vector<double> AugmentedStiffness::lower_values() const {
  std::vector<double> result(transposed_.size());
  for (std::size_t k = 0; k < result.size(); ++k) result[k] = values_[static_cast<std::size_t>(transposed_[k])];
  return result;
}

}  // namespace tanor::detail
