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
      part_(part),
      linearization_(work, part, options.ordering),
      agreement_(linearization_.agreement()),
      projector_(work, linearization_),
      is_rheonomic_(agreement_.any(model_.is_rheonomic())),
      rank_(agreement_.largest(model_.mass_ratio)),
      lambda_(model_.num_rows()),
      b_(model_.num_rows()),
      rows_(model_.num_rows()),
      dw_(3 * model_.num_points()) {
  measure_neighbourhoods();
  if (!part.energies_counted_elsewhere.empty()) {
    System others = model_.system;
    others.forces.clear();
    for (const std::size_t f : part.energies_counted_elsewhere) others.forces.push_back(model_.system.forces[f]);
    counted_elsewhere_ = std::make_unique<Forces>(others, model_.numbering);
  }
  for (const Part::SharedRow& shared : part.shared_rows) work_.rank -= shared.is_counted ? 0 : 1;
}

Roles CutForm::roles() {
  Roles roles = common_roles();
  roles.step_projector = &projector_;
  roles.rank_monitor = &rank_;
  return roles;
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
  projector_.set_least_speed(agreement_.smallest(work_.scales.least_speed()));
}

// ---- accelerations ----

/// rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho
int CutForm::refine(const double* b, double scale, double good_enough, double* residual) {
  return refine_solution(
      RefinementLimits{5},
      [&] {
        const double largest = agreement_.largest(work_.constraints.apply_transposed(
            model_.parallel, linearization_.blocks().data(), dw_.data(), b, rows_.data()));
        return *residual = largest / (scale > 0.0 ? scale : 1.0);
      },
      [&](double left) { return left <= good_enough; },
      [&](int) {
        linearization_.correct(rows_.data(), dw_.data());
        for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
      });
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
    if (Outcome outcome = linearization_.factorize(at.t); !outcome.ok()) return outcome;
  }
  SolveReport report;
  {
    const Stopwatch watch(&work_.times.solve);
    linearization_.solve(b_.data(), lambda_.data(), dw_.data());
    report.refinements = refine(b_.data(), scale, request.exact ? 1e-15 : 1e-12, &report.residual);
  }
  if (!std::isfinite(report.residual)) return model_.not_finite(at.t);
  for (std::size_t i = 0; i < dw_.size(); ++i) w[i] += dw_[i];
  report.reciprocal_condition = linearization_.reciprocal_condition();
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
    own_v_.assign(at.v, at.v + size());
    clear_guests(own_v_.data());
    result.supports = work_.forces.elastic_power_of_supports(model_.parallel, at.x, own_v_.data()) +
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

/// Errors of guests count where they are at home.
ErrorRatios CutForm::error_ratios(double, const StepErrors& errors, double atol, double rtol) {
  const auto take = [&](const double* from, std::vector<double>* own) {
    own->assign(from, from + size());
    clear_guests(own->data());
    return own->data();
  };
  StepErrors own = errors;
  own.x = take(errors.x, &own_x_);
  own.v = take(errors.v, &own_v_);
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
  linearization_.guests().fetch(r);
  linearization_.guests().fetch(v);
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

}  // namespace tanor
