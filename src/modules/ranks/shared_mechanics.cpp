#include "ranks/shared_mechanics.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <tanor/error.hpp>

#include "dynamics/corner_functions.hpp"
#include "ranks/shared_roles.hpp"

namespace tanor::detail {

Power sum_powers(Ranks& ranks, const Power& own) {
  std::array<double, 4> all{own.supports, own.forces, own.potentials, own.friction};
  ranks.sum(all);
  return {.supports = all[0], .forces = all[1], .potentials = all[2], .friction = all[3]};
}

SharedMechanics::SharedMechanics(OwnEquations& own, Ranks& ranks)
    : own_(own),
      ranks_(ranks),
      agreement_(ranks),
      keeps_variables_(agreement_.all(own.keeps_variables())),
      has_work_(agreement_.any(own.has_work())),
      is_settled_first_(agreement_.any(own.is_prescribed_together())),
      own_rank_(own.rank()),
      rank_(static_cast<std::size_t>(agreement_.sum(static_cast<double>(own.rank())))) {
  (void)agreement_.together([&] {
    CornerFunctions* const corners = own.corners();
    if (corners != nullptr && corners->num_terms() > 0)
      throw InputError("", "guides with corners move on one rank alone; one is " + corners->name_term(0));
    return Outcome{};
  });
  const Roles here = own.roles();
  const auto somebody_has = [&](const void* role) { return agreement_.any(role != nullptr); };
  const auto all_have = [&](const void* role) { return agreement_.all(role != nullptr); };
  if (all_have(here.step_projector)) projector_ = std::make_unique<Projector>(*here.step_projector, *this);
  if (somebody_has(here.drives)) drives_ = std::make_unique<Drives>(here.drives, *this);
  if (somebody_has(here.events)) events_ = std::make_unique<Events>(here.events, *this);
  if (all_have(here.implicit_formulation)) implicit_ = std::make_unique<Implicit>(*here.implicit_formulation, *this);
  const auto or_none = [&]<class Role>(Role* role, Role* none) { return somebody_has(role) && !role ? none : role; };
  roles_ = {.step_projector = projector_.get(),
            .inexact_solves = here.inexact_solves,
            .rank_monitor = or_none(here.rank_monitor, &none_.monitor),
            // Friction on any rank rules out the measurement of rounding.
            .rounding_groups = all_have(here.rounding_groups) ? here.rounding_groups : nullptr,
            .unseen_forces = or_none(here.unseen_forces, &none_.features),
            .drives = drives_.get(),
            .events = events_.get(),
            .implicit_formulation = implicit_.get()};
}

SharedMechanics::~SharedMechanics() = default;

SeriesExpansion* SharedMechanics::series(std::string* why_not) {
  if (!why_no_series_) {
    std::string why_not_here;
    SeriesExpansion* own = nullptr;
    (void)agreement_.together([&] {
      own = own_.series(&why_not_here);
      return Outcome{};
    });
    why_no_series_ = agreement_.first_text(why_not_here);
    if (why_no_series_->empty()) series_ = std::make_unique<Series>(*own, *this);
  }
  if (why_not != nullptr) *why_not = *why_no_series_;
  return series_.get();
}

// ---- what all ranks say ----

/// Work that is collective itself begins on all ranks or on none, so that they agree on an earlier failure first.
template <class Work>
Outcome SharedMechanics::together(const Work& work, std::span<double> numbers) {
  const auto settle = [&] {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    return Outcome{};
  };
  if (is_settled_first_) (void)agreement_.together(settle);
  return agreement_.together(
      [&] {
        (void)settle();
        return work();
      },
      numbers);
}

/// Concludes with `numbers`, of which the largest count, and takes over the state of the last linearisation.
template <class Work>
Outcome SharedMechanics::conclude_with(const Work& work, std::span<double> numbers) {
  std::vector<double> all(numbers.size() + 2);
  Outcome outcome = together(
      [&] {
        Outcome own = work();
        std::copy(numbers.begin(), numbers.end(), all.begin());
        all[numbers.size()] = -own_.reciprocal_condition();
        all[numbers.size() + 1] = own_.rank() != own_rank_ ? 1.0 : 0.0;
        return own;
      },
      all);
  std::copy_n(all.begin(), numbers.size(), numbers.begin());
  reciprocal_condition_ = std::max(0.0, -all[numbers.size()]);
  if (all[numbers.size() + 1] > 0.0) {
    own_rank_ = own_.rank();
    rank_ = static_cast<std::size_t>(agreement_.sum(static_cast<double>(own_rank_)));
  }
  return outcome;
}

template <class Work>
Outcome SharedMechanics::conclude(const Work& work, const AccelerationOutput& to) {
  std::array<double, 1> residual{};
  Outcome outcome = conclude_with(
      [&] {
        Outcome own = work();
        if (to.report != nullptr) residual[0] = to.report->residual;
        return own;
      },
      residual);
  if (to.report != nullptr) {
    to.report->residual = residual[0];
    to.report->reciprocal_condition = reciprocal_condition_;
  }
  if (outcome.ok() && to.power != nullptr) *to.power = sum_powers(ranks_, *to.power);
  return outcome;
}

template <class Work>
ProjectionReport SharedMechanics::conclude_projection(const Work& work) {
  ProjectionReport report;
  std::array<double, 3> numbers{};
  report.outcome = conclude_with(
      [&] {
        ProjectionReport own = work();
        numbers = {own.violation, own.correction, static_cast<double>(own.iterations)};
        return own.outcome;
      },
      numbers);
  report.violation = numbers[0];
  report.correction = numbers[1];
  report.iterations = static_cast<int>(numbers[2]);
  return report;
}

// ---- Mechanics ----

void SharedMechanics::prescribe(double t, double* x, double* v) {
  try {
    own_.prescribe(t, x, v);
  } catch (...) {
    if (!failure_) failure_ = std::current_exception();
  }
}

Outcome SharedMechanics::linearise(double t, const double* x) {
  return conclude([&] { return own_.linearise(t, x); });
}

Outcome SharedMechanics::accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) {
  return conclude([&] { return own_.accelerations(at, request, to); }, to);
}

ProjectionReport SharedMechanics::project_positions(double t, double* x, Turn turn) {
  return conclude_projection([&] { return own_.project_positions(t, x, turn); });
}

ProjectionReport SharedMechanics::project_velocities(double t, const double* x, double* v) {
  return conclude_projection([&] { return own_.project_velocities(t, x, v); });
}

ErrorRatios SharedMechanics::error_ratios(double t, const StepErrors& errors, double atol, double rtol) {
  const ErrorRatios own = own_.error_ratios(t, errors, atol, rtol);
  std::array<double, 2> largest{own.x, own.v};
  (void)agreement_.agree({}, largest);
  return {largest[0], largest[1]};
}

// ---- EquationsOfMotion ----

StartReport SharedMechanics::conclude_start(const std::function<StartReport()>& start) {
  StartReport report;
  std::array<double, 3> numbers{};
  report.outcome = conclude_with(
      [&] {
        StartReport own = start();
        numbers = {own.position_correction, own.velocity_correction, own.relative};
        return own.outcome;
      },
      numbers);
  report.position_correction = numbers[0];
  report.velocity_correction = numbers[1];
  report.relative = numbers[2];
  return report;
}

Outcome SharedMechanics::set_state(double t, const double* r, const double* v, double* x, double* x_dot) {
  return agreement_.together([&] { return own_.set_state(t, r, v, x, x_dot); });
}

Outcome SharedMechanics::begin(double t, const double* x, double* x_dot, const Request& request,
                               const AccelerationOutput& to) {
  return conclude([&] { return own_.begin(t, x, x_dot, request, to); }, to);
}

Energy SharedMechanics::energy(double t, const double* x, const double* v) {
  const Energy own = own_.energy(t, x, v);
  std::array<double, 2> all{own.kinetic, own.potential};
  ranks_.sum(all);
  return {all[0], all[1]};
}

}  // namespace tanor::detail
