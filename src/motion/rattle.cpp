#include "motion/rattle.hpp"

#include <utility>

#include "base/check.hpp"

namespace tanor {

namespace {

/// Arrays of the first half of a step. `move_freely` computes v1/2 = v + h/2 a and x1 = x + h v1/2 in one pass over
/// `size` numbers, since the cost of long arrays is their passes through memory.
struct FirstHalf {
  const double *x, *v, *a;
  double *middle, *x1;
};
void move_freely(const Parallel& parallel, std::size_t size, double h, const FirstHalf& of) {
  parallel.for_ranges(size, [&](std::size_t begin, std::size_t end) {
    const double *const x = of.x, *const v = of.v, *const a = of.a;
    double* __restrict middle = of.middle;
    double* __restrict x1 = of.x1;
    const double half = 0.5 * h;
    for (std::size_t i = begin; i < end; ++i) {
      middle[i] = v[i] + half * a[i];
      x1[i] = x[i] + h * middle[i];
    }
  });
}

/// Computes v1 = v1/2 + h/2 a; `middle` and `v1` may be one array.
void kick(const Parallel& parallel, double h, const std::vector<double>& a, const std::vector<double>& middle,
          std::vector<double>* v1) {
  parallel.for_ranges(a.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) (*v1)[i] = middle[i] + 0.5 * h * a[i];
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
      middle_(projector_.depends_on_velocity() ? mechanics.size() : 0) {}

/// Writes M^-1 f into `free_`, unless it is constant and stands there already.
Outcome Rattle::find_free(const Kinematics& at, const Request& request) {
  if (has_constant_ && projector_.is_constant()) return {};
  Outcome outcome = projector_.free_accelerations(at, request, free_.data());
  has_constant_ = outcome.ok() && projector_.is_constant();
  return outcome;
}

StepResult Rattle::step(const State& from, double h, State* to) {
  const Parallel& parallel = mechanics_.parallel();
  const double t = to->t;
  const auto fail = [](Outcome outcome) { return StepResult{.outcome = std::move(outcome)}; };
  StepResult result;

  // M^-1 f at the beginning, which is known from the last step if forces do not depend on v. Fixed steps have no
  // tolerance that would ask for exact accelerations.
  const Request request = IntegrationOptions().request(Gradients::Keep);
  const bool depends_on_velocity = projector_.depends_on_velocity();
  if (!knows_free_ || free_time_ != from.t || depends_on_velocity) {
    if (Outcome found = find_free(from.at(), request); !found.ok()) return fail(std::move(found));
  }
  knows_free_ = false;

  // v1/2 = v + h/2 M^-1 f and r1 = r0 + h v1/2, then both along M^-1 K(r0) until xi(r1, t1) = 0
  std::vector<double>& middle = depends_on_velocity ? middle_ : to->v;
  move_freely(parallel, from.x.size(), h, {from.x.data(), from.v.data(), free_.data(), middle.data(), to->x.data()});
  to->work = from.work;
  mechanics_.prescribe(t, to->x.data(), to->v.data());
  ProjectionReport positions = projector_.project_step(t, h, to->x.data(), middle.data());
  if (!positions.outcome.ok()) return fail(std::move(positions.outcome));
  result.position_violation = positions.violation;
  if (Outcome found = mechanics_.linearise(t, to->x.data()); !found.ok()) return fail(std::move(found));

  // v1 = v1/2 + h/2 M^-1 f1, projected onto K(r1)'v1 + xi_t = 0; repeated with the better v1 if f1 depends on v1
  const std::vector<double>* guess = &middle;
  for (int pass = 0; pass < (depends_on_velocity ? passes_ : 1); ++pass) {
    if (Outcome found = find_free({t, to->x.data(), guess->data()}, request); !found.ok())
      return fail(std::move(found));
    kick(parallel, h, free_, middle, &to->v);
    mechanics_.prescribe(t, to->x.data(), to->v.data());
    ProjectionReport velocities = projector_.project_step_velocities(t, h, to->x.data(), to->v.data());
    if (!velocities.outcome.ok()) return fail(std::move(velocities.outcome));
    result.velocity_violation = velocities.violation;
    guess = &to->v;
  }
  knows_free_ = true;
  free_time_ = t;

  if (knows_acceleration()) {
    if (Outcome found = mechanics_.accelerations(to->at(), request, to->output()); !found.ok())
      return fail(std::move(found));
  }
  if (mechanics_.has_work()) {
    // The trapezoidal rule has the scheme's order.
    to->work.add(0.5 * h, from.power);
    to->work.add(0.5 * h, to->power);
  }
  return result;
}

}  // namespace tanor
