#include <tanor/dynamics.hpp>

#include <algorithm>

#include "dynamics/normal_form.hpp"

namespace tanor {

namespace {

void check_size(std::span<const double> array, std::size_t wanted, const char* name) {
  if (array.size() != wanted) {
    throw InputError("", std::string(name) + " has " + std::to_string(array.size()) + " numbers; " +
                             std::to_string(wanted) + " are needed");
  }
}

}  // namespace

/// One gather, one scatter: the host's arrays are read and written once a call.
struct Dynamics::Implementation {
  NormalForm form;
  // In the inner order, the last solve …
  double t = 0.0;
  std::vector<double> r, v, w, eta;
  // … and what the other calls work on.
  std::vector<double> x, y, before;

  Implementation(System system, SolverOptions options)
      : form(std::move(system), options), r(form.size()), v(form.size()), w(form.size()), eta(form.size()) {
    form.set_exact(true);
  }

  const Numbering& numbering() const { return form.numbering(); }

  /// Positions and velocities (where there are some), with what is prescribed at supports.
  void gather(double time, std::span<const double> positions, std::span<const double> velocities,
              std::vector<double>* inner_r, std::vector<double>* inner_v) {
    check_size(positions, form.size(), "positions");
    inner_r->resize(form.size());
    inner_v->resize(form.size());
    numbering().gather_points(positions, *inner_r);
    if (!velocities.empty()) {
      check_size(velocities, form.size(), "velocities");
      numbering().gather_points(velocities, *inner_v);
    }
    form.prescribe_all(time, inner_r->data(), inner_v->data());
  }
};

Dynamics::Dynamics(System system, SolverOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(system), options)) {}
Dynamics::Dynamics(Dynamics&&) noexcept = default;
Dynamics& Dynamics::operator=(Dynamics&&) noexcept = default;
Dynamics::~Dynamics() = default;

const System& Dynamics::system() const {
  return implementation_->form.system();
}
std::size_t Dynamics::num_points() const {
  return implementation_->numbering().num_points();
}
std::size_t Dynamics::num_equations() const {
  return implementation_->numbering().num_rows();
}
const PlanSummary& Dynamics::plan() const {
  return implementation_->form.plan();
}
PhaseTimes Dynamics::phase_times() const {
  return implementation_->form.times();
}
Counters Dynamics::counters() const {
  return implementation_->form.counters();
}

SolveReport Dynamics::solve(double t, std::span<const double> positions, std::span<const double> velocities,
                            std::span<double> accelerations, std::span<double> multipliers,
                            std::span<double> reactions) {
  Implementation& self = *implementation_;
  const auto check_wanted = [](std::span<const double> array, std::size_t size, const char* name) {
    if (!array.empty()) check_size(array, size, name);
  };
  check_wanted(accelerations, self.form.size(), "accelerations");
  check_wanted(multipliers, num_equations(), "multipliers");
  check_wanted(reactions, self.form.size(), "reactions");
  self.gather(t, positions, velocities, &self.r, &self.v);
  self.t = t;
  (void)self.form.accelerations(t, self.r.data(), self.v.data(), Gradients::Evaluate, self.w.data());
  const SolveReport report = self.form.last_solve();
  if (!report.outcome.ok()) return report;
  self.form.reactions(self.eta.data());
  if (!accelerations.empty()) self.numbering().scatter_points(self.w, accelerations);
  if (!multipliers.empty()) self.numbering().scatter_rows(self.form.multipliers(), multipliers);
  if (!reactions.empty()) self.numbering().scatter_points(self.eta, reactions);
  return report;
}

void Dynamics::active_forces(std::span<double> forces) const {
  check_size(forces, implementation_->form.size(), "forces");
  implementation_->numbering().scatter_points(implementation_->form.active_forces(), forces);
}

void Dynamics::support_forces(std::span<double> forces) const {
  const Implementation& self = *implementation_;
  check_size(forces, self.form.size(), "forces");
  const std::vector<double>& f = self.form.active_forces();
  const Numbering& numbering = self.numbering();
  for (std::size_t i = 0; i < numbering.num_points(); ++i) {
    const bool moves = i < numbering.num_moving;
    store(forces.data(), numbering.user_point[i], moves ? Vec3{} : load(self.eta.data(), i) + load(f.data(), i));
  }
}

Outcome Dynamics::split(std::span<double> tangent_accelerations, std::span<double> normal_accelerations) {
  Implementation& self = *implementation_;
  check_size(tangent_accelerations, self.form.size(), "tangent accelerations");
  check_size(normal_accelerations, self.form.size(), "normal accelerations");
  std::vector<double> normal(self.form.size());
  self.form.prescribe_all(self.t, self.r.data(), self.v.data());
  if (Outcome outcome = self.form.normal_accelerations(self.t, self.r.data(), self.v.data(), normal.data());
      !outcome.ok()) {
    return outcome;
  }
  self.numbering().scatter_points(normal, normal_accelerations);
  // w_T = w - w_N (25); supports have no part in either.
  std::vector<double>& tangent = normal;
  const std::size_t moving = 3 * self.numbering().num_moving;
  for (std::size_t i = 0; i < moving; ++i) tangent[i] = self.w[i] - normal[i];
  self.numbering().scatter_points(tangent, tangent_accelerations);
  return {};
}

ProjectionReport Dynamics::project_positions(double t, std::span<double> positions) {
  Implementation& self = *implementation_;
  self.gather(t, positions, {}, &self.x, &self.y);
  self.before = self.x;
  ProjectionReport report;
  report.outcome = self.form.linearise(t, self.x.data());
  if (report.outcome.ok()) report = self.form.project_positions(t, self.x.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.x, positions);
  report.correction = self.form.largest_move(self.x.data(), self.before.data());
  return report;
}

ProjectionReport Dynamics::project_velocities(double t, std::span<const double> positions,
                                              std::span<double> velocities) {
  Implementation& self = *implementation_;
  self.gather(t, positions, velocities, &self.x, &self.y);
  self.before = self.y;
  ProjectionReport report;
  report.outcome = self.form.linearise(t, self.x.data());
  if (report.outcome.ok()) report = self.form.project_velocities(t, self.x.data(), self.y.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.y, velocities);
  report.correction = self.form.largest_move(self.y.data(), self.before.data());
  return report;
}

StartReport Dynamics::start(double t, std::span<double> positions, std::span<double> velocities, StartMode mode) {
  Implementation& self = *implementation_;
  self.gather(t, positions, velocities, &self.x, &self.y);
  const StartReport report = self.form.start(t, self.x.data(), self.y.data(), mode);
  if (report.outcome.ok()) {
    self.numbering().scatter_points(self.x, positions);
    self.numbering().scatter_points(self.y, velocities);
  }
  return report;
}

double Dynamics::position_violation(double t, std::span<const double> positions) {
  Implementation& self = *implementation_;
  self.gather(t, positions, {}, &self.x, &self.y);
  return self.form.position_violation(t, self.x.data());
}

double Dynamics::velocity_violation(double t, std::span<const double> positions, std::span<const double> velocities) {
  Implementation& self = *implementation_;
  self.gather(t, positions, velocities, &self.x, &self.y);
  return self.form.velocity_violation(t, self.x.data(), self.y.data());
}

}  // namespace tanor
