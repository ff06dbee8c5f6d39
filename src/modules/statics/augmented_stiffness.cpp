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
  equations_.stiffness().for_each_block([&](std::size_t i, std::size_t j, std::size_t) {
    entries.push_back({static_cast<int>(std::min(i, j)), static_cast<int>(std::max(i, j))});
  });
  const Groups<Incidence> by_row = group_by_row();
  for_pairs_of_rows(by_row,
                    [&](const Incidence& a, const Incidence& b) { entries.push_back(std::minmax(a.point, b.point)); });
  order_points(ordering, std::move(entries));

  stiffness_slots_.assign(equations_.stiffness().columns().size(), -1);
  equations_.stiffness().for_each_block([&](std::size_t i, std::size_t j, std::size_t k) {
    stiffness_slots_[k] = slot(static_cast<int>(i), static_cast<int>(j));
  });
  list_products(by_row);
  lower_.start.assign(3 * num_points() + 1, 0);
  for_each_number([&](std::size_t column, int row, int, int, int) {
    lower_.rows.push_back(row);
    lower_.start[column + 1] = static_cast<int>(lower_.rows.size());
  });
  values_.resize(lower_.rows.size());
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
    i = row, j = column;
  }
  const TrianglePattern points = make_triangle(n, std::move(entries));
  start_ = points.start;
  columns_ = points.rows;
  blocks_.resize(columns_.size());
}

void AugmentedStiffness::list_products(const Groups<Incidence>& by_row) {
  for_pairs_of_rows(by_row, [&](const Incidence& a, const Incidence& b) {
    if (const int at = slot(a.point, b.point); at >= 0)
      products_.push_back({a.row, a.block, b.block, a.sign * b.sign, at});
  });
}

/// Calls visit(column, row, k, r, c) for the numbers of the lower triangle, column by column, which are those of the
/// upper one row by row: entry (r, c) of block k. Of the diagonal block, the first one, the columns r to 2 count.
template <class Visit>
void AugmentedStiffness::for_each_number(const Visit& visit) const {
  for (std::size_t i = 0; i + 1 < start_.size(); ++i) {
    for (int r = 0; r < 3; ++r) {
      for (int k = start_[i]; k < start_[i + 1]; ++k) {
        for (int c = k == start_[i] ? r : 0; c < 3; ++c)
          visit(3 * i + static_cast<std::size_t>(r), 3 * columns_[static_cast<std::size_t>(k)] + c, k, r, c);
      }
    }
  }
}

/// Returns the position of block (i, j) if it is in the upper triangle, else -1.
int AugmentedStiffness::slot(int i, int j) const {
  const int row = place_[static_cast<std::size_t>(i)], column = place_[static_cast<std::size_t>(j)];
  return row > column ? -1 : find_slot(start_, columns_, row, column);
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
  for (std::size_t i = 0; i < num_points(); ++i)
    blocks_[static_cast<std::size_t>(start_[place(i)])].add_identity(shifts[i] * model_.mass[i]);
  find_penalties(shifts, stiffer, penalties);
  // A += C g_a g_b'
  for (const auto& [row, a, b, sign, at] : products_)
    blocks_[static_cast<std::size_t>(at)].add_product(sign * (*penalties)[static_cast<std::size_t>(row)], load(K, a),
                                                      load(K, b));
  double* value = values_.data();
  for_each_number(
      [&](std::size_t, int, int k, int r, int c) { *value++ = blocks_[static_cast<std::size_t>(k)](r, c); });
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
    const Block3& own = blocks_[static_cast<std::size_t>(start_[place(i)])];
    const double mass = shifts[i] * model_.mass[i];
    for (int row = 0; row < 3; ++row) {
      for (int c = 0; c < 3; ++c)
        result[i] = std::max(result[i], std::abs(own(row, c) - (row == c ? mass : 0.0)) + std::abs(mass));
    }
  }
  return result;
}

}  // namespace tanor::detail
