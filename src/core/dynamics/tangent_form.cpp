#include "dynamics/tangent_form.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "dynamics/corners.hpp"

namespace tanor::detail {

TangentForm::TangentForm(Workspace& work, const SolverOptions& options)
    : work_(work),
      model_(work.model()),
      linearization_(work, options),
      dynamics_(work, linearization_),
      unseen_(work),
      events_(linearization_, dynamics_),
      corners_(std::make_unique<TangentCorners>(work, linearization_)),
      q_(size(), 0.0),
      rates_(size()) {
  for (std::vector<double>* array : {&moved_, &rate_, &r_from_, &v_from_}) array->resize(3 * model_.num_points(), 0.0);
  std::vector<double> no_rates(size());
  work_.coordinates.write_start(q_.data(), no_rates.data());
}

TangentForm::~TangentForm() = default;

void TangentForm::describe(PlanSummary* plan) const {
  linearization_.describe(plan);
  plan->left_out.push_back("projections: r(q, t) stays on the constraints by itself");
  plan->left_out.push_back("multipliers in steps: computed where they are asked for");
  if (!work_.coordinates.depends_on_time()) plan->left_out.push_back("moving coordinates: none depend on time");
  if (!work_.coordinates.has_charts()) plan->left_out.push_back("recentring: coordinates without charts");
}

Roles TangentForm::roles_here() {
  return {.rank_monitor = &rank_,
          .unseen_forces = unseen_.forces(),
          .drives = unseen_.drives(),
          .events = events_.has_some() ? &events_ : nullptr,
          .corners = !corners_->empty() ? corners_.get() : nullptr};
}

Outcome TangentForm::begin(double t, const double* q, double* q_dot, const Request& request,
                           const AccelerationOutput& to) {
  return solve_together(to, [&] {
    if (EquationsOfMotion* const friction = dynamics_.friction(); friction != nullptr) {
      linearization_.evaluate(t, q, q_dot, false);
      std::vector<double> v = linearization_.v(), w(v.size());
      Outcome found = friction->begin(t, linearization_.r().data(), v.data(), request, {w.data(), nullptr, to.report});
      if (!found.ok()) return found;
    }
    return dynamics_.solve({t, q, q_dot}, request, to);
  });
}

ErrorRatios TangentForm::error_ratios(double t, const StepErrors& errors, double atol, double rtol) {
  dynamics_.complete();
  // The errors of q and q_dot move the points by A dq and A dq_dot, with A at the step's end.
  const auto& coordinates = work_.coordinates;
  std::fill(moved_.begin(), moved_.end(), 0.0);
  linearization_.apply(errors.x, moved_.data());
  linearization_.apply(errors.v, rate_.data());
  const double t_end = work_.time();
  work_.set_time(t);
  work_.prescribe_all(t, r_from_.data(), v_from_.data());
  coordinates.evaluate(model_.parallel, errors.x_from, errors.v_from, r_from_.data(), v_from_.data(), nullptr, nullptr);
  work_.set_time(t_end);
  const StepErrors errors_of_points{moved_.data(),
                                    rate_.data(),
                                    r_from_.data(),
                                    v_from_.data(),
                                    linearization_.r().data(),
                                    linearization_.v().data()};
  return largest_of_all(work_.error_ratios(errors_of_points, atol, rtol));
}

Energy TangentForm::energy(double t, const double* q, const double* q_dot) {
  linearization_.evaluate(t, q, q_dot, false);
  return sum_of_all(work_.energy(t, linearization_.r().data(), linearization_.v().data()));
}

// ---- points and coordinates ----

Outcome TangentForm::set_state(double t, const double* r, const double* v, double* q, double* q_dot) {
  return together([&]() -> Outcome {
    work_.set_time(t);
    dynamics_.locate(r, &q_);
    std::copy(q_.begin(), q_.end(), q);
    if (Outcome outcome = linearization_.find_rates(t, v, q, q_dot); !outcome.ok()) return outcome;
    constexpr double allowed = 1e-3;  // as at the start
    const double distance = model_.largest_move(linearization_.r().data(), r);
    if (distance <= allowed * model_.scene_size) return {};
    return {Status::NotConverged, "the positions at t = " + text(t) +
                                      " are not those of the coordinates: the nearest that were found lie " +
                                      with_unit(text(distance), model_.system.units.length) + " away"};
  });
}

ProjectionReport TangentForm::measure_violation(double t, const double* q) {
  if (model_.num_rows() == 0) return {};
  linearization_.evaluate(t, q, rates_.data(), false);
  ProjectionReport report;
  report.violation = work_.position_violation(t, linearization_.r().data());
  constexpr double rounding = 1e-9;
  const double far = std::max(1.0, model_.largest_norm(linearization_.r().data()) / model_.smallest_length);
  if (!(report.violation <= rounding * far)) {
    report.outcome = {Status::Contradictory, "coordinates and constraints part at t = " + text(t) + ", violation " +
                                                 text(report.violation) + "; both must describe the same motion"};
  }
  return report;
}

ProjectionReport TangentForm::project_point_positions(double t, double* r) {
  work_.set_time(t);
  dynamics_.locate(r, &q_);
  linearization_.evaluate(t, q_.data(), rates_.data(), false);
  std::copy(linearization_.r().begin(), linearization_.r().end(), r);
  return {.outcome = {}, .correction = 0.0, .violation = work_.position_violation(t, r), .iterations = 1};
}

ProjectionReport TangentForm::project_point_velocities(double t, const double* r, double* v) {
  work_.set_time(t);
  dynamics_.locate(r, &q_);
  ProjectionReport report;
  report.outcome = linearization_.find_rates(t, v, q_.data(), rates_.data());
  if (!report.outcome.ok()) return report;
  linearization_.evaluate(t, q_.data(), rates_.data(), false);
  std::copy(linearization_.v().begin(), linearization_.v().end(), v);
  report.violation = work_.velocity_violation(t, r, v);
  report.iterations = 1;
  return report;
}

void TangentForm::write_points(const Kinematics& at, const double*, const Reactions& found, double* r, double* v,
                               double* w) {
  linearization_.evaluate(at.t, at.x, at.v, false);
  std::copy(linearization_.r().begin(), linearization_.r().end(), r);
  std::copy(linearization_.v().begin(), linearization_.v().end(), v);
  std::copy(found.w.begin(), found.w.end(), w);
}

void TangentForm::recentre(double t, double* q, double* q_dot, double* q_ddot, Reactions* found) {
  if (work_.coordinates.has_charts()) dynamics_.complete(found);  // in the charts that q belongs to
  if (EquationsOfMotion* const friction = dynamics_.friction(); friction != nullptr) {
    r_from_ = linearization_.r();
    v_from_ = linearization_.v();
    friction->recentre(t, r_from_.data(), v_from_.data(), nullptr, found);
  }
  work_.set_time(t);
  work_.coordinates.recentre(t, q, q_dot, q_ddot);
}

Reactions TangentForm::no_reactions() const {
  Reactions none = dynamics_.friction() != nullptr ? dynamics_.friction()->no_reactions() : Reactions{};
  none.w.resize(3 * model_.num_points());
  if (work_.coordinates.has_charts()) none.w0.resize(none.w.size());
  return none;
}

void TangentForm::exchange_memory(Memory& memory) {
  if (memory.reads()) dynamics_.complete();  // in the charts that the last accelerations belong to
  work_.exchange_memory(memory);
  work_.coordinates.exchange_memory(memory);
  dynamics_.exchange_memory(memory);
}

void TangentForm::resume(const Counters& counters, const PhaseTimes& times) {
  work_.counters = counters;
  work_.times = times;
}

}  // namespace tanor::detail
