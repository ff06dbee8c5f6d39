#include "ranks/cut_form.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/numbers.hpp"
#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "schur/refinement.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor {

CutForm::CutForm(Workspace& work, const SolverOptions& options, const Part& part)
    : PointForm(work),
      agreement_(*part.ranks),
      guests_(part, work.model().numbering),
      part_(part),
      solver_(work.model(), part, options.ordering),
      blocks_(3 * work.constraints.num_blocks()),
      has_constant_gradients_(agreement_.all(work.constraints.gradients_are_constant())),
      is_rheonomic_(agreement_.any(model_.is_rheonomic())),
      mass_ratio_(agreement_.largest(model_.mass_ratio)),
      lambda_(model_.num_rows()),
      b_(model_.num_rows()),
      rows_(model_.num_rows()),
      right_side_(model_.num_rows()),
      dw_(3 * model_.num_points()),
      move_(3 * model_.num_points()) {
  measure_neighbourhoods();
  if (!part.energies_counted_elsewhere.empty()) {
    System others = model_.system;
    others.forces.clear();
    for (const std::size_t f : part.energies_counted_elsewhere) others.forces.push_back(model_.system.forces[f]);
    counted_elsewhere_ = std::make_unique<Forces>(others, model_.numbering);
  }
  for (const Part::SharedRow& shared : part.shared_rows) work_.rank -= shared.is_counted ? 0 : 1;
}

// ---- scales ----

/// Neighbourhoods that lie on several ranks have the length of all their points together.
void CutForm::measure_neighbourhoods() {
  constexpr double far = -std::numeric_limits<double>::max();
  std::vector<double> ends(6 * part_.num_shared_neighbourhoods, far);  // the largest of r and of -r
  const System& system = model_.system;
  const auto include = [&](Index neighbourhood, std::size_t point) {
    double* const own = ends.data() + 6 * static_cast<std::size_t>(neighbourhood);
    for (std::size_t c = 0; c < 3; ++c) {
      own[c] = std::max(own[c], system.positions[3 * point + c]);
      own[3 + c] = std::max(own[3 + c], -system.positions[3 * point + c]);
    }
  };
  for (std::size_t i = 0; i < system.num_points(); ++i)
    if (shared_of(static_cast<Index>(i)) >= 0) include(shared_of(static_cast<Index>(i)), i);
  // Supports belong to none, but hold those that do.
  for_each_member(system, [&](std::span<const Index> points, int) {
    const auto shared = std::ranges::max(points, {}, [&](Index point) { return shared_of(point); });
    for (const Index point : points)
      if (shared_of(shared) >= 0) include(shared_of(shared), static_cast<std::size_t>(point));
  });
  part_.ranks->find_largest(ends);
  Neighbourhoods all = find_neighbourhoods(system, work_.time());
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    const Index own = shared_of(static_cast<Index>(i));
    if (own < 0 || all.of_point[i] < 0) continue;
    const double* const box = ends.data() + 6 * static_cast<std::size_t>(own);
    all.length[static_cast<std::size_t>(all.of_point[i])] =
        norm(Vec3{box[0] + box[3], box[1] + box[4], box[2] + box[5]});
  }
  work_.scales = Scales(all, model_.numbering, model_.incidences, model_.scene_size);
}

/// Likewise the largest of their speeds; the scene's is the largest of all.
void CutForm::share_speeds() {
  std::vector<double> speeds(part_.num_shared_neighbourhoods + 1, 0.0), own = work_.scales.speeds();
  speeds.back() = work_.velocity_scale;
  const auto for_shared = [&](const auto& visit) {
    for (std::size_t i = 0; i < model_.num_moving(); ++i) {
      const Index shared = part_.shared_neighbourhood[static_cast<std::size_t>(model_.numbering.user_point[i])];
      if (shared >= 0) visit(speeds[static_cast<std::size_t>(shared)], own[work_.scales.of_point(i)]);
    }
  };
  for_shared([](double& all, double here) { all = std::max(all, here); });
  part_.ranks->find_largest(speeds);
  for_shared([](double all, double& here) { here = all; });
  own.back() = work_.velocity_scale = speeds.back();
  work_.scales.set_speeds(own);
  least_speed_ = agreement_.smallest(work_.scales.least_speed());
}

// ---- the configuration ----

Outcome CutForm::linearise(double t, const double* r) {
  work_.set_time(t);
  if (has_factor_ && has_constant_gradients_) return {};
  work_.constraints.choose_frames();
  {
    const Stopwatch watch(&work_.times.evaluate);
    work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  }
  return factorize(t);
}

Outcome CutForm::factorize(double t) {
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.factorizations;
  const CutSolver::Quality quality = solver_.factorize(blocks_.data());
  reciprocal_condition_ = quality.reciprocal_condition;
  // Nobody decides ranks here. S of rows that depend leaves pivots of some roundings.
  constexpr double poor = 1e-12;
  const bool is_singular = quality.reciprocal_condition <= poor;
  Outcome outcome;
  if (!quality.own_is_definite || (quality.shared_is_definite && is_singular)) {
    outcome = {Status::Singular, work_.name_row(quality.weakest_row) + " depends on other constraints at t = " +
                                     text(t) + "; islands that lie on several ranks must not have such"};
  } else if (!quality.shared_is_definite) {
    outcome = {Status::Singular, "constraints between ranks depend on others at t = " + text(t) +
                                     "; islands that lie on several ranks must not have such"};
  }
  outcome = agreement_.agree(std::move(outcome));
  has_factor_ = outcome.ok();
  return outcome;
}

// ---- accelerations ----

/// w0 = M^-1 f, of guests as well; returns the largest of all ranks.
double CutForm::evaluate_free(const Kinematics& at, double* w) {
  const double largest = work_.evaluate_free(at.t, at.x, at.v, w);
  guests_.fetch(w);
  return largest;
}

/// x = -S^-1 b, dw = M^-1 K x; the two may share nothing with b but x itself.
void CutForm::solve(const double* b, double* x, double* dw) {
  ++work_.counters.solves;
  std::fill(x + model_.numbering.first_idle_row(), x + model_.num_rows(), 0.0);
  solver_.solve_negative(b, x);
  std::fill(dw + 3 * model_.num_moving(), dw + 3 * model_.num_points(), 0.0);
  model_.gather.write_scaled(model_.parallel, blocks_.data(), x, model_.inverse_mass.data(), model_.num_moving(), dw);
  guests_.fetch(dw);
}

/// rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho
int CutForm::refine(const double* b, double scale, double good_enough, double* residual) {
  return refine_solution(
      RefinementLimits{5},
      [&] {
        const double largest = agreement_.largest(
            work_.constraints.apply_transposed(model_.parallel, blocks_.data(), dw_.data(), b, rows_.data()));
        return *residual = largest / (scale > 0.0 ? scale : 1.0);
      },
      [&](double left) { return left <= good_enough; },
      [&](int) {
        correct(dw_.data());
        for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
      });
}

void CutForm::correct(double* points) {
  right_side_.swap(rows_);
  solve(right_side_.data(), rows_.data(), move_.data());
  for (std::size_t i = 0; i < move_.size(); ++i) points[i] += move_[i];
}

Outcome CutForm::accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) {
  work_.set_time(at.t);
  ++work_.counters.evaluations;
  const bool is_new = request.gradients == Gradients::Evaluate && !(has_factor_ && has_constant_gradients_);
  double* const w = to.a;
  double scale = 0.0;
  {
    const Stopwatch watch(&work_.times.evaluate);
    if (is_new) work_.constraints.choose_frames();
    scale = evaluate_free(at, w);
    scale = larger(scale, work_.constraints.evaluate_right_side(model_.parallel, at.x, at.v, w, b_.data(),
                                                                is_new ? blocks_.data() : nullptr));
  }
  scale = agreement_.largest(scale);
  if (!std::isfinite(scale)) return model_.not_finite(at.t);
  if (is_new) {
    if (Outcome outcome = factorize(at.t); !outcome.ok()) return outcome;
  }
  SolveReport report;
  {
    const Stopwatch watch(&work_.times.solve);
    solve(b_.data(), lambda_.data(), dw_.data());
    report.refinements = refine(b_.data(), scale, request.exact ? 1e-15 : 1e-12, &report.residual);
  }
  if (!std::isfinite(report.residual)) return model_.not_finite(at.t);
  for (std::size_t i = 0; i < dw_.size(); ++i) w[i] += dw_[i];
  report.reciprocal_condition = reciprocal_condition_;
  if (to.report != nullptr) *to.report = report;
  if (to.power != nullptr) *to.power = find_power(at);
  if (to.reactions != nullptr) {
    to.reactions->lambda = lambda_;
    to.reactions->refinements = report.refinements;
  }
  return {};
}

/// Of this rank's own points: reactions carry what supports do from rank to rank, also to ranks without any that move,
/// and so do forces; what these do to guests is no work of a support.
Power CutForm::find_power(const Kinematics& at) {
  Power result;
  if (is_rheonomic_) {
    std::vector<double> v(at.v, at.v + size());
    clear_guests(v.data());
    result.supports = work_.forces.elastic_power_of_supports(model_.parallel, at.x, v.data()) +
                      model_.parallel.sum(model_.num_moving(), [&](std::size_t i) {
                        return model_.mass[i] * dot(load(dw_.data(), i), load(at.v, i));
                      });
  }
  if (work_.forces.has_work()) {
    result.forces = work_.forces.power(model_.parallel, at.x, at.v);
    result.potentials = work_.forces.energies().explicit_rate(model_.parallel);
  }
  if (counted_elsewhere_ && counted_elsewhere_->has_work()) {
    counted_elsewhere_->evaluate_powers(model_.parallel, at.t, at.x, at.v);
    result.potentials -= counted_elsewhere_->energies().explicit_rate(model_.parallel);
  }
  return result;
}

Energy CutForm::energy(double t, const double* r, const double* v) {
  Energy result = work_.energy(t, r, v);
  if (counted_elsewhere_) result.potential -= counted_elsewhere_->potential(model_.parallel, t, r);
  return result;
}

void CutForm::clear_guests(double* points) const {
  for (const Index guest : part_.guests)
    store(points, model_.numbering.inner_point[static_cast<std::size_t>(guest)], Vec3{});
}

Outcome CutForm::free_accelerations(const Kinematics& at, const Request&, double* a) {
  const double largest = agreement_.largest(evaluate_free(at, a));
  return std::isfinite(largest) ? Outcome{} : model_.not_finite(at.t);
}

// ---- projections ----

ProjectionReport CutForm::project_positions(double t, double* r, Turn) {
  return iterate_positions(t, r, nullptr);
}

/// Chord iterations; where they stall, one linearisation anew. `sum` [d], the multipliers' sum of a step, keeps to the
/// K that stands.
ProjectionReport CutForm::iterate_positions(double t, double* r, double* sum) {
  constexpr double target = 1e-13, largest_left = 1e-12;
  constexpr int most_iterations = 100;
  work_.set_time(t);
  ProjectionReport report;
  double before = std::numeric_limits<double>::infinity();
  bool linearised_here = false;
  for (;; ++report.iterations) {
    report.violation = evaluate_values(r);
    if (!std::isfinite(report.violation)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    if (report.violation <= target) return report;
    const bool stalls = report.violation > 0.3 * before, stands = report.violation > 0.99 * before;
    if (stalls) {
      const double own = 4.0 * eps * std::max(1.0, model_.largest_norm(r) / model_.smallest_length);
      const double rounding = agreement_.largest(own);
      if (report.violation <= std::max(target, rounding)) return report;
      const bool is_hopeless = stands && (linearised_here || sum != nullptr);
      if (is_hopeless || report.iterations >= most_iterations) {
        if (report.violation > std::max(largest_left, 2.0 * rounding))
          report.outcome = {Status::NotConverged, "projection onto the constraints stalls at t = " + text(t) +
                                                      ", violation " + text(report.violation)};
        return report;
      }
      if (sum == nullptr) {
        if (report.outcome = linearise(t, r); !report.outcome.ok()) return report;
        linearised_here = true;
        (void)evaluate_values(r);
      }
    }
    before = report.violation;
    correct(r);  // S mu = -xi, r += M^-1 K mu
    for (std::size_t a = 0; sum != nullptr && a < rows_.size(); ++a) sum[a] += rows_[a];
  }
}

/// Along the gradients of the step's beginning; the velocity takes the same multipliers.
ProjectionReport CutForm::project_step(double t, double h, double* x, double* step_velocity) {
  step_sum_.assign(model_.num_rows(), 0.0);
  ProjectionReport report = iterate_positions(t, x, step_sum_.data());
  if (!report.outcome.ok() || step_velocity == nullptr) return report;
  std::fill(move_.begin() + static_cast<std::ptrdiff_t>(3 * model_.num_moving()), move_.end(), 0.0);
  model_.gather.write_scaled(model_.parallel, blocks_.data(), step_sum_.data(), model_.inverse_mass.data(),
                             model_.num_moving(), move_.data());
  guests_.fetch(move_.data());
  for (std::size_t i = 0; i < move_.size(); ++i) step_velocity[i] += move_[i] / h;
  return report;
}

ProjectionReport CutForm::project_velocities(double t, const double* r, double* v) {
  constexpr double target = 1e-13;
  constexpr int most_iterations = 4;
  work_.set_time(t);
  ProjectionReport report;
  double before = std::numeric_limits<double>::infinity();
  for (;; ++report.iterations) {
    const double rate = agreement_.largest(work_.constraints.evaluate_rates(model_.parallel, r, v, rows_.data()));
    report.violation = rate / least_speed_;
    if (!std::isfinite(rate)) {
      report.outcome = model_.not_finite(t);
      return report;
    }
    // Linear in v: one solve is exact up to rounding, more only refine.
    const bool stands = !(report.violation < 0.5 * before);
    if (report.violation <= target || report.iterations == most_iterations || stands) return report;
    before = report.violation;
    correct(v);  // S nu = -(K'v + xi_t), v += M^-1 K nu
  }
}

/// Errors of guests count where they are at home.
ErrorRatios CutForm::error_ratios(double, const StepErrors& errors, double atol, double rtol) {
  const auto take = [&](const double* from, std::vector<double>* own) {
    own->assign(from, from + size());
    clear_guests(own->data());
    return own->data();
  };
  StepErrors own = errors;
  own.x = take(errors.x, &move_);
  own.v = take(errors.v, &dw_);
  return work_.error_ratios(own, atol, rtol);
}

// ---- the start, and what is told ----

/// Throws InputError where the given start violates constraints by more than is corrected.
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

StartReport CutForm::start(double t, double* r, double* v, StartMode mode) {
  work_.set_time(t);
  work_.prescribe_all(t, r, v);
  fetch_guests(r, v);
  work_.measure_velocity_scale(t, r, v);
  share_speeds();
  if (mode == StartMode::Check) check_start(r, v);
  StartReport report;
  const std::vector<double> r_given(r, r + size()), v_given(v, v + size());
  report.outcome = linearise(t, r);
  if (report.outcome.ok()) report.outcome = project_positions(t, r, Turn::Small).outcome;
  if (report.outcome.ok()) report.outcome = linearise(t, r);
  if (report.outcome.ok()) report.outcome = project_velocities(t, r, v).outcome;
  if (!report.outcome.ok()) return report;
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
  guests_.fetch(r);
  guests_.fetch(v);
}

void CutForm::exchange_memory(Memory& memory) {
  work_.exchange_memory(memory);
  memory.exchange(lambda_, least_speed_);
}

Reactions CutForm::no_reactions() const {
  Reactions none;
  none.lambda.resize(model_.num_rows());
  return none;
}

void CutForm::write_reactions(const Kinematics&, const Reactions& found, double* eta) {
  model_.gather.reactions(model_.parallel, blocks_.data(), found.lambda.data(), eta);
}

void CutForm::write_friction(const Reactions&, double* tau) const {
  std::fill(tau, tau + size(), 0.0);
}

void CutForm::describe(PlanSummary* plan) const {
  plan->linear_solvers = {LinearSolver::General};
  plan->linear_solver_reason = text(solver_.num_all_shared()) + " equations are shared by several ranks";
  plan->parts = 1;
  plan->pattern_nonzeros = solver_.pattern_nonzeros();
  plan->factor_nonzeros = static_cast<std::size_t>(solver_.num_stored());
  plan->factorizations = {Factorization::Multifrontal};
}

}  // namespace tanor
