#include "ranks/cut_form.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"
#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "schur/refinement.hpp"

namespace tanor::detail {

CutForm::CutForm(Workspace& work, const SolverOptions& options, const Part& part)
    : PointForm(work),
      part_(part),
      linearization_(work, part, options.ordering),
      agreement_(linearization_.agreement()),
      depends_on_time_(agreement_.any(model_.is_rheonomic() || work.forces.depend_on_time())),
      projector_(work, linearization_),
      energies_(work, part, agreement_),
      neighbourhoods_(work, part),
      rank_(agreement_.largest(model_.mass_ratio)),
      lambda_(model_.num_rows()),
      b_(model_.num_rows()),
      rows_(model_.num_rows()),
      dw_(3 * model_.num_points()) {
  for (const Part::SharedRow& shared : part.shared_rows) work_.rank -= shared.is_counted ? 0 : 1;
  for (const Part::SharedPairs& pairs : part.shared_pairs)
    work_.forces.add_pairs_beyond(std::make_unique<HaloPairs>(model_, pairs, *part.ranks));
}

Roles CutForm::roles() {
  Roles roles = common_roles();
  roles.step_projector = &projector_;
  if (part_.may_lose_rank) roles.rank_monitor = &rank_;
  return roles;
}

SeriesExpansion* CutForm::series(std::string* why_not) {
  if (series_ == nullptr) series_ = std::make_unique<CutSeries>(work_, linearization_, energies_, neighbourhoods_);
  if (why_not != nullptr) *why_not = series_->obstacle();
  return series_->obstacle().empty() ? series_.get() : nullptr;
}

/// Goes to t with all that may end there, since other calls are collective.
void CutForm::prescribe(double t, double* r, double* v) {
  PointForm::prescribe(t, r, v);
  work_.set_time(t);
  work_.forces.set_time(t);
}

// ---- accelerations ----

/// Refines with rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho.
int CutForm::refine(const double* b, double scale, bool is_exact, double* residual) {
  return refine_solution(
      RefinementLimits{5},
      [&] {
        const double largest = agreement_.largest(work_.constraints.apply_transposed(
            model_.parallel, linearization_.blocks().data(), dw_.data(), b, rows_.data()));
        return *residual = largest / (scale > 0.0 ? scale : 1.0);
      },
      [&](double left) { return left <= good_enough(is_exact); },
      [&](int) {
        linearization_.correct(rows_.data(), dw_.data());
        for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
      });
}

/// Solves S lambda = -b, dw = M^-1 K lambda. Rows that depended on others at the last decision may be independent here,
/// or contradict the others.
Outcome CutForm::solve(const Kinematics& at, const Request& request, double scale, SolveReport* report) {
  constexpr double contradiction = 1e-9;
  const Stopwatch watch(&work_.times.solve);
  const auto find_multipliers = [&] {
    linearization_.solve(b_.data(), lambda_.data(), dw_.data());
    report->refinements = refine(b_.data(), scale, model_.is_exact_for(request), &report->residual);
    return report->residual <= contradiction;
  };
  const bool is_fine = find_multipliers();
  if (!std::isfinite(report->residual)) return model_.not_finite(at.t);
  if (is_fine || !linearization_.rank().is_found()) return {};
  if (linearization_.decide_rank_again(at.t, at.x) && find_multipliers()) return {};
  return {Status::Contradictory, linearization_.rank().explain("contradicts") + " at t = " + text(at.t)};
}

void CutForm::minimize_multipliers(const Kinematics& at, double* lambda) {
  (void)linearization_.decide_rank_again(at.t, at.x);
  linearization_.rank().minimize_norm(lambda);
}

Outcome CutForm::accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) {
  work_.set_time(at.t);
  ++work_.counters.evaluations;
  const bool is_new = request.gradients == Gradients::Evaluate && linearization_.needs_factor();
  double* const w = to.a;
  double scale = 0.0;
  {
    const Stopwatch watch(&work_.times.evaluate);
    if (is_new) work_.constraints.choose_frames();
    scale = projector_.evaluate_free(at, w);
    scale = larger(scale, work_.constraints.evaluate_right_side(model_.parallel, at.x, at.v, w, b_.data(),
                                                                is_new ? linearization_.blocks().data() : nullptr));
  }
  scale = agreement_.largest(scale);
  if (!std::isfinite(scale)) return model_.not_finite(at.t);
  if (is_new) {
    if (Outcome outcome = linearization_.factorize(at.t, at.x); !outcome.ok()) return outcome;
  }
  SolveReport report;
  if (Outcome outcome = solve(at, request, scale, &report); !outcome.ok()) return outcome;
  for (std::size_t i = 0; i < dw_.size(); ++i) w[i] += dw_[i];
  report.reciprocal_condition = linearization_.reciprocal_condition();
  if (to.report != nullptr) *to.report = report;
  if (to.power != nullptr) *to.power = energies_.power(at, energies_.power_of_reactions(dw_.data(), at.v));
  if (to.reactions != nullptr) {
    to.reactions->lambda = lambda_;
    to.reactions->refinements = report.refinements;
  }
  return {};
}

/// Errors of guests count on the ranks that own them.
ErrorRatios CutForm::error_ratios(double, const StepErrors& errors, double atol, double rtol) {
  const auto take = [&](const double* from, std::vector<double>* own) {
    own->assign(from, from + size());
    energies_.clear_guests(own->data());
    return own->data();
  };
  StepErrors own = errors;
  own.x = take(errors.x, &own_x_);
  own.v = take(errors.v, &own_v_);
  return work_.error_ratios(own, atol, rtol);
}

// ---- the start, and what is told ----

/// Throws InputError if the given start violates constraints by more than is corrected.
void CutForm::check_start(const double* r, const double* v) {
  constexpr double allowed = 1e-3;
  const auto complain = [&](const char* what, std::vector<double>& violations) -> Outcome {
    const auto worst = std::max_element(violations.begin(), violations.end());
    if (worst == violations.end() || *worst <= allowed) return {};
    throw InputError("/motion/start", std::string("the initial ") + what + " violate " +
                                          work_.name_row(static_cast<std::size_t>(worst - violations.begin())) +
                                          " by " + text(*worst) +
                                          " of its length or of the velocity scale; at most 0.001 is corrected");
  };
  std::vector<double> position(model_.num_rows()), velocity(model_.num_rows());
  work_.constraints.measure(r, v, position.data(), velocity.data());
  for (std::size_t a = 0; a < velocity.size(); ++a) velocity[a] /= work_.scales.speed(work_.scales.of_row(a));
  (void)agreement_.together([&] { return complain("positions", position); });
  (void)agreement_.together([&] { return complain("velocities", velocity); });
}

/// Refuses systems with prestress. Dependent rows may hold what K alone lets move, such as the inner points of a
/// straight row of rods between two supports. Some velocity that K allows then asks for accelerations that no
/// multipliers give.
Outcome CutForm::refuse_prestress(const Kinematics& at) {
  std::vector<double> u(at.v, at.v + size()), w(size());
  for (std::size_t k = 0; k < 3 * model_.num_moving(); ++k) u[k] += work_.velocity_scale * irregular(k);
  linearization_.guests().fetch(u.data());
  if (ProjectionReport report = project_velocities(at.t, at.x, u.data()); !report.outcome.ok()) return report.outcome;
  Request request;
  request.gradients = Gradients::Keep;
  Outcome outcome = accelerations({at.t, at.x, u.data()}, request, AccelerationOutput(w.data()));
  if (outcome.status != Status::Contradictory) return outcome;
  return {Status::Singular, linearization_.rank().explain("depends on") + " at t = " + text(at.t) +
                                ", and prestress holds what they let move; take one rank"};
}

StartReport CutForm::start(double t, double* r, double* v, StartMode mode) {
  work_.set_time(t);
  work_.prescribe_all(t, r, v);
  fetch_guests(r, v);
  work_.measure_velocity_scale(t, r, v);
  neighbourhoods_.share_speeds(agreement_);
  projector_.set_least_speed(agreement_.smallest(work_.scales.least_speed()));
  if (mode == StartMode::Check) check_start(r, v);
  StartReport report;
  const std::vector<double> r_given(r, r + size()), v_given(v, v + size());
  report.outcome = linearise(t, r);
  if (report.outcome.ok()) report.outcome = project_positions(t, r, Turn::Small).outcome;
  if (report.outcome.ok()) report.outcome = linearise(t, r);
  if (report.outcome.ok()) report.outcome = project_velocities(t, r, v).outcome;
  if (!report.outcome.ok()) return report;
  if (linearization_.rank().is_found()) report.outcome = refuse_prestress({t, r, v});
  report.position_correction = model_.largest_move(r, r_given.data());
  report.velocity_correction = model_.largest_move(v, v_given.data());
  report.relative = std::max(work_.largest_move(r, r_given.data(), work_.scales.lengths()),
                             work_.largest_move(v, v_given.data(), work_.scales.speeds()));
  return report;
}

ProjectionReport CutForm::project_point_positions(double t, double* r) {
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome)};
  return project_positions(t, r, Turn::Small);
}

ProjectionReport CutForm::project_point_velocities(double t, const double* r, double* v) {
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome)};
  return project_velocities(t, r, v);
}

Outcome CutForm::begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) {
  return accelerations({t, r, v}, request.evaluated_anew(), to);
}

void CutForm::resume(const Counters& counters, const PhaseTimes& times) {
  work_.counters = counters;
  work_.times = times;
}

void CutForm::fetch_guests(double* r, double* v) {
  linearization_.guests().fetch(r);
  if (v != nullptr) linearization_.guests().fetch(v);
}

void CutForm::exchange_memory(Memory& memory) {
  work_.exchange_memory(memory);
  memory.exchange(lambda_);
  projector_.exchange_memory(memory);
}

Reactions CutForm::no_reactions() const {
  Reactions none;
  none.lambda.resize(model_.num_rows());
  return none;
}

void CutForm::write_reactions(const Kinematics&, const Reactions& found, double* eta) {
  model_.gather.reactions(model_.parallel, linearization_.blocks().data(), found.lambda.data(), eta);
}

void CutForm::write_friction(const Reactions&, double* tau) const {
  std::fill(tau, tau + size(), 0.0);
}

void CutForm::describe(PlanSummary* plan) const {
  linearization_.describe(plan);
}

}  // namespace tanor::detail
