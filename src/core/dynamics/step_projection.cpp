#include "dynamics/step_projection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor::detail {

namespace {

constexpr double friction_has_converged = 1e-11;  // relative
constexpr int most_friction_iterations = 100;

}  // namespace

StepProjection::StepProjection(Workspace& work, Linearization& linearization, Projector& projector,
                               ForwardDynamics& dynamics, Contacts* contacts)
    : work_(work),
      model_(work.model()),
      linearization_(linearization),
      projector_(projector),
      dynamics_(dynamics),
      contacts_(contacts),
      step_{std::vector<double>(model_.num_rows()), std::vector<double>(model_.num_rows()),
            std::vector<double>(model_.num_rows())} {
  if (contacts != nullptr) lambda_.resize(model_.num_rows());
}

void StepProjection::forget_steps() {
  std::fill(step_.last.begin(), step_.last.end(), 0.0);
  std::fill(step_.before.begin(), step_.before.end(), 0.0);
}

/// Exchanges the initial guess of the next step.
void StepProjection::exchange_memory(Memory& memory) {
  memory.exchange(step_.last, step_.before, step_.last_h, step_.before_h);
  bool have_same_frames = step_.frames == work_.constraints.frames();
  memory.exchange(have_same_frames);
  if (memory.reads()) step_.frames = work_.constraints.frames() + (have_same_frames ? 0 : 1);
}

Outcome StepProjection::free_accelerations(const Kinematics& at, const Request& request, double* w, double* largest) {
  if (contacts_ != nullptr) {
    // M^-1 (f + tau) = w - M^-1 eta, since the friction of sticking contacts is a force like the others.
    if (Outcome outcome = dynamics_.solve(at, request, {w, nullptr, nullptr, &found_}); !outcome.ok()) return outcome;
    eta_.resize(3 * model_.num_points());
    dynamics_.write_reactions(found_.lambda, eta_.data());
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) w[i] -= model_.inverse_mass[i / 3] * eta_[i];
    return {};
  }
  const Stopwatch watch(&work_.times.evaluate);
  if (model_.uniform_free() != nullptr) {
    work_.write_uniform(at.t, w);
    return {};
  }
  *largest = work_.evaluate_free(at.t, at.x, at.v, w);
  return std::isfinite(*largest) ? Outcome{} : work_.not_finite(at.t, at.x);
}

/// The sum of the multipliers is h^2 times a smooth function of time (half of lambda). Extrapolation from the last two
/// steps saves iterations and does not change the solution.
void StepProjection::guess_step(double h) {
  const double scale = h * h;
  const std::size_t frames = work_.constraints.frames();
  if (work_.team().any(frames != step_.frames)) forget_steps();
  step_.frames = frames;
  // Divided by h^2 of a step that is short, e.g. cut at an event, the multipliers are rounding.
  constexpr double short_step = 0.1;
  const bool can_guess = std::min(step_.last_h, step_.before_h) >= short_step * std::abs(h);
  model_.parallel.for_ranges(model_.num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      step_.sum[a] = can_guess ? scale * (2.0 * step_.last[a] - step_.before[a]) : 0.0;
    }
  });
}

/// Keeps the sum for the next guess, and divides it by h for the velocity.
void StepProjection::keep_step(double h) {
  step_.before_h = std::exchange(step_.last_h, std::abs(h));
  std::swap(step_.before, step_.last);
  const double scale = h * h;
  model_.parallel.for_ranges(model_.num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      step_.last[a] = step_.sum[a] / scale;
      step_.sum[a] /= h;
    }
  });
}

ProjectionReport StepProjection::project_step(double t, double h, double* r, const PointSource* source,
                                              double* step_velocity, double tolerance) {
  guess_step(h);
  const bool has_dependent_rows = linearization_.dependences().is_found();
  if (has_dependent_rows) {
    bring(model_.parallel, std::exchange(source, nullptr), 0, model_.num_points());
    step_start_.assign(r, r + 3 * model_.num_points());
  }
  ProjectionReport report = projector_.project_along_gradients(t, r, step_.sum.data(), source, tolerance);
  if (!report.outcome.ok() && has_dependent_rows) {
    // Rows that depended at the last K may be independent where the step begins.
    if (!linearization_.decide_rank_again(step_start_.data())) return project_singular_step(t, h, r, step_velocity);
    std::copy(step_start_.begin(), step_start_.end(), r);
    std::fill(step_.sum.begin(), step_.sum.end(), 0.0);
    report = projector_.project_along_gradients(t, r, step_.sum.data(), nullptr, tolerance);
  }
  if (!report.outcome.ok()) return report;  // a failed step leaves no trace in the next guess
  keep_step(h);
  // The velocity takes the same multipliers, so that no digits cancel in (r - r0)/h.
  if (step_velocity != nullptr) linearization_.add_reactions(step_.sum.data(), step_velocity);
  return steps_with_friction() ? iterate_step_friction(t, h, r, step_velocity, report) : report;
}

/// Iterates (43) with the friction of the step's own multipliers, lambda = 2 sum/h^2, each time by one projection from
///
///   r += h^2/2 M^-1 dtau,   v1/2 += h/2 M^-1 dtau
ProjectionReport StepProjection::iterate_step_friction(double t, double h, double* r, double* step_velocity,
                                                       ProjectionReport report) {
  for (int k = 0; k < most_friction_iterations; ++k) {
    for (std::size_t a = 0; a < model_.num_rows(); ++a) lambda_[a] = 2.0 * step_.last[a];
    const Stopwatch watch(&work_.times.friction);
    const double change = contacts_->change_to(lambda_.data(), 0.5 * h, step_velocity);
    contacts_->add_change(0.5 * h * h, r);
    if (change <= friction_has_converged) return report;
    ++work_.counters.friction_iterations;
    std::fill(step_.sum.begin(), step_.sum.end(), 0.0);
    const ProjectionReport again = projector_.project_along_gradients(t, r, step_.sum.data());
    report.iterations += again.iterations;
    report.violation = again.violation;
    if (report.outcome = again.outcome; !report.outcome.ok()) return report;
    for (std::size_t a = 0; a < model_.num_rows(); ++a) {
      step_.last[a] += step_.sum[a] / (h * h);
      step_.sum[a] /= h;
    }
    linearization_.add_reactions(step_.sum.data(), step_velocity);
  }
  report.outcome = fail_friction(Status::NotConverged, t, "the iteration for the step's multipliers stalls");
  return report;
}

/// Projects from a configuration where K has less rank than around it. The range of that K does not lead onto xi = 0,
/// so Newton's method evaluates K on the way.
ProjectionReport StepProjection::project_singular_step(double t, double h, double* r, double* step_velocity) {
  std::copy(step_start_.begin(), step_start_.end(), r);
  std::fill(step_.sum.begin(), step_.sum.end(), std::numeric_limits<double>::quiet_NaN());
  if (Outcome outcome = linearization_.update(t, r); !outcome.ok()) return {std::move(outcome)};
  ProjectionReport report = projector_.project_positions(t, r, Turn::Small);
  if (!report.outcome.ok()) return report;
  for (std::size_t i = 0; step_velocity != nullptr && i < step_start_.size(); ++i)
    step_velocity[i] += (r[i] - step_start_[i]) / h;
  return report;
}

/// Iterates likewise with the multipliers of the second half of a step, lambda = 2 nu/h.
ProjectionReport StepProjection::project_step_velocities(double t, double h, const double* r, double* v) {
  if (!steps_with_friction()) return projector_.project_velocities(t, r, v);
  std::vector<double>& sum = step_.sum;
  std::fill(sum.begin(), sum.end(), 0.0);
  ProjectionReport report;
  for (int k = 0; k < most_friction_iterations; ++k) {
    const ProjectionReport again = projector_.project_velocities(t, r, v, sum.data());
    report.iterations += again.iterations;
    report.violation = again.violation;
    if (report.outcome = again.outcome; !report.outcome.ok()) return report;
    for (std::size_t a = 0; a < model_.num_rows(); ++a) lambda_[a] = 2.0 / h * sum[a];
    const Stopwatch watch(&work_.times.friction);
    if (contacts_->change_to(lambda_.data(), 0.5 * h, v) <= friction_has_converged) return report;
    ++work_.counters.friction_iterations;
  }
  report.outcome = fail_friction(Status::NotConverged, t, "the iteration for the step's multipliers stalls");
  return report;
}

bool StepProjection::steps_with_friction() const {
  return contacts_ != nullptr && contacts_->depends_on_multipliers();
}

}  // namespace tanor::detail
