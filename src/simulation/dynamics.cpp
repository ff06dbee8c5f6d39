#include <tanor/dynamics.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "certificate/certificate.hpp"
#include "dynamics/forms.hpp"
#include "dynamics/friction_blocks.hpp"
#include "dynamics/split.hpp"
#include "simulation/causes.hpp"
#include "simulation/solution.hpp"
#include "system/enum_check.hpp"

namespace tanor {

namespace {

void check_size(std::span<const double> array, std::size_t wanted, const char* name) {
  if (array.size() != wanted) {
    throw InputError("", std::string(name) + " has " + std::to_string(array.size()) + " numbers; " +
                             std::to_string(wanted) + " are needed");
  }
}

/// Numbers that nothing holds for by chance, the same ones each time.
std::vector<double> random_numbers(std::size_t count) {
  std::mt19937 generator(44);
  std::normal_distribution<double> normal;
  std::vector<double> result(count);
  for (double& number : result) number = normal(generator);
  return result;
}

constexpr double smallest_number = std::numeric_limits<double>::min();

}  // namespace

/// One gather, one scatter: the host's arrays are read and written once a call.
struct Dynamics::Implementation {
  Forms forms;
  Model& model = forms.model;
  EquationsOfMotion& form = *forms.main;
  const Form form_wanted;
  // In the inner order, the last solve …
  double t = 0.0;
  std::vector<double> r, v, w, eta, lambda;
  // … in the form's own variables …
  std::vector<double> x, x_dot, x_ddot;
  // … and what the other calls work on.
  std::vector<double> y, z, before;
  // The forms stand where the last solve was; no later call took them elsewhere.
  bool is_there = false, has_solved = false;
  // Made when first asked for.
  std::unique_ptr<NormalSpace> normal_space;
  std::unique_ptr<TangentSpace> tangent_space;
  std::unique_ptr<Causes> causes;

  Implementation(System system, const SolverOptions& options)
      : forms(std::move(system), options), form_wanted(options.form) {
    for (std::vector<double>* array : {&r, &v, &w, &eta}) array->resize(num_numbers());
    for (std::vector<double>* array : {&x, &x_dot, &x_ddot}) array->resize(form.size());
    lambda.resize(model.num_rows());
  }

  const Numbering& numbering() const { return model.numbering; }
  std::size_t num_numbers() const { return 3 * model.num_points(); }

  /// Positions and velocities (where there are some), with what is prescribed at supports.
  void gather(double time, std::span<const double> positions, std::span<const double> velocities,
              std::vector<double>* inner_r, std::vector<double>* inner_v) {
    if (!std::isfinite(time)) throw InputError("", "t = " + text(time) + " is not a time");
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

  /// One instant is solved to rounding, and asks for other solutions.
  static constexpr Request demanding{.exact = true, .judgement = Judgement::Thorough, .refuses_several = true};

  /// At t, r, v: w and what the form keeps.
  Outcome solve() {
    if (Outcome outcome = form.adopt(t, r.data(), v.data(), x.data(), x_dot.data()); !outcome.ok()) return outcome;
    Outcome outcome = form.begin(t, x.data(), x_dot.data(), demanding, x_ddot.data());
    if (!outcome.ok()) return outcome;
    form.write_points(t, x.data(), x_dot.data(), x_ddot.data(), r.data(), v.data(), w.data());
    outcome = forms.reactions({t, r.data(), v.data()}, demanding, lambda.data(), eta.data());
    is_there = outcome.ok();
    return outcome;
  }

  /// Back to the last solve, where a later call took the forms elsewhere.
  Outcome come_back() {
    if (!has_solved) throw InputError("", "nothing was solved so far: solve comes before what looks at its answer");
    if (is_there) return {};
    model.prescribe_all(t, r.data(), v.data());
    return solve();
  }

  Outcome split(double* w_N, double* f_N);
  Outcome split_by_constraints(double* w_N, double* f_N);
  Outcome split_by_coordinates(double* w_N, double* f_N);
  double mass_coupling = 0.0;        // of the last split
  std::vector<double> tau, tau_N;    // [3n] likewise
  std::vector<double> split_blocks;  // of K without what sticks
};

/// w_N and f_N of the last solve.
Outcome Dynamics::Implementation::split(double* w_N, double* f_N) {
  if (Outcome outcome = come_back(); !outcome.ok()) return outcome;
  tau.resize(num_numbers());
  tau_N.assign(num_numbers(), 0.0);
  forms.friction_forces(tau.data());
  return forms.normal != nullptr ? split_by_constraints(w_N, f_N) : split_by_coordinates(w_N, f_N);
}

Outcome Dynamics::Implementation::split_by_constraints(double* w_N, double* f_N) {
  NormalForm& normal = *forms.normal;
  // The factor of S knows what sticks, the split does not.
  const bool one_mass_serves = has_one_mass(model) && normal.events() == nullptr;
  if (!normal_space) normal_space = std::make_unique<NormalSpace>(model, one_mass_serves ? &normal : nullptr);
  if (normal.events() != nullptr) split_blocks = model.without_contacts(normal.blocks());
  const std::vector<double>& blocks = normal.events() != nullptr ? split_blocks : normal.blocks();
  if (Outcome outcome = normal_space->factorize(t, r.data(), blocks.data()); !outcome.ok()) return outcome;
  std::vector<double> c(model.num_rows()), mu(model.num_rows()), given(num_numbers(), 0.0);
  std::copy(model.support_accelerations.begin(), model.support_accelerations.end(),
            given.begin() + static_cast<std::ptrdiff_t>(3 * model.num_moving()));
  // K'w_N = -phi, with the supports' accelerations in phi (21)
  model.constraints.evaluate_right_side(model.parallel, r.data(), v.data(), given.data(), c.data(), nullptr);
  for (double& each : c) each = -each;
  for (std::size_t a = 0; a < c.size(); ++a) {
    if (static_cast<std::size_t>(numbering().user_row[a]) >= numbering().num_user_rows) c[a] = 0.0;
  }
  normal_space->find_least(c.data(), w_N, mu.data());
  normal_space->project(model.f.data(), f_N, mu.data());
  normal_space->project(tau.data(), tau_N.data(), mu.data());

  // (44): M^-1 K x stays in N?
  std::vector<double> u(num_numbers(), 0.0), u_N(num_numbers());
  const std::vector<double> any = random_numbers(model.num_rows());
  model.gather.add_scaled(model.parallel, blocks.data(), any.data(), model.inverse_mass.data(), model.num_moving(),
                          u.data());
  normal_space->project(u.data(), u_N.data(), mu.data());
  mass_coupling = model.largest_move(u.data(), u_N.data()) / std::max(model.largest_norm(u.data()), smallest_number);
  return {};
}

Outcome Dynamics::Implementation::split_by_coordinates(double* w_N, double* f_N) {
  const TangentForm& tangent = *forms.tangent;
  if (!tangent_space) tangent_space = std::make_unique<TangentSpace>(model);
  if (Outcome outcome = tangent_space->factorize(t, tangent.blocks().data()); !outcome.ok()) return outcome;
  // u_N = (I - A G^-1 A') u (22)
  const auto normal_part = [&](const std::vector<double>& u, double* u_N) {
    tangent_space->project(u.data(), u_N);
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i) u_N[i] = u[i] - u_N[i];
  };
  normal_part(tangent.psi(), w_N);
  normal_part(model.f, f_N);
  std::fill(tau_N.begin(), tau_N.end(), 0.0);  // coordinates alone name no guides

  // (44): M A x stays in T?
  std::vector<double> u(num_numbers(), 0.0), u_N(num_numbers(), 0.0);
  const std::vector<double> any = random_numbers(tangent.size());
  model.coordinates.apply(model.parallel, tangent.blocks().data(), any.data(), u.data());
  for (std::size_t i = 0; i < u.size(); ++i) u[i] *= model.mass[i / 3];
  normal_part(u, u_N.data());
  mass_coupling = model.largest_norm(u_N.data()) / std::max(model.largest_norm(u.data()), smallest_number);
  return {};
}

Dynamics::Dynamics(System system, SolverOptions options)
    : implementation_(make_quietly<Implementation>(std::move(system), options)) {}
Dynamics::Dynamics(Dynamics&&) noexcept = default;
Dynamics& Dynamics::operator=(Dynamics&&) noexcept = default;
Dynamics::~Dynamics() = default;

const System& Dynamics::system() const {
  return live(implementation_, "Dynamics").model.system;
}
std::size_t Dynamics::num_points() const {
  return live(implementation_, "Dynamics").numbering().num_points();
}
std::size_t Dynamics::num_equations() const {
  return live(implementation_, "Dynamics").numbering().num_user_rows;
}
std::string Dynamics::series_obstacle() const {
  return live(implementation_, "Dynamics").forms.main->why_no_series();
}

const PlanSummary& Dynamics::plan() const {
  return live(implementation_, "Dynamics").forms.plan;
}
PhaseTimes Dynamics::phase_times() const {
  return live(implementation_, "Dynamics").model.times;
}
Counters Dynamics::counters() const {
  return live(implementation_, "Dynamics").model.counters;
}

SolveReport Dynamics::solve(double t, std::span<const double> positions, std::span<const double> velocities,
                            std::span<double> accelerations, std::span<double> multipliers,
                            std::span<double> reactions) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  const auto check_wanted = [](std::span<const double> array, std::size_t size, const char* name) {
    if (!array.empty()) check_size(array, size, name);
  };
  check_wanted(accelerations, self.num_numbers(), "accelerations");
  check_wanted(multipliers, num_equations(), "multipliers");
  check_wanted(reactions, self.num_numbers(), "reactions");
  self.gather(t, positions, velocities, &self.r, &self.v);
  self.t = t;
  self.is_there = false;
  self.has_solved = true;
  Outcome solved = self.solve();
  SolveReport report = self.form.last_solve();
  report.outcome = std::move(solved);
  if (!report.outcome.ok()) return report;
  if (self.form_wanted == Form::Both) {
    if (Outcome outcome = self.forms.compare({t, self.r.data(), self.v.data()}, self.demanding, self.w.data(),
                                             self.eta.data(), &report.forms_disagreement);
        !outcome.ok()) {
      report.outcome = std::move(outcome);
      return report;
    }
  }
  if (!accelerations.empty()) self.numbering().scatter_points(self.w, accelerations);
  if (!multipliers.empty()) self.numbering().scatter_rows(self.lambda, multipliers);
  if (!reactions.empty()) self.numbering().scatter_points(self.eta, reactions);
  return report;
}

Solution Dynamics::solution(double t, std::span<const double> positions, std::span<const double> velocities) {
  Solution at = make_solution(system());
  at.time = t;
  at.outcome = solve(t, positions, velocities, at.accelerations, at.multipliers, at.reactions).outcome;
  Implementation& self = *implementation_;
  self.numbering().scatter_points(self.r, at.positions);
  self.numbering().scatter_points(self.v, at.velocities);
  at.position_violation = self.model.position_violation(t, self.r.data());
  if (at.outcome.ok()) support_forces(at.support_forces);
  return at;
}

RankReport Dynamics::rank(bool thoroughly) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  return self.forms.rank(self.r.data(), thoroughly);
}

void Dynamics::active_forces(std::span<double> forces) const {
  check_size(forces, live(implementation_, "Dynamics").num_numbers(), "forces");
  live(implementation_, "Dynamics").numbering().scatter_points(live(implementation_, "Dynamics").model.f, forces);
}

void Dynamics::friction_forces(std::span<double> forces) const {
  Implementation& self = live(implementation_, "Dynamics");
  check_size(forces, self.num_numbers(), "forces");
  std::vector<double> tau(self.num_numbers());
  self.forms.friction_forces(tau.data());
  self.numbering().scatter_points(tau, forces);
}

void Dynamics::coordinates(std::span<double> q, std::span<double> q_dot, std::span<double> q_ddot) const {
  const Implementation& self = live(implementation_, "Dynamics");
  const std::size_t wanted = self.forms.is_tangent() ? plan().coordinates : 0;
  const auto write = [&](const std::vector<double>& inner, std::span<double> users, const char* name) {
    if (users.empty()) return;
    check_size(users, wanted, name);
    self.model.coordinates.scatter(inner.data(), users.data());
  };
  write(self.x, q, "q");
  write(self.x_dot, q_dot, "q_dot");
  write(self.x_ddot, q_ddot, "q_ddot");
}

void Dynamics::support_forces(std::span<double> forces) const {
  const Implementation& self = live(implementation_, "Dynamics");
  check_size(forces, self.num_numbers(), "forces");
  // K lambda + f of the last solve, whatever was projected since
  for (std::size_t i = 0; i < self.model.num_points(); ++i) {
    const bool moves = i < self.model.num_moving();
    store(forces.data(), self.numbering().user_point[i],
          moves ? Vec3{} : load(self.eta.data(), i) + load(self.model.f.data(), i));
  }
}

Split Dynamics::split() {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  const std::size_t size = self.num_numbers(), moving = 3 * self.numbering().num_moving;
  std::vector<double> w_N(size), f_N(size), rest(size, 0.0);
  Split result;
  result.outcome = self.split(w_N.data(), f_N.data());
  if (!result.outcome.ok()) return result;
  // u_T = u - u_N; supports have no part in either.
  const auto write = [&](const std::vector<double>& u, const std::vector<double>& u_N, std::vector<double>* tangent,
                         std::vector<double>* normal) {
    tangent->resize(size);
    normal->resize(size);
    for (std::size_t i = 0; i < moving; ++i) rest[i] = u[i] - u_N[i];
    self.numbering().scatter_points(rest, *tangent);
    self.numbering().scatter_points(u_N, *normal);
  };
  write(self.w, w_N, &result.tangent_accelerations, &result.normal_accelerations);
  write(self.model.f, f_N, &result.tangent_forces, &result.normal_forces);
  write(self.tau, self.tau_N, &result.tangent_friction, &result.normal_friction);
  result.mass_coupling = self.mass_coupling;
  return result;
}

ReactionsByCause Dynamics::reactions_by_cause() {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  ReactionsByCause result{self.come_back(), {}};
  if (!result.outcome.ok()) return result;
  if (!self.causes) self.causes = std::make_unique<Causes>(self.forms);
  result.parts = self.causes->find(self.t, self.r.data(), self.v.data(), self.x.data(), self.x_dot.data());
  return result;
}

FrictionBlocks Dynamics::friction_by_blocks() {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  FrictionBlocks result{.outcome = self.come_back(), .multipliers = {}, .friction = {}};
  if (!result.outcome.ok()) return result;
  if (!self.model.has_friction()) throw InputError("/friction", "there is none: (43) has nothing to find");
  constexpr int most_iterations = 2000;
  result.outcome =
      iterate_friction_blocks(*self.forms.normal, self.model, {self.t, self.r, self.v}, most_iterations, &result);
  return result;
}

Certificate Dynamics::certify() {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  if (Outcome outcome = self.solve(); !outcome.ok()) return make_failed_certificate(outcome);
  self.is_there = false;  // the other form, and other times, are tried
  std::vector<double> tau(self.num_numbers());
  self.forms.friction_forces(tau.data());
  return tanor::certify(self.forms, {self.t, self.r, self.v, self.w, self.eta, self.lambda, tau});
}

ProjectionReport Dynamics::project_positions(double t, std::span<double> positions) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.is_there = false;
  self.gather(t, positions, {}, &self.y, &self.z);
  self.before = self.y;
  ProjectionReport report = self.form.put_positions(t, self.y.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.y, positions);
  report.correction = self.model.largest_move(self.y.data(), self.before.data());
  return report;
}

ProjectionReport Dynamics::project_velocities(double t, std::span<const double> positions,
                                              std::span<double> velocities) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.is_there = false;
  self.gather(t, positions, velocities, &self.y, &self.z);
  self.before = self.z;
  ProjectionReport report = self.form.put_velocities(t, self.y.data(), self.z.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.z, velocities);
  report.correction = self.model.largest_move(self.z.data(), self.before.data());
  return report;
}

StartReport Dynamics::start(double t, std::span<double> positions, std::span<double> velocities, StartMode mode) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.is_there = false;
  check_enum(mode, StartMode::Project, "/motion/start");
  self.gather(t, positions, velocities, &self.y, &self.z);
  StartReport report = self.forms.start(t, self.y.data(), self.z.data(), mode);
  if (report.outcome.ok()) {
    self.numbering().scatter_points(self.y, positions);
    self.numbering().scatter_points(self.z, velocities);
  }
  return report;
}

double Dynamics::position_violation(double t, std::span<const double> positions) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.is_there = false;
  self.gather(t, positions, {}, &self.y, &self.z);
  return self.model.position_violation(t, self.y.data());
}

double Dynamics::velocity_violation(double t, std::span<const double> positions, std::span<const double> velocities) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.is_there = false;
  self.gather(t, positions, velocities, &self.y, &self.z);
  return self.model.velocity_violation(t, self.y.data(), self.z.data());
}

}  // namespace tanor
