#include "dynamics/gradient_rank.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"
#include "base/stopwatch.hpp"

namespace tanor::detail {

/// Returns true if contacts take part in a dependence. A sticking contact holds a point beside its constraints, which
/// does not change their rank.
bool GradientRank::depends_on_contacts(const Redundancy::Found& found) const {
  const auto is_contact = [&](Index row) { return model_.numbering.is_contact_row(static_cast<std::size_t>(row)); };
  return is_contact(found.row) ||
         std::any_of(found.terms.begin(), found.terms.end(), [&](const auto& term) { return is_contact(term.first); });
}

std::size_t GradientRank::user_row(std::size_t row) const {
  return static_cast<std::size_t>(model_.numbering.user_row[row]);
}

std::vector<RowDependence> GradientRank::list_dependences() const {
  return list_dependences(linearization_.dependences());
}

std::vector<RowDependence> GradientRank::list_dependences(const Redundancy& redundancy) const {
  std::vector<RowDependence> result;
  for (const Redundancy::Found& found : redundancy.list()) {
    if (depends_on_contacts(found)) continue;
    RowDependence& dependence = result.emplace_back();
    dependence.row = user_row(static_cast<std::size_t>(found.row));
    dependence.what = linearization_.dependences().describe(found, "depends on");
    for (const auto& [row, coefficient] : found.terms) {
      dependence.terms.push_back({user_row(static_cast<std::size_t>(row)), coefficient});
    }
  }
  for (std::size_t a = model_.numbering.first_idle_row(); a < model_.num_rows(); ++a)
    result.push_back({user_row(a), {}, work_.name_row(a) + " joins supports alone"});
  return result;
}

RankReport GradientRank::report(const double* r, bool thoroughly) {
  if (thoroughly && model_.num_rows() > 0) (void)linearization_.decide_rank_again(r, RankScope::AllRows);
  return describe(linearization_.dependences());
}

RankReport GradientRank::describe(const Redundancy& redundancy) const {
  const std::size_t num_rows = model_.num_rows(), num_user_rows = model_.numbering.num_user_rows;
  RankReport report;
  report.dependences = list_dependences(redundancy);
  std::vector<bool> unique(num_rows, true);
  redundancy.mark_unique(&unique);
  std::fill(unique.begin() + static_cast<std::ptrdiff_t>(model_.numbering.first_idle_row()), unique.end(), false);
  report.rank = num_user_rows - report.dependences.size();
  report.degrees_of_freedom = 3 * model_.num_moving() - report.rank;
  if (redundancy.has_decided()) report.smallest_singular_value = redundancy.smallest_singular_value();
  report.multipliers_unique.resize(num_rows);
  for (std::size_t a = 0; a < num_rows; ++a) report.multipliers_unique[user_row(a)] = unique[a];
  report.multipliers_unique.resize(num_user_rows);
  return report;
}

void GradientRank::remember_gradients() {
  if (work_.team().is_alone() && !linearization_.dependences().is_found())
    before_ = linearization_.blocks();
  else
    before_.clear();
}

/// With K_0 before and K_1 now, C = S_1^-1 K_1'M^-1 K_0 is the identity if nothing turns. A singular value that went
/// from s_0 to s_1 is an eigenvalue s_0/s_1 of C. The largest eigenvalue of 1 - C is found by power iteration.
double GradientRank::compare_gradients() {
  if (before_.empty()) return 1.0;
  if (linearization_.dependences().is_found() || linearization_.shares_loads()) return 0.0;
  const Stopwatch watch(&work_.times.solve);
  constexpr int most_iterations = 10, least_iterations = 4;
  constexpr double hopeless = 0.7;
  work_.constraints.turn_frames(linearization_.blocks().data(), before_.data());
  x_.resize(model_.num_rows());
  y_.resize(model_.num_rows());
  move_.assign(3 * model_.num_points(), 0.0);
  // Rows without a gradient (of contacts that slide, of supports alone) do not turn. C is 0 there, and their eigenvalue
  // 1 of 1 - C would hide the others.
  std::fill(x_.begin(), x_.end(), 0.0);
  for (const Incidence& incidence : model_.incidences) {
    const bool moves = model_.inverse_mass[static_cast<std::size_t>(incidence.point)] > 0.0;
    const auto a = static_cast<std::size_t>(incidence.row);
    if (moves && x_[a] == 0.0 && norm(load(before_.data(), incidence.block)) > 0.0) x_[a] = irregular(a);
  }
  double eigenvalue = 0.0;  // of 1 - C
  for (int k = 0; k < most_iterations; ++k) {
    model_.gather.write_scaled(model_.parallel, before_.data(), x_.data(), model_.inverse_mass.data(),
                               model_.num_moving(), move_.data());
    linearization_.apply_transposed(move_.data(), nullptr, y_.data());
    ++work_.counters.solves;
    linearization_.solve_negative(y_.data(), y_.data());
    double along = 0.0, before = 0.0, after = 0.0;
    for (std::size_t a = 0; a < x_.size(); ++a) {
      y_[a] += x_[a];
      along += x_[a] * y_[a];
      before += x_[a] * x_[a];
      after += y_[a] * y_[a];
    }
    eigenvalue = along / before;
    if (!(after > 0.0) || (k >= least_iterations && after < hopeless * hopeless * before)) break;
    for (std::size_t a = 0; a < x_.size(); ++a) x_[a] = y_[a] / std::sqrt(after);
  }
  return 1.0 / (1.0 - eigenvalue);
}

}  // namespace tanor::detail
