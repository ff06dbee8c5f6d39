#include "schur/redundancy.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/numbers.hpp"

namespace tanor::detail {

double find_mass_ratio(std::span<const Incidence> incidences, std::span<const double> inverse_mass) {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (const Incidence& incidence : incidences) {
    const double inverse = inverse_mass[static_cast<std::size_t>(incidence.point)];
    if (inverse == 0.0) continue;
    smallest = std::min(smallest, inverse);
    largest = std::max(largest, inverse);
  }
  return largest > 0.0 ? largest / smallest : 1.0;
}

Redundancy::Redundancy(std::span<const Incidence> incidences, std::span<const double> inverse_mass,
                       const Numbering& numbering)
    : incidences_(incidences), inverse_mass_(inverse_mass), numbering_(numbering) {}

// ---- decisions ----

/// Returns C = M^-1/2 K of an island, or K itself, for moving points alone, in the order in which its rows meet them.
SparseColumns Redundancy::columns(const double* blocks, Rows rows, Scaling scaling) {
  std::vector<Index> points;
  SparseColumns C = collect_columns(static_cast<std::size_t>(rows.second - rows.first), [&](const auto& add) {
    for (Index a = rows.first; a < rows.second; ++a) {
      for (const Index k : by_row_[static_cast<std::size_t>(a)]) {
        const Incidence& incidence = incidences_[static_cast<std::size_t>(k)];
        const double inverse_mass = inverse_mass_[static_cast<std::size_t>(incidence.point)];
        if (inverse_mass == 0.0) continue;
        Index& local = local_point_[static_cast<std::size_t>(incidence.point)];
        if (local < 0) {
          local = static_cast<Index>(points.size());
          points.push_back(incidence.point);
        }
        const double scale = scaling == Scaling::ByMasses ? std::sqrt(inverse_mass) : 1.0;
        add(a - rows.first, PointEntry{local, incidence.sign * scale * load(blocks, incidence.block)});
      }
    }
  });
  C.num_rows = 3 * static_cast<int>(points.size());
  stand_alone(rows.first, &C);
  for (const Index point : points) local_point_[static_cast<std::size_t>(point)] = -1;
  return C;
}

/// Makes each contact row without gradient, which takes no part, a unit column of its own, so that it depends on
/// nothing.
void Redundancy::stand_alone(Index first_row, SparseColumns* C) const {
  for (std::size_t k = 0; k + 1 < C->start.size(); ++k) {
    const auto begin = C->values.begin() + C->start[k], end = C->values.begin() + C->start[k + 1];
    const bool is_contact = numbering_.is_contact_row(static_cast<std::size_t>(first_row) + k);
    if (!is_contact || std::any_of(begin, end, [](double x) { return x != 0.0; })) continue;
    *begin = 1.0;
    C->rows[static_cast<std::size_t>(C->start[k])] = C->num_rows++;
  }
}

/// Returns the mass ratio of the points that an island's rows move.
double Redundancy::mass_ratio_of(Rows rows) const {
  std::vector<Incidence> own;
  for (Index a = rows.first; a < rows.second; ++a) {
    for (const Index k : by_row_[static_cast<std::size_t>(a)]) own.push_back(incidences_[static_cast<std::size_t>(k)]);
  }
  return find_mass_ratio(own, inverse_mass_);
}

bool Redundancy::decide_island(const double* blocks, Rows rows, std::span<const double> tolerances) {
  const double tolerance = *std::max_element(tolerances.begin() + rows.first, tolerances.begin() + rows.second);
  const auto place = std::lower_bound(islands_.begin(), islands_.end(), rows.first,
                                      [](const Island& island, Index row) { return island.first < row; });
  const bool is_known = place != islands_.end() && place->first == rows.first;
  Island& island = is_known ? *place : *islands_.insert(place, Island{rows.first, rows.second, nullptr, false});
  SparseColumns C = columns(blocks, rows, Scaling::ByMasses);
  if (is_known && island.tolerance == tolerance && island.columns == C) return false;
  const auto make = [&](Scaling scaling) { return scaling == Scaling::ByMasses ? C : columns(blocks, rows, scaling); };
  island.solver = decide_rank(make, tolerance, [&] { return mass_ratio_of(rows); });
  island.columns = std::move(C);
  island.tolerance = tolerance;
  bool has_changed = false;
  std::vector<char> dependent(static_cast<std::size_t>(rows.second - rows.first), 0);
  for (const Dependence& dependence : island.solver->dependences())
    dependent[static_cast<std::size_t>(dependence.column)] = 1;
  for (std::size_t k = 0; k < dependent.size(); ++k) {
    char& now = dependent_[static_cast<std::size_t>(rows.first) + k];
    if (now == dependent[k]) continue;
    has_changed = true;
    dependent[k] != 0 ? ++num_dependent_ : --num_dependent_;
    now = dependent[k];
  }
  return has_changed;
}

bool Redundancy::decide(const double* blocks, Rows rows, std::span<const double> tolerances) {
  if (dependent_.empty()) {
    by_row_ = {numbering_.num_rows(), [&](const auto& add) {
                 for (std::size_t k = 0; k < incidences_.size(); ++k) add(incidences_[k].row, static_cast<Index>(k));
               }};
    local_point_.assign(inverse_mass_.size(), -1);
    dependent_.assign(numbering_.num_rows(), 0);
  }
  bool has_changed = false;
  const auto& start = numbering_.island_start;
  for (std::size_t i = 0; i + 1 < start.size(); ++i) {
    if (start[i] < rows.first || start[i] >= rows.second) continue;
    has_changed = decide_island(blocks, {start[i], start[i + 1]}, tolerances) || has_changed;
  }
  return has_changed;
}

bool Redundancy::decide_again(const double* blocks, std::span<const double> tolerances) {
  bool has_changed = false;
  for (const Island& island : islands_) {
    if (island.solver->dependences().empty()) continue;
    has_changed = decide_island(blocks, {island.first, island.end}, tolerances) || has_changed;
  }
  return has_changed;
}

double Redundancy::smallest_singular_value() const {
  double smallest = 1.0;
  for (const Island& island : islands_) smallest = std::min(smallest, island.solver->smallest_singular_value());
  return smallest;
}

// ---- solutions ----

void Redundancy::take_qr(Rows rows) {
  for (Island& island : islands_) {
    if (island.first < rows.first || island.first >= rows.second || island.by_qr) continue;
    island.by_qr = true;
    ++num_qr_;
  }
}

void Redundancy::release_qr() {
  for (Island& island : islands_) island.by_qr = false;
  num_qr_ = 0;
}

std::span<const char> Redundancy::rows_for_gram() {
  if (!is_found() && !uses_qr()) return {};
  for_gram_.resize(dependent_.size());
  for (std::size_t a = 0; a < dependent_.size(); ++a) for_gram_[a] = dependent_[a] == 0;
  for (const Island& island : islands_) {
    if (island.by_qr) std::fill(for_gram_.begin() + island.first, for_gram_.begin() + island.end, 0);
  }
  return for_gram_;
}

void Redundancy::solve_negative(const double* b, double* x) {
  for (const Island& island : islands_) {
    if (!island.by_qr) continue;
    for (Index a = island.first; a < island.end; ++a) x[a] = -b[a];
    island.solver->solve(x + island.first);
  }
}

void Redundancy::minimize_norm(double* lambda) const {
  for (const Island& island : islands_) {
    if (!island.solver->dependences().empty()) island.solver->minimize_norm(lambda + island.first);
  }
}

// ---- what was found ----

Redundancy::Found Redundancy::translate(const Island& island, const Dependence& dependence) const {
  Found found{island.first + dependence.column, {}};
  for (const Dependence::Term& term : dependence.terms) {
    found.terms.emplace_back(island.first + term.column, term.coefficient);
  }
  return found;
}

std::vector<Redundancy::Found> Redundancy::list() const {
  std::vector<Found> result;
  for (const Island& island : islands_) {
    for (const Dependence& dependence : island.solver->dependences()) result.push_back(translate(island, dependence));
  }
  return result;
}

void Redundancy::mark_unique(std::vector<bool>* is_unique) const {
  for (const Island& island : islands_) {
    const std::vector<bool> unique = island.solver->unique();
    std::copy(unique.begin(), unique.end(), is_unique->begin() + island.first);
  }
}

std::optional<Redundancy::Contradiction> Redundancy::find_contradiction(std::span<const double> b,
                                                                        std::span<const double> scale,
                                                                        double allowed) const {
  constexpr double safety = 1e3;  // a bound by norms may be short by this factor
  std::optional<Contradiction> worst;
  double largest = 1.0;
  for (const Island& island : islands_) {
    const RankSolver& solver = *island.solver;
    const auto first = static_cast<std::size_t>(island.first), size = static_cast<std::size_t>(island.end) - first;
    const double rounding = safety * eps / solver.singular_value_in_question();
    const auto contradictions = solver.contradictions(b.subspan(first, size));
    for (std::size_t k = 0; k < contradictions.size(); ++k) {
      const auto& [column, excess, magnitude] = contradictions[k];
      const double terms = std::max(magnitude, scale[first + static_cast<std::size_t>(column)]);
      const double explained = std::max(allowed, rounding) * terms;
      if (!(std::abs(excess) > largest * explained)) continue;
      largest = std::abs(excess) / explained;
      worst = {translate(island, solver.dependences()[k]), excess};
    }
  }
  return worst;
}

}  // namespace tanor::detail
