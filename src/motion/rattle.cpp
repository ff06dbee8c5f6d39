#include "motion/rattle.hpp"

#include "base/check.hpp"

namespace tanor {

namespace {

/// y = a + s b
void add_scaled(const Parallel& parallel, const std::vector<double>& a, double s, const std::vector<double>& b,
                std::vector<double>* y) {
  parallel.for_ranges(a.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) (*y)[i] = a[i] + s * b[i];
  });
}

StepProjector& projector_of(Mechanics& mechanics) {
  ensure(mechanics.step_projector() != nullptr, "rattle steps in normal form");
  return *mechanics.step_projector();
}

}  // namespace

Rattle::Rattle(Mechanics& mechanics, int passes)
    : mechanics_(mechanics),
      projector_(projector_of(mechanics)),
      passes_(passes),
      free_(mechanics.size()),
      middle_(mechanics.size()) {}

StepResult Rattle::step(const State& from, double h, State* to) {
  const Parallel& parallel = mechanics_.parallel();
  const double t = to->t;
  StepResult result;

  // M^-1 f at the old place; the last step has it where forces do not depend on v.
  // Fixed steps have no tolerance that would ask for exact accelerations.
  const Request request = IntegrationOptions().request(Gradients::Keep);
  if (!knows_free_ || free_time_ != from.t || projector_.depends_on_velocity()) {
    result.outcome = projector_.free_accelerations(from.at(), request, free_.data());
    if (!result.outcome.ok()) return result;
  }
  knows_free_ = false;

  // v1/2 = v + h/2 M^-1 f, r1 = r0 + h v1/2, then both along M^-1 K(r0) until xi(r1, t1) = 0
  add_scaled(parallel, from.v, 0.5 * h, free_, &middle_);
  add_scaled(parallel, from.x, h, middle_, &to->x);
  to->work = from.work;
  mechanics_.prescribe(t, to->x.data(), to->v.data());
  const ProjectionReport positions = projector_.project_step(t, h, to->x.data(), middle_.data());
  result.position_violation = positions.violation;
  if (result.outcome = positions.outcome; !result.outcome.ok()) return result;
  if (result.outcome = mechanics_.linearise(t, to->x.data()); !result.outcome.ok()) return result;

  // v1 = v1/2 + h/2 M^-1 f1, onto K(r1)'v1 + xi_t = 0; where f1 depends on v1, again with the better v1
  const std::vector<double>* guess = &middle_;
  for (int pass = 0; pass < (projector_.depends_on_velocity() ? passes_ : 1); ++pass) {
    result.outcome = projector_.free_accelerations({t, to->x.data(), guess->data()}, request, free_.data());
    if (!result.outcome.ok()) return result;
    add_scaled(parallel, middle_, 0.5 * h, free_, &to->v);
    mechanics_.prescribe(t, to->x.data(), to->v.data());
    const ProjectionReport velocities = projector_.project_step_velocities(t, h, to->x.data(), to->v.data());
    result.velocity_violation = velocities.violation;
    if (result.outcome = velocities.outcome; !result.outcome.ok()) return result;
    guess = &to->v;
  }
  knows_free_ = true;
  free_time_ = t;

  if (knows_acceleration()) {
    result.outcome = mechanics_.accelerations(to->at(), request, to->output());
    if (!result.outcome.ok()) return result;
  }
  if (mechanics_.has_work()) {
    // Trapezoidal rule, of the scheme's order.
    to->work.supports += 0.5 * h * (from.power.supports + to->power.supports);
    to->work.forces += 0.5 * h * (from.power.forces + to->power.forces);
    to->work.friction += 0.5 * h * (from.power.friction + to->power.friction);
  }
  return result;
}

}  // namespace tanor
