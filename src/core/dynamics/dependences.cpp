#include "dynamics/dependences.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"
#include "base/text.hpp"
#include "base/with_unit.hpp"

namespace tanor::detail {

Dependences::Dependences(const Workspace& work, std::span<const double> inverse_mass)
    : work_(work), model_(work.model()), inverse_mass_(inverse_mass) {}

// ---- decisions ----

/// Returns C = M^-1/2 K of an island, or K itself, for moving points alone, in the order in which its rows meet them.
SparseColumns Dependences::columns(const double* blocks, Rows rows, Scaling scaling) {
  std::vector<Index> points;
  SparseColumns C = collect_columns(static_cast<std::size_t>(rows.second - rows.first), [&](const auto& add) {
    for (Index a = rows.first; a < rows.second; ++a) {
      for (const Index k : by_row_[static_cast<std::size_t>(a)]) {
        const Incidence& incidence = model_.incidences[static_cast<std::size_t>(k)];
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

/// Makes each row that comes and goes and has no gradient now a unit column of its own, so that it depends on nothing.
void Dependences::stand_alone(Index first_row, SparseColumns* C) const {
  for (std::size_t k = 0; k < C->num_columns(); ++k) {
    const auto begin = C->values.begin() + C->start[k], end = C->values.begin() + C->start[k + 1];
    if (!model_.numbering.comes_and_goes(static_cast<std::size_t>(first_row) + k) ||
        std::any_of(begin, end, [](double x) { return x != 0.0; }))
      continue;
    *begin = 1.0;
    C->rows[static_cast<std::size_t>(C->start[k])] = C->num_rows++;
  }
}

double Dependences::mass_ratio_of(Rows rows) const {
  std::vector<Incidence> own;
  for (Index a = rows.first; a < rows.second; ++a) {
    for (const Index k : by_row_[static_cast<std::size_t>(a)])
      own.push_back(model_.incidences[static_cast<std::size_t>(k)]);
  }
  return find_mass_ratio(own, inverse_mass_);
}

bool Dependences::decide_island(const double* blocks, Rows rows, std::span<const double> tolerances) {
  const double tolerance = *std::max_element(tolerances.begin() + rows.first, tolerances.begin() + rows.second);
  const auto place = std::ranges::lower_bound(islands_, rows.first, {}, &Island::first);
  const bool is_known = place != islands_.end() && place->first == rows.first;
  Island& island = is_known ? *place : *islands_.insert(place, Island{rows.first, rows.second, nullptr});
  SparseColumns C = columns(blocks, rows, Scaling::ByMasses);
  if (is_known && island.tolerance == tolerance && island.columns == C) return false;
  const auto make = [&](Scaling scaling) { return scaling == Scaling::ByMasses ? C : columns(blocks, rows, scaling); };
  island.solver = decide_rank(make, tolerance, [&] { return mass_ratio_of(rows); });
  island.columns = std::move(C);
  island.tolerance = tolerance;
  const auto first = dependent_.begin() + rows.first, end = dependent_.begin() + rows.second;
  const std::vector<char> before(first, end);
  std::fill(first, end, 0);
  for (const Dependence& dependence : island.solver->dependences()) first[dependence.column] = 1;
  num_dependent_ += island.solver->dependences().size();
  num_dependent_ -= static_cast<std::size_t>(std::ranges::count(before, 1));
  return !std::equal(first, end, before.begin());
}

bool Dependences::decide(const double* blocks, Rows rows, std::span<const double> tolerances) {
  if (dependent_.empty()) {
    by_row_ = {model_.num_rows(), [&](const auto& add) {
                 for (std::size_t k = 0; k < model_.incidences.size(); ++k)
                   add(model_.incidences[k].row, static_cast<Index>(k));
               }};
    local_point_.assign(inverse_mass_.size(), -1);
    dependent_.assign(model_.num_rows(), 0);
  }
  bool has_changed = false;
  const auto& start = model_.numbering.island_start;
  for (std::size_t i = 0; i + 1 < start.size(); ++i) {
    if (start[i] < rows.first || start[i] >= rows.second) continue;
    has_changed = decide_island(blocks, {start[i], start[i + 1]}, tolerances) || has_changed;
  }
  return has_changed;
}

bool Dependences::decide_again(const double* blocks, std::span<const double> tolerances) {
  bool has_changed = false;
  for (const Island& island : islands_) {
    if (island.solver->dependences().empty()) continue;
    has_changed = decide_island(blocks, {island.first, island.end}, tolerances) || has_changed;
  }
  return has_changed;
}

void Dependences::note_change(const std::vector<double>& blocks) {
  gradient_norms_.assign(model_.num_rows(), 0.0);
  for (const Incidence& incidence : model_.incidences)
    gradient_norms_[static_cast<std::size_t>(incidence.row)] += squared(load(blocks.data(), incidence.block));
  // Rows of contacts that slide have no gradient now, and a unit one when they stick.
  for (double& norm : gradient_norms_) norm = norm > 0.0 ? std::sqrt(norm) : 1.0;
}

// ---- solutions ----

void Dependences::take_qr(Rows rows) {
  for (Island& island : islands_) {
    if (island.first < rows.first || island.first >= rows.second || island.by_qr) continue;
    island.by_qr = true;
    ++num_qr_;
  }
}

void Dependences::release_qr() {
  for (Island& island : islands_) island.by_qr = false;
  num_qr_ = 0;
}

std::span<const char> Dependences::rows_for_gram() {
  if (num_dependent_ == 0 && !uses_qr()) return {};
  for_gram_.resize(dependent_.size());
  for (std::size_t a = 0; a < dependent_.size(); ++a) for_gram_[a] = dependent_[a] == 0;
  for (const Island& island : islands_) {
    if (island.by_qr) std::fill(for_gram_.begin() + island.first, for_gram_.begin() + island.end, 0);
  }
  return for_gram_;
}

void Dependences::solve_negative(const double* b, double* x) {
  for (const Island& island : islands_) {
    if (!island.by_qr) continue;
    for (Index a = island.first; a < island.end; ++a) x[a] = -b[a];
    island.solver->solve(x + island.first);
  }
}

void Dependences::minimize_norm(double* lambda) const {
  for (const Island& island : islands_) {
    if (!island.solver->dependences().empty()) island.solver->minimize_norm(lambda + island.first);
  }
}

// ---- residuals ----

double Dependences::largest_active(const std::vector<double>& rows, const std::vector<double>& units) const {
  double largest = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    if (is_dependent(a)) continue;
    largest = larger(largest, std::abs(rows[a]) / (units[work_.scales.of_row(a)] * gradient_norm(a)));
  }
  return work_.team().largest(largest);
}

double Dependences::largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const {
  if (!is_found()) return 0.0;
  double largest = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    if (!is_dependent(a)) continue;
    largest = larger(largest, std::abs(rows[a]) / (units[work_.scales.of_row(a)] * gradient_norm(a)));
  }
  return work_.team().largest(largest);
}

Outcome Dependences::explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                           double allowed, Dimension dimension) const {
  constexpr double safety = 1e3;  // a bound by norms may be short by this factor
  double largest = 1.0;
  Outcome worst;
  for (const Island& island : islands_) {
    const RankSolver& solver = *island.solver;
    const auto first = static_cast<std::size_t>(island.first), size = static_cast<std::size_t>(island.end) - first;
    const double rounding = safety * eps / solver.singular_value_in_question();
    const auto contradictions = solver.contradictions(std::span(rows).subspan(first, size));
    for (std::size_t k = 0; k < contradictions.size(); ++k) {
      const auto& [column, excess, magnitude] = contradictions[k];
      const std::size_t row = first + static_cast<std::size_t>(column);
      const double terms = std::max(magnitude, gradient_norm(row) * sizes[work_.scales.of_row(row)]);
      const double explained = std::max(allowed, rounding) * terms;
      if (!(std::abs(excess) > largest * explained)) continue;
      largest = std::abs(excess) / explained;
      worst = {Status::Contradictory,
               describe(translate(island, solver.dependences()[k]), "contradicts") + " at t = " + text(t) + " (by " +
                   with_unit(text(std::abs(excess)), model_.system.units.letters(dimension)) + ")"};
    }
  }
  return worst;
}

// ---- reports ----

Dependence Dependences::translate(const Island& island, Dependence dependence) const {
  dependence.column += island.first;
  for (Dependence::Term& term : dependence.terms) term.column += island.first;
  return dependence;
}

/// Returns e.g. "rods[5] depends on rods[0], rods[3], …".
std::string Dependences::describe(const Dependence& found, const char* verb) const {
  constexpr std::size_t most_names = 6;
  std::string text = work_.name_row(static_cast<std::size_t>(found.column)) + " " + verb + " ";
  for (std::size_t k = 0; k < std::min(found.terms.size(), most_names); ++k)
    text += (k > 0 ? ", " : "") + work_.name_row(static_cast<std::size_t>(found.terms[k].column));
  return text + (found.terms.size() > most_names ? ", …" : "");
}

std::vector<Dependence> Dependences::list() const {
  std::vector<Dependence> result;
  for (const Island& island : islands_) {
    for (const Dependence& dependence : island.solver->dependences()) result.push_back(translate(island, dependence));
  }
  return result;
}

std::vector<RowDependence> Dependences::list_rows() const {
  const Numbering& numbering = model_.numbering;
  const auto is_contact = [&](int row) { return numbering.is_contact_row(static_cast<std::size_t>(row)); };
  const auto user_row = [&](auto row) {
    return static_cast<std::size_t>(numbering.user_row[static_cast<std::size_t>(row)]);
  };
  std::vector<RowDependence> result;
  for (const Dependence& found : list()) {
    // A sticking contact holds a point beside its constraints, which does not change their rank.
    if (is_contact(found.column) || std::ranges::any_of(found.terms, is_contact, &Dependence::Term::column)) continue;
    RowDependence& dependence = result.emplace_back();
    dependence.row = user_row(found.column);
    dependence.what = describe(found, "depends on");
    for (const auto& [row, coefficient] : found.terms) dependence.terms.push_back({user_row(row), coefficient});
  }
  for (std::size_t a = numbering.first_idle_row(); a < model_.num_rows(); ++a)
    result.push_back({user_row(a), {}, work_.name_row(a) + " joins supports alone"});
  return result;
}

RankReport Dependences::report() const {
  const Numbering& numbering = model_.numbering;
  RankReport report;
  report.dependences = list_rows();
  report.rank = numbering.num_user_rows - report.dependences.size() - work_.constraints.open.size();
  report.degrees_of_freedom = 3 * model_.num_moving() - report.rank;
  std::vector<bool> unique(model_.num_rows(), true);
  std::fill(unique.begin() + static_cast<std::ptrdiff_t>(numbering.first_idle_row()), unique.end(), false);
  if (!islands_.empty()) report.smallest_singular_value = 1.0;
  for (const Island& island : islands_) {
    const std::vector<bool> own = island.solver->unique();
    std::copy(own.begin(), own.end(), unique.begin() + island.first);
    const double smallest = island.solver->smallest_singular_value();
    report.smallest_singular_value = std::min(report.smallest_singular_value, smallest);
  }
  report.multipliers_unique.resize(unique.size());
  for (std::size_t a = 0; a < unique.size(); ++a)
    report.multipliers_unique[static_cast<std::size_t>(numbering.user_row[a])] = unique[a];
  report.multipliers_unique.resize(numbering.num_user_rows);
  return report;
}

}  // namespace tanor::detail
