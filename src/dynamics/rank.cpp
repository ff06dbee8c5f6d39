#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "dynamics/normal_form.hpp"

/// \file The rank of K in NormalForm: suspected by S, decided by QR, kept from place to place.
namespace tanor {

namespace {

constexpr double rounding = 1e-9;  // |K'w + phi| and |K'v + xi_t| over their terms; more is no rounding

/// On the way to xi = 0 and back, by how much K may differ from the one there, for each unit of violation.
constexpr double spread = 1e3;

}  // namespace

/// K as far as its rank is a question: contacts take no part.
std::vector<double> NormalForm::blocks_of_constraints() const {
  return has_switches() ? model_.without_contacts(blocks_) : blocks_;
}

/// Where S has no factor, or one that looks singular.
Outcome NormalForm::decide_rank(double t, const double* r) {
  if (Outcome outcome = check_gradients(t); !outcome.ok()) return outcome;
  const std::vector<double> tolerances = model_.rank_tolerances(r);
  ++model_.counters.rank_decisions;
  bool has_changed = false;
  const std::vector<double> K = blocks_of_constraints();
  for (const Redundancy::Rows& rows : general().weak_parts(suspect_below_)) {
    has_changed = redundancy_.decide(K.data(), rows, tolerances) || has_changed;
  }
  adopt_rank(has_changed);
  // Independent all the same: the next suspicion wants a better reason.
  suspect_below_ = std::clamp(0.1 * last_.reciprocal_condition, GramSolver::singular_below, suspect_below_);
  return {};
}

/// With the rows that depend now: S of the others, or their QR where S is singular to rounding.
void NormalForm::adopt_rank(bool has_changed) {
  if (has_changed) {
    gradient_norms_.assign(num_rows(), 0.0);
    for (const Incidence& incidence : model_.incidences) {
      const Vec3 g = load(blocks_.data(), incidence.block);
      gradient_norms_[static_cast<std::size_t>(incidence.row)] += dot(g, g);
    }
    // rows of contacts that slide have no gradient now, and a unit one when they stick
    for (double& norm : gradient_norms_) norm = norm > 0.0 ? std::sqrt(norm) : 1.0;
    model_.rank = model_.numbering.first_idle_row() - redundancy_.num_dependent();
    general().set_active(redundancy_.rows_for_gram());
    (void)factorize_gram();
  }
  if (is_of_schur_) return;
  for (const Redundancy::Rows& rows : general().weak_parts(GramSolver::singular_below)) redundancy_.take_qr(rows);
  if (redundancy_.uses_qr()) {
    const double reciprocal_condition = last_.reciprocal_condition;
    general().set_active(redundancy_.rows_for_gram());
    (void)factorize_gram();
    last_.reciprocal_condition = std::min(last_.reciprocal_condition, reciprocal_condition);
  }
  is_factorized_ = true;
}

/// Where a dependent row stays behind: did it become independent? Returns whether the dependent rows changed.
bool NormalForm::decide_rank_again(const double* r) {
  if (!redundancy_.is_found()) return false;
  ++model_.counters.rank_decisions;
  const bool has_changed = redundancy_.decide_again(blocks_of_constraints().data(), model_.rank_tolerances(r));
  if (has_changed) adopt_rank(true);
  return has_changed;
}

/// K'w + phi is not 0 in all rows. Off xi = 0 dependent rows may differ; else the rank changed, or the rows contradict
/// each other, or S is too poor.
Outcome NormalForm::reconsider_rank(double t, const double* r, double scale) {
  if (make_compliant()) {
    (void)factorize_gram();
    if (find_multipliers(scale) <= rounding) return {};
  }
  std::vector<double> xi(num_rows());
  const double violation = model_.constraints.evaluate_values(model_.parallel, r, xi.data());
  const double allowed = std::max(rounding, spread * violation);
  measure_accelerations(scale);
  const auto are_fine = [&] {
    return largest_active(rows_, accelerations_) <= rounding && largest_dependent(rows_, accelerations_) <= allowed;
  };
  if (are_fine()) return {};

  if (decide_rank_again(r)) {
    (void)find_multipliers(scale);
    if (are_fine()) return {};
  }
  if (redundancy_.is_found()) {
    if (Outcome outcome = explain_contradiction(t, right_side_, accelerations_, allowed, " m/s^2"); !outcome.ok())
      return outcome;
  }
  if (violation > rounding) return {};  // not where rank has a meaning: the step's error decides
  ++model_.counters.rank_decisions;
  for (const Redundancy::Rows& rows : general().weak_parts(1.0)) {
    const double unit = accelerations_[model_.scales.of_row(static_cast<std::size_t>(rows.first))];
    const auto is_poor = [&](double value) { return !(std::abs(value) <= rounding * unit); };
    if (std::none_of(rows_.begin() + rows.first, rows_.begin() + rows.second, is_poor)) continue;
    (void)redundancy_.decide(blocks_of_constraints().data(), rows, model_.rank_tolerances(r));
    if (!is_compliant()) redundancy_.take_qr(rows);
  }
  general().set_active(redundancy_.rows_for_gram());
  (void)factorize_gram();
  (void)find_multipliers(scale);
  return {};
}

// ---- rows ----

/// Largest |row|/|gradient|/unit of the rows that take part, with the unit of their neighbourhood …
double NormalForm::largest_active(const std::vector<double>& rows, const std::vector<double>& units) const {
  double largest = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    if (redundancy_.is_dependent(a)) continue;
    const double unit = units[model_.scales.of_row(a)] * (gradient_norms_.empty() ? 1.0 : gradient_norms_[a]);
    largest = larger(largest, std::abs(rows[a]) / unit);
  }
  return largest;
}

/// … and of those that depend on them.
double NormalForm::largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const {
  if (!redundancy_.is_found()) return 0.0;
  double largest = 0.0;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const double unit = units[model_.scales.of_row(a)] * gradient_norms_[a];
    if (redundancy_.is_dependent(a)) largest = larger(largest, std::abs(rows[a]) / unit);
  }
  return largest;
}

/// "rods[5] depends on rods[0], rods[3], …"
std::string NormalForm::describe(const Redundancy::Found& found, const char* verb) const {
  constexpr std::size_t most_names = 6;
  std::string text = name_row(static_cast<std::size_t>(found.row)) + " " + verb + " ";
  for (std::size_t k = 0; k < std::min(found.terms.size(), most_names); ++k) {
    text += (k > 0 ? ", " : "") + name_row(static_cast<std::size_t>(found.terms[k].first));
  }
  return text + (found.terms.size() > most_names ? ", …" : "");
}

/// `rows`: xi, K'v + xi_t or phi + K'w0, whose size for unit gradients is that of their neighbourhood.
Outcome NormalForm::explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                          double allowed, const char* unit) const {
  std::vector<double> scales = gradient_norms_;
  for (std::size_t a = 0; a < scales.size(); ++a) scales[a] *= sizes[model_.scales.of_row(a)];
  const auto contradiction = redundancy_.find_contradiction(rows, scales, allowed);
  if (!contradiction) return {};
  return {Status::Contradictory, describe(contradiction->found, "contradicts") + " at t = " + text(t) + " (by " +
                                     text(std::abs(contradiction->excess)) + unit + ")"};
}

// ---- outputs ----

void NormalForm::minimize_multipliers(const double* r, double* lambda) {
  if (!redundancy_.is_found()) return;
  // The null space turns with K.
  (void)decide_rank_again(r);
  redundancy_.minimize_norm(lambda);
}

RankReport NormalForm::find_rank(const double* r, bool thoroughly) {
  if (thoroughly && num_rows() > 0) {
    ++model_.counters.rank_decisions;
    const auto end = static_cast<Index>(model_.numbering.first_idle_row());
    if (redundancy_.decide(blocks_of_constraints().data(), {0, end}, model_.rank_tolerances(r))) adopt_rank(true);
  }
  const auto user_row = [&](std::size_t a) { return static_cast<std::size_t>(model_.numbering.user_row[a]); };
  RankReport report;
  std::vector<bool> unique(num_rows(), true);
  redundancy_.mark_unique(&unique);
  const std::size_t num_user_rows = model_.numbering.num_user_rows;
  for (const Redundancy::Found& found : redundancy_.list()) {
    // What sticks holds a point beside its constraints: that is no matter of their rank.
    const bool with_contacts = user_row(static_cast<std::size_t>(found.row)) >= num_user_rows ||
                               std::any_of(found.terms.begin(), found.terms.end(), [&](const auto& term) {
                                 return user_row(static_cast<std::size_t>(term.first)) >= num_user_rows;
                               });
    if (with_contacts) continue;
    RowDependence& dependence = report.dependences.emplace_back();
    dependence.row = user_row(static_cast<std::size_t>(found.row));
    dependence.what = describe(found, "depends on");
    for (const auto& [row, coefficient] : found.terms) {
      dependence.terms.push_back({user_row(static_cast<std::size_t>(row)), coefficient});
    }
  }
  for (std::size_t a = model_.numbering.first_idle_row(); a < num_rows(); ++a) {
    report.dependences.push_back({user_row(a), {}, name_row(a) + " joins supports alone"});
    unique[a] = false;
  }
  report.rank = num_user_rows - report.dependences.size();
  report.degrees_of_freedom = 3 * model_.num_moving() - report.rank;
  if (redundancy_.has_decided()) report.smallest_singular_value = redundancy_.smallest_singular_value();
  report.multipliers_unique.resize(num_rows());
  for (std::size_t a = 0; a < num_rows(); ++a) report.multipliers_unique[user_row(a)] = unique[a];
  report.multipliers_unique.resize(num_user_rows);
  return report;
}

void NormalForm::remember_gradients() {
  if (!redundancy_.is_found())
    before_.blocks = blocks_;
  else
    before_.blocks.clear();
}

/// With K_0 before and K_1 now, C = S_1^-1 K_1'M^-1 K_0 is 1 where nothing turns, and a singular value that went from
/// s_0 to s_1 is an eigenvalue s_0/s_1 of it: that of the largest one of 1 - C, found by power iteration.
double NormalForm::compare_gradients() {
  if (before_.blocks.empty()) return 1.0;
  if (redundancy_.is_found()) return 0.0;
  const Stopwatch watch(&model_.times.solve);
  constexpr int most_iterations = 10, least_iterations = 4;
  constexpr double hopeless = 0.7;
  model_.constraints.turn_frames(blocks_.data(), before_.blocks.data());
  std::vector<double>&x = before_.x, &y = before_.y, &move = before_.move;
  x.resize(num_rows());
  y.resize(num_rows());
  move.assign(size(), 0.0);
  for (std::size_t a = 0; a < x.size(); ++a) x[a] = std::sin(1.0 + 2.399963 * static_cast<double>(a));
  double eigenvalue = 0.0;  // of 1 - C
  for (int k = 0; k < most_iterations; ++k) {
    model_.gather.write_scaled(model_.parallel, before_.blocks.data(), x.data(), model_.inverse_mass.data(),
                               model_.num_moving(), move.data());
    model_.constraints.apply_transposed(model_.parallel, blocks_.data(), move.data(), nullptr, y.data());
    ++model_.counters.solves;
    solve_negative(y.data(), y.data());
    double along = 0.0, before = 0.0, after = 0.0;
    for (std::size_t a = 0; a < x.size(); ++a) {
      y[a] += x[a];
      along += x[a] * y[a];
      before += x[a] * x[a];
      after += y[a] * y[a];
    }
    eigenvalue = along / before;
    if (!(after > 0.0) || (k >= least_iterations && after < hopeless * hopeless * before)) break;
    for (std::size_t a = 0; a < x.size(); ++a) x[a] = y[a] / std::sqrt(after);
  }
  return 1.0 / (1.0 - eigenvalue);
}

}  // namespace tanor
