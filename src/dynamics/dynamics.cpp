#include <tanor/dynamics.hpp>

#include <algorithm>

#include "dynamics/certificate.hpp"

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
  Forms forms;
  Model& model = forms.model;
  EquationsOfMotion& form = *forms.main;
  // In the inner order, the last solve …
  double t = 0.0;
  std::vector<double> r, v, w, eta, lambda;
  // … in the form's own variables …
  std::vector<double> x, x_dot, x_ddot;
  // … and what the other calls work on.
  std::vector<double> y, z, before;

  Implementation(System system, const SolverOptions& options) : forms(std::move(system), options) {
    for (std::vector<double>* array : {&r, &v, &w, &eta}) array->resize(num_numbers());
    for (std::vector<double>* array : {&x, &x_dot, &x_ddot}) array->resize(form.size());
    lambda.resize(model.num_rows());
    form.set_exact(true);
    if (forms.normal != nullptr) forms.normal->set_exact(true);
  }

  const Numbering& numbering() const { return model.numbering; }
  std::size_t num_numbers() const { return 3 * model.num_points(); }

  /// Positions and velocities (where there are some), with what is prescribed at supports.
  void gather(double time, std::span<const double> positions, std::span<const double> velocities,
              std::vector<double>* inner_r, std::vector<double>* inner_v) {
    check_size(positions, num_numbers(), "positions");
    inner_r->resize(num_numbers());
    inner_v->resize(num_numbers());
    numbering().gather_points(positions, *inner_r);
    if (!velocities.empty()) {
      check_size(velocities, num_numbers(), "velocities");
      numbering().gather_points(velocities, *inner_v);
    }
    model.prescribe_all(time, inner_r->data(), inner_v->data());
  }

  /// At t, r, v: w and what the form keeps.
  Outcome solve() {
    if (Outcome outcome = form.adopt(t, r.data(), v.data(), x.data(), x_dot.data()); !outcome.ok()) return outcome;
    Outcome outcome = form.accelerations(t, x.data(), x_dot.data(), Gradients::Evaluate, x_ddot.data());
    if (outcome.ok()) form.write_points(t, x.data(), x_dot.data(), x_ddot.data(), r.data(), v.data(), w.data());
    return outcome;
  }
};

Dynamics::Dynamics(System system, SolverOptions options)
    : implementation_(std::make_unique<Implementation>(std::move(system), options)) {}
Dynamics::Dynamics(Dynamics&&) noexcept = default;
Dynamics& Dynamics::operator=(Dynamics&&) noexcept = default;
Dynamics::~Dynamics() = default;

const System& Dynamics::system() const {
  return implementation_->model.system;
}
std::size_t Dynamics::num_points() const {
  return implementation_->numbering().num_points();
}
std::size_t Dynamics::num_equations() const {
  return implementation_->numbering().num_rows();
}
const PlanSummary& Dynamics::plan() const {
  return implementation_->forms.plan;
}
PhaseTimes Dynamics::phase_times() const {
  return implementation_->model.times;
}
Counters Dynamics::counters() const {
  return implementation_->model.counters;
}

SolveReport Dynamics::solve(double t, std::span<const double> positions, std::span<const double> velocities,
                            std::span<double> accelerations, std::span<double> multipliers,
                            std::span<double> reactions) {
  Implementation& self = *implementation_;
  const auto check_wanted = [](std::span<const double> array, std::size_t size, const char* name) {
    if (!array.empty()) check_size(array, size, name);
  };
  check_wanted(accelerations, self.num_numbers(), "accelerations");
  check_wanted(multipliers, num_equations(), "multipliers");
  check_wanted(reactions, self.num_numbers(), "reactions");
  self.gather(t, positions, velocities, &self.r, &self.v);
  self.t = t;
  if (Outcome outcome = self.solve(); !outcome.ok()) return {std::move(outcome)};
  const SolveReport report = self.form.last_solve();
  if (Outcome outcome = self.forms.reactions(t, self.r.data(), self.v.data(), self.lambda.data(), self.eta.data());
      !outcome.ok()) {
    return {std::move(outcome)};
  }
  if (!accelerations.empty()) self.numbering().scatter_points(self.w, accelerations);
  if (!multipliers.empty()) self.numbering().scatter_rows(self.lambda, multipliers);
  if (!reactions.empty()) self.numbering().scatter_points(self.eta, reactions);
  return report;
}

RankReport Dynamics::rank(bool thoroughly) {
  Implementation& self = *implementation_;
  return self.forms.rank(self.r.data(), thoroughly);
}

void Dynamics::active_forces(std::span<double> forces) const {
  check_size(forces, implementation_->num_numbers(), "forces");
  implementation_->numbering().scatter_points(implementation_->model.f, forces);
}

void Dynamics::support_forces(std::span<double> forces) const {
  const Implementation& self = *implementation_;
  check_size(forces, self.num_numbers(), "forces");
  // K lambda + f of the last solve, whatever was projected since
  for (std::size_t i = 0; i < self.model.num_points(); ++i) {
    const bool moves = i < self.model.num_moving();
    store(forces.data(), self.numbering().user_point[i],
          moves ? Vec3{} : load(self.eta.data(), i) + load(self.model.f.data(), i));
  }
}

Outcome Dynamics::split(std::span<double> tangent_accelerations, std::span<double> normal_accelerations) {
  Implementation& self = *implementation_;
  check_size(tangent_accelerations, self.num_numbers(), "tangent accelerations");
  check_size(normal_accelerations, self.num_numbers(), "normal accelerations");
  std::vector<double> normal(self.num_numbers());
  self.model.prescribe_all(self.t, self.r.data(), self.v.data());
  if (Outcome outcome = self.forms.normal->normal_accelerations(self.t, self.r.data(), self.v.data(), normal.data());
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

Certificate Dynamics::certify() {
  Implementation& self = *implementation_;
  Outcome outcome = self.solve();
  if (outcome.ok()) {
    outcome = self.forms.reactions(self.t, self.r.data(), self.v.data(), self.lambda.data(), self.eta.data());
  }
  if (!outcome.ok()) return make_failed_certificate(outcome);
  return tanor::certify(self.forms, {self.t, self.r, self.v, self.w, self.eta, self.lambda});
}

ProjectionReport Dynamics::project_positions(double t, std::span<double> positions) {
  Implementation& self = *implementation_;
  self.gather(t, positions, {}, &self.y, &self.z);
  self.before = self.y;
  ProjectionReport report = self.form.put_positions(t, self.y.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.y, positions);
  report.correction = self.model.largest_move(self.y.data(), self.before.data());
  return report;
}

ProjectionReport Dynamics::project_velocities(double t, std::span<const double> positions,
                                              std::span<double> velocities) {
  Implementation& self = *implementation_;
  self.gather(t, positions, velocities, &self.y, &self.z);
  self.before = self.z;
  ProjectionReport report = self.form.put_velocities(t, self.y.data(), self.z.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.z, velocities);
  report.correction = self.model.largest_move(self.z.data(), self.before.data());
  return report;
}

StartReport Dynamics::start(double t, std::span<double> positions, std::span<double> velocities, StartMode mode) {
  Implementation& self = *implementation_;
  self.gather(t, positions, velocities, &self.y, &self.z);
  const StartReport report = self.form.start(t, self.y.data(), self.z.data(), mode);
  if (report.outcome.ok()) {
    self.numbering().scatter_points(self.y, positions);
    self.numbering().scatter_points(self.z, velocities);
  }
  return report;
}

double Dynamics::position_violation(double t, std::span<const double> positions) {
  Implementation& self = *implementation_;
  self.gather(t, positions, {}, &self.y, &self.z);
  return self.model.position_violation(t, self.y.data());
}

double Dynamics::velocity_violation(double t, std::span<const double> positions, std::span<const double> velocities) {
  Implementation& self = *implementation_;
  self.gather(t, positions, velocities, &self.y, &self.z);
  return self.model.velocity_violation(t, self.y.data(), self.z.data());
}

}  // namespace tanor
