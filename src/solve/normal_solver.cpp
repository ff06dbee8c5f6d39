#include "solve/normal_solver.hpp"

#include <algorithm>
#include <set>

#include "plan/partition.hpp"

namespace tanor {

namespace {

std::string ordering_name(Ordering ordering) {
  switch (ordering) {
    case Ordering::Amd:
      return "amd";
    case Ordering::Metis:
      return "metis";
    case Ordering::Nesdis:
      return "nesdis";
    case Ordering::Natural:
    case Ordering::Auto:
      break;
  }
  return "natural";
}

std::string join(const std::set<std::string>& words) {
  std::string result;
  for (const std::string& word : words) result += (result.empty() ? "" : "+") + word;
  return result.empty() ? "none" : result;
}

/// The incidences that make products: of moving points, grouped by point, split into the parts of their rows.
std::vector<std::vector<Incidence>> incidences_of_parts(std::span<const Incidence> incidences,
                                                        std::span<const double> inverse_masses,
                                                        std::span<const Index> part_start) {
  std::vector<std::vector<Incidence>> result(part_start.size() - 1);
  for (const Incidence& incidence : incidences) {
    if (inverse_masses[static_cast<std::size_t>(incidence.point)] == 0.0) continue;
    const auto after = std::upper_bound(part_start.begin(), part_start.end(), incidence.row);
    result[static_cast<std::size_t>(after - part_start.begin() - 1)].push_back(incidence);
  }
  for (auto& part : result) {
    std::stable_sort(part.begin(), part.end(),
                     [](const Incidence& a, const Incidence& b) { return a.point < b.point; });
  }
  return result;
}

}  // namespace

NormalSolver::NormalSolver(std::span<const Incidence> incidences, std::span<const double> inverse_masses,
                           const Numbering& numbering, Ordering wanted, std::span<const double> squared_norms)
    : first_idle_row_(numbering.first_idle_row()), num_rows_(numbering.num_rows()) {
  const std::vector<Index> part_start = partition_islands(numbering.island_start);
  const auto by_part = incidences_of_parts(incidences, inverse_masses, part_start);
  std::set<std::string> orderings, factorizations;
  for (std::size_t p = 0; p + 1 < part_start.size(); ++p) {
    const Index first_row = part_start[p];
    const auto num_rows = static_cast<std::size_t>(part_start[p + 1] - first_row);
    const std::vector<Product> products = list_products(by_part[p], inverse_masses, first_row);

    const GatherPlan unordered(products, num_rows, {}, Triangle::Lower);
    SymbolicAnalysis analysis = analyze({unordered.column_start(), unordered.rows()}, wanted);

    std::vector<int> place(analysis.permutation.size());
    for (std::size_t k = 0; k < place.size(); ++k)
      place[static_cast<std::size_t>(analysis.permutation[k])] = static_cast<int>(k);
    GatherPlan plan(products, num_rows, place, analysis.supernodal ? Triangle::Lower : Triangle::Upper, squared_norms);
    Cholesky cholesky({plan.column_start(), plan.rows()}, analysis.supernodal);

    summary_.pattern_nonzeros += plan.rows().size();
    summary_.factor_nonzeros += analysis.factor_nonzeros;
    summary_.flops += analysis.flops;
    orderings.insert(ordering_name(analysis.ordering));
    factorizations.insert(analysis.supernodal ? "supernodal" : "simplicial");
    parts_.push_back({first_row,
                      std::move(analysis.permutation),
                      std::move(plan),
                      std::move(cholesky),
                      std::vector<double>(num_rows),
                      {}});
  }
  summary_.parts = parts_.size();
  summary_.ordering = join(orderings);
  summary_.factorization = join(factorizations);
}

void NormalSolver::assemble(const Parallel& parallel, const double* blocks) {
  parallel.for_tasks(parts_.size(), [&](std::size_t p) {
    Part& part = parts_[p];
    part.plan.assemble(blocks, part.cholesky.values());
  });
}

NormalSolver::Quality NormalSolver::factorize(const Parallel& parallel) {
  parallel.for_tasks(parts_.size(), [&](std::size_t p) {
    Part& part = parts_[p];
    const Cholesky::Quality quality = part.cholesky.factorize();
    const std::size_t column = quality.weakest_column;
    const bool ordered = !part.permutation.empty() && column < part.permutation.size();
    const std::size_t row = ordered ? static_cast<std::size_t>(part.permutation[column]) : column;
    part.quality = {quality.positive_definite, static_cast<std::size_t>(part.first_row) + row,
                    quality.reciprocal_condition};
  });
  // A failed part before a weak one, the weakest before others.
  const auto badness = [](const Quality& q) { return q.positive_definite ? q.reciprocal_condition : -1.0; };
  Quality worst;
  for (const Part& part : parts_) {
    if (badness(part.quality) <= badness(worst)) worst = part.quality;
  }
  return worst;
}

void NormalSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  std::fill(x + first_idle_row_, x + num_rows_, 0.0);
  // S = D^-1 (scaled S) D^-1 with D = diag(scale): x = D (scaled S)^-1 D b, in the order of elimination.
  parallel.for_tasks(parts_.size(), [&](std::size_t p) {
    Part& part = parts_[p];
    const double* const b_rows = b + part.first_row;
    double* const x_rows = x + part.first_row;
    const std::size_t n = part.x.size();
    const double* const scale = part.plan.scale().data();
    const int* const permutation = part.permutation.empty() ? nullptr : part.permutation.data();
    const auto row = [&](std::size_t k) {
      return permutation != nullptr ? static_cast<std::size_t>(permutation[k]) : k;
    };
    for (std::size_t k = 0; k < n; ++k) part.x[k] = -scale[k] * b_rows[row(k)];
    part.cholesky.solve(part.x.data());
    for (std::size_t k = 0; k < n; ++k) x_rows[row(k)] = scale[k] * part.x[k];
  });
}

}  // namespace tanor
