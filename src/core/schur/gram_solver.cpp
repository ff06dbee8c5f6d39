#include "schur/gram_solver.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/power_iteration.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

std::vector<Index> partition_islands(std::span<const Index> island_start) {
  const Index num_rows = island_start.back();
  const Index wanted = std::clamp<Index>(num_rows / plan::least_rows_of_part, 1, plan::most_parts);
  std::vector<Index> result{0};
  for (const Index start : island_start) {
    const auto next = static_cast<Index>(result.size());
    if (start < num_rows && next < wanted && start >= static_cast<long long>(num_rows) * next / wanted) {
      result.push_back(start);
    }
  }
  if (num_rows > 0) result.push_back(num_rows);
  return result;
}

namespace {

/// Returns the points of the rows from `first_row` on; `incidences` are theirs, grouped by point.
RowsInSpace find_points(std::span<const Incidence> incidences, Index first_row, Index end_row,
                        const PointPlaces& places) {
  if (places.positions.empty()) return {};
  RowsInSpace result;
  std::vector<int> number(incidences.size());  // number of the incidence's point
  for (std::size_t k = 0; k < incidences.size(); ++k) {
    const Index point = incidences[k].point;
    if (k == 0 || point != incidences[k - 1].point) {
      const auto user = static_cast<std::size_t>(places.user_point[static_cast<std::size_t>(point)]);
      const auto position = places.positions.subspan(3 * user, 3);
      result.positions.insert(result.positions.end(), position.begin(), position.end());
    }
    number[k] = static_cast<int>(result.num_points()) - 1;
  }
  result.points_of_row = Groups<int>(static_cast<std::size_t>(end_row - first_row), [&](const auto& add) {
    for (std::size_t k = 0; k < incidences.size(); ++k) add(incidences[k].row - first_row, number[k]);
  });
  return result;
}

}  // namespace

GramSolver::GramSolver(const RowIslands& rows, LinearSolver wanted)
    : first_idle_row_(static_cast<std::size_t>(rows.start.back())),
      num_rows_(rows.num_rows),
      is_by_cholmod_(wanted == LinearSolver::Cholmod) {}

GramSolver::GramSolver(std::span<const Incidence> incidences, std::span<const double> weights, const RowIslands& rows,
                       Ordering ordering, std::span<const double> squared_norms, const PointPlaces& places,
                       LinearSolver wanted)
    : GramSolver(rows, wanted) {
  const std::vector<Index> part_start = partition_islands(rows.start);
  // The incidences that make products stay grouped by point.
  const Groups<Incidence> by_part(
      part_start.size() - 1, [&, own = group_by_point(incidences, weights)](const auto& add) {
        for (const Incidence& each : own)
          add(std::ranges::upper_bound(part_start, each.row) - part_start.begin() - 1, each);
      });
  for (std::size_t p = 0; p + 1 < part_start.size(); ++p) {
    add_part(list_products(by_part[p], weights, part_start[p]), part_start[p], part_start[p + 1], ordering,
             squared_norms, [&] { return find_points(by_part[p], part_start[p], part_start[p + 1], places); });
  }
}

GramSolver::GramSolver(std::span<const Product> products, const RowIslands& rows, Ordering ordering,
                       LinearSolver wanted)
    : GramSolver(rows, wanted) {
  const std::vector<Index> part_start = partition_islands(rows.start);
  auto begin = products.begin();
  std::vector<Product> part;
  for (std::size_t p = 0; p + 1 < part_start.size(); ++p) {
    const Index first = part_start[p], last = part_start[p + 1];
    const auto end = std::find_if(begin, products.end(), [&](const Product& product) { return product.row >= last; });
    part.assign(begin, end);
    for (Product& product : part) {
      product.row -= first;
      product.column -= first;
    }
    add_part(part, first, last, ordering, {}, {});
    begin = end;
  }
}

void GramSolver::add_part(std::span<const Product> products, Index first_row, Index end_row, Ordering wanted,
                          std::span<const double> squared_norms, const FindPoints& find_points) {
  const auto num_rows = static_cast<std::size_t>(end_row - first_row);
  const GatherPlan unordered(products, num_rows, {}, Triangle::Lower);
  SymbolicAnalysis analysis = analyze({unordered.column_start(), unordered.rows()}, wanted, find_points);
  // CHOLMOD's supernodal module would bind a library that links it to the GPL.
  if (is_by_cholmod_) analysis.supernodal = false;

  std::vector<int> place(analysis.permutation.size());
  for (std::size_t k = 0; k < place.size(); ++k)
    place[static_cast<std::size_t>(analysis.permutation[k])] = static_cast<int>(k);
  GatherPlan plan(products, num_rows, place, analysis.supernodal ? Triangle::Lower : Triangle::Upper, squared_norms);
  Cholesky factor({plan.column_start(), plan.rows()}, analysis.supernodal, is_by_cholmod_);

  // Dense fronts do ten multiplications in the time of one, on nets of 24 to 300 and lattices of 6 to 20 points a side.
  const double products_a_flop = analysis.supernodal ? 0.1 : 1.0;
  const double part_products = 10.0 * static_cast<double>(plan.rows().size()) + products_a_flop * analysis.flops +
                               6.0 * analysis.factor_nonzeros;
  summary_.products += part_products;
  summary_.factor.include({.parts = 1,
                           .pattern_nonzeros = plan.rows().size(),
                           .factor_nonzeros = static_cast<std::size_t>(analysis.factor_nonzeros),
                           .flops = analysis.flops,
                           .orderings = {analysis.ordering == Ordering::Auto ? Ordering::Natural : analysis.ordering},
                           .factorizations = {factor.kind()}});
  parts_.push_back({.first_row = first_row,
                    .permutation = std::move(analysis.permutation),
                    .plan = std::move(plan),
                    .factor = std::move(factor),
                    .x = std::vector<double>(num_rows),
                    .products = part_products});
}

template <class Visit>
void GramSolver::Part::for_slots(const Visit& visit) const {
  const std::vector<int>&start = plan.column_start(), &rows = plan.rows();
  for (std::size_t column = 0; column < x.size(); ++column) {
    for (auto slot = static_cast<std::size_t>(start[column]); slot < static_cast<std::size_t>(start[column + 1]);
         ++slot)
      visit(static_cast<std::size_t>(rows[slot]), column, slot);
  }
}

void GramSolver::set_active(std::span<const char> active) {
  for (Part& part : parts_) {
    part.fixed_slots.clear();
    part.inactive_places.clear();
    if (active.empty()) continue;
    part.for_slots([&](std::size_t row, std::size_t column, std::size_t slot) {
      const auto is_inactive = [&](std::size_t place) { return active[part.row_at(place)] == 0; };
      if (!is_inactive(column) && !is_inactive(row)) return;
      part.fixed_slots.push_back({slot, row == column ? 1.0 : 0.0});
      if (row == column) part.inactive_places.push_back(column);
    });
  }
}

void GramSolver::allow_zero_rows(const Numbering& numbering) {
  for (Part& part : parts_) {
    part.for_slots([&](std::size_t row, std::size_t column, std::size_t slot) {
      const std::size_t own = part.row_at(row);
      if (row != column || !numbering.comes_and_goes(own)) return;
      std::optional<std::size_t> contact;
      if (numbering.is_contact_row(own))
        contact = static_cast<std::size_t>(numbering.user_row[own]) - numbering.num_user_rows;
      part.may_be_zero.push_back({slot, contact});
    });
  }
}

std::vector<std::pair<Index, Index>> GramSolver::weak_parts(double reciprocal_condition) const {
  std::vector<std::pair<Index, Index>> result;
  for (const Part& part : parts_) {
    if (part.quality.positive_definite && part.quality.reciprocal_condition > reciprocal_condition) continue;
    result.emplace_back(part.first_row, part.first_row + static_cast<Index>(part.x.size()));
  }
  return result;
}

void GramSolver::assemble(const Parallel& parallel, const double* blocks) {
  for_parts(parallel, std::mem_fn(&Part::assembles_by_threads), [&](Part& part, int threads) {
    double* const values = part.factor.values();
    part.plan.assemble(blocks, values, Parallel(threads));
    for (const auto& [slot, contact] : part.may_be_zero) {
      const double weight = !contact ? 0.0 : compliance_weights_.empty() ? 1.0 : compliance_weights_[*contact];
      values[slot] = values[slot] == 0.0 ? 1.0 : values[slot] + weight * compliance_;
    }
    for (const auto& [slot, value] : part.fixed_slots) values[slot] = value;
  });
}

GramSolver::Quality GramSolver::factorize(const Parallel& parallel) {
  for_parts(parallel, std::mem_fn(&Part::factorizes_by_threads), [](Part& part, int threads) {
    part.quality = part.factor.factorize(threads);
    part.quality.weakest_row = part.row_at(part.quality.weakest_row);
  });
  // A failed part counts before a weak one, the weakest part before the others.
  const auto badness = [](const Quality& q) { return q.positive_definite ? q.reciprocal_condition : -1.0; };
  Quality worst;
  for (const Part& part : parts_) {
    if (badness(part.quality) <= badness(worst)) worst = part.quality;
  }
  return worst;
}

double GramSolver::estimate_reciprocal_condition() {
  constexpr int iterations = 4;
  double worst = 1.0;
  for (Part& part : parts_) {
    // |S|_1 is found from one triangle, since the other one mirrors it.
    std::vector<double> column_sum(part.x.size(), 0.0);
    part.for_slots([&](std::size_t row, std::size_t column, std::size_t slot) {
      const double size = std::abs(part.factor.values()[slot]);
      column_sum[column] += size;
      if (row != column) column_sum[row] += size;
    });
    const double inverse = estimate_norm(&part.x, iterations, [&] { part.factor.solve(part.x.data(), 1); });
    const double largest = *std::max_element(column_sum.begin(), column_sum.end());
    worst = std::min(worst, 1.0 / (largest * inverse));
  }
  return worst;
}

void GramSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  std::fill(x + first_idle_row_, x + num_rows_, 0.0);
  // S = D^-1 (scaled S) D^-1 with D = diag(scale), so x = D (scaled S)^-1 D b, in the order of elimination.
  for_parts(parallel, std::mem_fn(&Part::solves_by_threads), [&](Part& part, int threads) {
    const double* const b_rows = b + part.first_row;
    double* const x_rows = x + part.first_row;
    const std::size_t n = part.x.size();
    const double* const scale = part.plan.scale().data();
    const int* const permutation = part.permutation.empty() ? nullptr : part.permutation.data();
    const auto row = [&](std::size_t k) {
      return permutation != nullptr ? static_cast<std::size_t>(permutation[k]) : k;
    };
    const Parallel own(threads);
    own.for_ranges(n, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) part.x[k] = -scale[k] * b_rows[row(k)];
    });
    for (const std::size_t place : part.inactive_places) part.x[place] = 0.0;
    part.factor.solve(part.x.data(), threads);
    own.for_ranges(n, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) x_rows[row(k)] = scale[k] * part.x[k];
    });
  });
}

}  // namespace tanor::detail
