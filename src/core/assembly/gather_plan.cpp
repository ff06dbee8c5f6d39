#include "assembly/gather_plan.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/check.hpp"
#include "base/counts.hpp"
#include "base/groups.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

std::vector<Incidence> group_by_point(std::span<const Incidence> incidences, std::span<const double> weights) {
  return Groups<Incidence>(weights.size(),
                           [&](const auto& add) {
                             for (const Incidence& incidence : incidences) {
                               if (weights[static_cast<std::size_t>(incidence.point)] != 0.0)
                                 add(incidence.point, incidence);
                             }
                           })
      .entries;
}

std::vector<Product> list_products(std::span<const Incidence> incidences, std::span<const double> weights,
                                   int first_row) {
  double count = 0.0;
  for (std::size_t begin = 0, end = 0; begin < incidences.size(); begin = end) {
    while (end < incidences.size() && incidences[end].point == incidences[begin].point) ++end;
    const auto at_point = static_cast<double>(end - begin);
    count += 0.5 * at_point * (at_point + 1.0);
  }
  check_count(count, "S of " + std::to_string(incidences.size()) + " gradients",
              "products of gradients at the same points");
  std::vector<Product> products;
  products.reserve(static_cast<std::size_t>(count));
  for (std::size_t begin = 0, end = 0; begin < incidences.size(); begin = end) {
    const Index point = incidences[begin].point;
    while (end < incidences.size() && incidences[end].point == point) ++end;
    const double weight = weights[static_cast<std::size_t>(point)];
    for (std::size_t a = begin; a < end; ++a) {
      for (std::size_t b = begin; b < end; ++b) {
        const Incidence &p = incidences[a], &q = incidences[b];
        if (p.row < q.row) continue;
        products.push_back({p.row - first_row, q.row - first_row, p.block, q.block, p.sign * q.sign * weight});
      }
    }
  }
  return products;
}

GatherPlan::GatherPlan(std::span<const Product> products, std::size_t num_rows, std::span<const int> place,
                       Triangle triangle, std::span<const double> squared_norms)
    : start_(1, 0), scale_(num_rows, 1.0) {
  check_count(static_cast<double>(products.size()), "X'WX of " + std::to_string(num_rows) + " rows",
              "products of blocks");
  // The products are grouped by column of the wanted triangle, then sorted by row, and by their numbers, which fixes
  // the order of the sums.
  const auto placed = [&](int row) { return place.empty() ? row : place[static_cast<std::size_t>(row)]; };
  const auto entry = [&](const Product& product) {
    const int a = placed(product.row), b = placed(product.column);
    const int low = std::min(a, b), high = std::max(a, b);
    return triangle == Triangle::Lower ? std::pair{low, high} : std::pair{high, low};  // column, row
  };
  Groups<Placed> columns(num_rows, [&](const auto& add) {
    for (std::size_t k = 0; k < products.size(); ++k) {
      const auto [column, row] = entry(products[k]);
      add(column, Placed{row, static_cast<int>(k)});
    }
  });

  start_.reserve(num_rows + 1);
  rows_.reserve(products.size());
  terms_.reserve(products.size());
  diagonal_.reserve(num_rows);
  for (std::size_t column = 0; column < num_rows; ++column) append_column(products, columns[column]);

  if (squared_norms.empty()) return;
  std::vector<double> diagonal(num_rows, 0.0);
  for (const Product& product : products) {
    if (product.row != product.column) continue;
    diagonal[static_cast<std::size_t>(placed(product.row))] +=
        product.weight * squared_norms[static_cast<std::size_t>(product.block_a)];
  }
  for (std::size_t j = 0; j < num_rows; ++j) scale_[j] = 1.0 / std::sqrt(diagonal[j]);
  scale_weights();
}

/// Appends the slots and terms of the next column; products of equal blocks become one term.
void GatherPlan::append_column(std::span<const Product> products, std::span<Placed> column) {
  const auto number = static_cast<int>(start_.size()) - 1;
  std::ranges::sort(column, {}, [](const Placed& placed) { return std::pair(placed.row, placed.product); });
  for (std::size_t k = 0; k < column.size(); ++k) {
    const Product& product = products[static_cast<std::size_t>(column[k].product)];
    const Term term{product.block_a, product.block_b, product.weight};
    if (k == 0 || column[k - 1].row != column[k].row) {
      if (column[k].row == number) diagonal_.push_back(static_cast<int>(rows_.size()));
      rows_.push_back(column[k].row);
      terms_.push_back(term);
    } else if (terms_.back().block_a == term.block_a && terms_.back().block_b == term.block_b) {
      terms_.back().weight += term.weight;
    } else {
      extras_.push_back({static_cast<int>(rows_.size()) - 1, term});
    }
  }
  start_.push_back(static_cast<int>(rows_.size()));
  ensure(diagonal_.size() + 1 == start_.size(), "every row touches a moving point");
}

/// Multiplies the scale into the weights for good.
void GatherPlan::scale_weights() {
  std::size_t extra = 0;
  for (std::size_t column = 0; column < scale_.size(); ++column) {
    for (int slot = start_[column]; slot < start_[column + 1]; ++slot) {
      const double factor = scale_[column] * scale_[static_cast<std::size_t>(rows_[static_cast<std::size_t>(slot)])];
      terms_[static_cast<std::size_t>(slot)].weight *= factor;
      for (; extra < extras_.size() && extras_[extra].slot == slot; ++extra) extras_[extra].term.weight *= factor;
    }
  }
  weights_are_scaled_ = true;
}

void GatherPlan::assemble(const double* blocks, double* values, const Parallel& parallel) {
  const auto value = [&](const Term& term) {
    return term.weight * dot(load(blocks, term.block_a), load(blocks, term.block_b));
  };
  const auto gather = [&](std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) values[slot] = value(terms_[slot]);
    const auto slot_of = [](const ExtraTerm& extra) { return static_cast<std::size_t>(extra.slot); };
    for (auto extra = std::ranges::lower_bound(extras_, begin, {}, slot_of);
         extra != extras_.end() && slot_of(*extra) < end; ++extra)
      values[extra->slot] += value(extra->term);
  };
  parallel.for_ranges(terms_.size(), gather, plan::products_worth_a_thread);
  if (weights_are_scaled_) return;

  // A row without gradient keeps its zero diagonal, at which the factorization stops.
  parallel.for_ranges(scale_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      const double diagonal = values[diagonal_[j]];
      scale_[j] = diagonal == 0.0 ? 1.0 : 1.0 / std::sqrt(diagonal);
    }
  });
  parallel.for_ranges(scale_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t column = begin; column < end; ++column) {
      for (int slot = start_[column]; slot < start_[column + 1]; ++slot)
        values[slot] *= scale_[column] * scale_[static_cast<std::size_t>(rows_[static_cast<std::size_t>(slot)])];
    }
  });
}

}  // namespace tanor::detail
