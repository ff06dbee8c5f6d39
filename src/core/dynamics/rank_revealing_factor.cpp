#include "dynamics/rank_revealing_factor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

// This is far above `GramSolver::singular_below`, since the estimate of 1/cond(S) is an upper bound.
constexpr double first_suspicion = 1e-11;
// S is singular where a load is known to be shared, so that also larger estimates are rounding.
constexpr double hidden_by_rounding = 1e-8;

}  // namespace

RankRevealingFactor::RankRevealingFactor(Workspace& work, const SolverOptions& options,
                                         const std::vector<double>& blocks, Contacts* contacts)
    : work_(work),
      model_(work.model()),
      blocks_(blocks),
      ordering_(options.ordering),
      solver_(options.linear_solver == LinearSolver::Cholmod ? LinearSolver::Cholmod : LinearSolver::General),
      contacts_(contacts),
      dependences_(work),
      suspect_below_(first_suspicion) {
  if (model_.numbering.has_rows_that_go()) (void)gram();  // they leave no islands to other solvers
}

std::unique_ptr<RankRevealingFactor> Team::make_factor(Workspace& work, const SolverOptions& options,
                                                       const std::vector<double>& blocks, Contacts* contacts) {
  return std::make_unique<RankRevealingFactor>(work, options, blocks, contacts);
}

GramSolver& RankRevealingFactor::gram() {
  if (gram_ == nullptr) {
    gram_ = std::make_unique<GramSolver>(model_.incidences, model_.inverse_mass, model_.numbering, ordering_,
                                         work_.constraints.squared_gradient_norms(), model_.places(), solver_);
    gram_->allow_zero_rows(model_.numbering);
  }
  return *gram_;
}

// ---- the factor ----

GramSolver::Quality RankRevealingFactor::factorize_rows() {
  const GramSolver::Quality quality = work_.factorize(&gram(), blocks_.data());
  reciprocal_condition_ = quality.reciprocal_condition;
  return quality;
}

Outcome RankRevealingFactor::factorize(double t, const double* r) {
  if (dependences_.uses_qr()) {
    dependences_.release_qr();
    gram().set_active(dependences_.rows_for_gram());
  }
  GramSolver::Quality quality = factorize_rows();
  const auto is_fine = [&] { return quality.positive_definite && quality.reciprocal_condition > suspect_below_; };
  const bool is_hidden =
      quality.reciprocal_condition < hidden_by_rounding && contacts_ != nullptr && contacts_->have_references();
  if ((!is_fine() || is_hidden) && share_loads()) quality = factorize_rows();
  if (!is_fine()) {
    if (Outcome outcome = decide_rank(t, r); !outcome.ok()) return outcome;
  }
  // If rows of contacts came or went, dependent rows may have become independent.
  const bool have_opened =
      std::exchange(openings_, work_.constraints.open.num_changes()) != work_.constraints.open.num_changes();
  if (work_.constraints.tangents().forget_switches() || have_opened)
    (void)decide_rank_again(r, RankScope::DependentIslands);
  return {};
}

void RankRevealingFactor::solve_negative(const Parallel& parallel, const double* b, double* x) {
  if (!dependences_.uses_qr()) return gram().solve_negative(parallel, b, x);
  right_side_of_qr_.assign(b, b + model_.num_rows());
  gram().solve_negative(parallel, b, x);
  dependences_.solve_negative(right_side_of_qr_.data(), x);
}

void RankRevealingFactor::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  solve_negative(parallel, rows, rows);
  add_reactions(parallel, blocks, rows, points);
}

void RankRevealingFactor::add_reactions(const Parallel& parallel, const double* blocks, const double* rows,
                                        double* points) {
  model_.gather.add_scaled(parallel, blocks, rows, model_.inverse_mass.data(), model_.num_moving(), points);
  work_.team().fetch_guests(points);
}

// ---- the rank of K ----

/// Returns K with zero rows for contacts, which take no part in decisions on the rank.
std::vector<double> RankRevealingFactor::blocks_of_constraints() const {
  return model_.numbering.has_contact_rows() ? work_.without_contacts(blocks_) : blocks_;
}

/// Decides the rank where S has no factor, or one that looks singular.
Outcome RankRevealingFactor::decide_rank(double t, const double* r) {
  if (Outcome outcome = check_gradients(t); !outcome.ok()) return outcome;
  const std::vector<double> tolerances = work_.rank_tolerances(r);
  ++work_.counters.rank_decisions;
  bool has_changed = false;
  const std::vector<double> K = blocks_of_constraints();
  for (const Dependences::Rows& rows : gram().weak_parts(suspect_below_)) {
    has_changed = dependences_.decide(K.data(), rows, tolerances) || has_changed;
  }
  leave_out_dependent_rows(has_changed);
  // If all rows were independent nevertheless, the next suspicion needs a smaller estimate.
  suspect_below_ = std::clamp(0.1 * reciprocal_condition_, GramSolver::singular_below, suspect_below_);
  return {};
}

/// Factorizes S of the independent rows, or replaces it by their QR where it is singular to rounding.
void RankRevealingFactor::leave_out_dependent_rows(bool has_changed) {
  if (has_changed) {
    dependences_.note_change(blocks_);
    work_.rank = model_.numbering.first_idle_row() - dependences_.num_dependent();
    gram().set_active(dependences_.rows_for_gram());
    factorize_again();
  }
  for (const Dependences::Rows& rows : gram().weak_parts(GramSolver::singular_below)) dependences_.take_qr(rows);
  if (dependences_.uses_qr()) {
    const double before = reciprocal_condition_;
    gram().set_active(dependences_.rows_for_gram());
    factorize_again();
    reciprocal_condition_ = std::min(reciprocal_condition_, before);
  }
}

bool RankRevealingFactor::decide_rank_again(const double* r, RankScope scope) {
  const bool is_whole = scope == RankScope::AllRows;
  if (is_whole ? model_.num_rows() == 0 : !dependences_.is_found()) return false;
  ++work_.counters.rank_decisions;
  const std::vector<double> K = blocks_of_constraints(), tolerances = work_.rank_tolerances(r);
  const Dependences::Rows all{0, static_cast<Index>(model_.numbering.first_idle_row())};
  const bool has_changed =
      is_whole ? dependences_.decide(K.data(), all, tolerances) : dependences_.decide_again(K.data(), tolerances);
  if (has_changed) leave_out_dependent_rows(true);
  return has_changed;
}

void RankRevealingFactor::decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                                    const std::vector<double>& accelerations, double allowed) {
  ++work_.counters.rank_decisions;
  for (const Dependences::Rows& part : gram().weak_parts(1.0)) {
    const double unit = accelerations[work_.scales.of_row(static_cast<std::size_t>(part.first))];
    const auto is_poor = [&](double value) { return !(std::abs(value) <= allowed * unit); };
    if (std::none_of(rows.begin() + part.first, rows.begin() + part.second, is_poor)) continue;
    (void)dependences_.decide(blocks_of_constraints().data(), part, work_.rank_tolerances(r));
    if (!contacts_share_loads()) dependences_.take_qr(part);
  }
  gram().set_active(dependences_.rows_for_gram());
  factorize_again();
}

/// Rejects a gradient that does not exist or vanishes. Such a row is no combination of others, but has no direction
/// here.
Outcome RankRevealingFactor::check_gradients(double t) const {
  const std::size_t num_rows = model_.num_rows();
  std::vector<double> largest(num_rows, 0.0);  // over the moving points of a row
  for (const Incidence& incidence : model_.incidences) {
    const double length = norm(load(blocks_.data(), incidence.block));
    const auto row = static_cast<std::size_t>(incidence.row);
    if (!std::isfinite(length)) {
      return {Status::Singular, "the gradient of " + work_.name_row(row) + " does not exist at t = " + text(t) +
                                    ": a point lies where it is measured from"};
    }
    if (model_.inverse_mass[static_cast<std::size_t>(incidence.point)] > 0.0)
      largest[row] = std::max(largest[row], length);
  }
  for (std::size_t a = 0; a < model_.numbering.first_idle_row(); ++a) {
    // A row that is open, and a contact that slides, have no gradient and need none.
    if (model_.numbering.is_contact_row(a) || work_.constraints.open.have(a)) continue;
    if (largest[a] * work_.scales.length(work_.scales.of_row(a)) < 1e-12)
      return {Status::Singular, "the gradient of " + work_.name_row(a) + " vanishes at t = " + text(t)};
  }
  return {};
}

}  // namespace tanor::detail
