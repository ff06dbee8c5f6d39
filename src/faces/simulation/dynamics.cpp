#include <tanor/dynamics.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/check_size.hpp"
#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "certificate/certificate.hpp"
#include "dynamics/corner_functions.hpp"
#include "dynamics/forms.hpp"
#include "dynamics/friction_blocks.hpp"
#include "dynamics/prestress_rigidity.hpp"
#include "simulation/acceleration_split.hpp"
#include "simulation/reaction_decomposition.hpp"
#include "simulation/solution.hpp"
#include "system/enum_check.hpp"

namespace tanor {
using namespace detail;

/// A system with points as supports that a prestress holds more strongly than K tells.
struct HeldByPrestress {
  std::vector<Index> points;
  std::vector<std::size_t> unknown;  ///< their equations
  Dynamics dynamics;
};

/// Implementation of Dynamics. It reads and writes the host's arrays once a call.
struct Dynamics::Implementation {
  Forms forms;
  Workspace& work = forms.work;
  const Model& model = forms.model;
  EquationsOfMotion& form = *forms.main;
  CornerFunctions* const corners = form.corners();
  const SolverOptions options;
  SolvedInstant now;          // the state solved last, as the form answered
  bool stands_there = false;  // True if the forms are current for this state, as no later call changed them.
  // The state in the form's own variables, if these are not the points themselves, …
  const bool has_own_variables = !form.keeps_variables();
  std::vector<double> x, x_dot, x_ddot;
  // … as it was given, if the answer may have other points (those of coordinates, and contacts that come to rest) …
  const bool may_move_points = has_own_variables || model.has_friction() || !model.numbering.one_sided.empty();
  std::vector<double> given_r, given_v;
  // … and the work arrays of the other calls.
  std::vector<double> y, z, before;
  // They are made when first asked for, the last one where there are such points.
  struct {
    std::unique_ptr<AccelerationSplit> split;
    std::unique_ptr<ReactionDecomposition> causes;
    std::optional<HeldByPrestress> held;
  } made;

  Implementation(System system, const SolverOptions& given) : forms(std::move(system), given), options(given) {
    for (std::vector<double>* array : {&now.r, &now.v, &now.w}) array->resize(num_numbers());
    for (std::vector<double>* array : {&x, &x_dot, &x_ddot}) array->resize(has_own_variables ? form.size() : 0);
    now.lambda.resize(model.num_rows());
  }

  const Numbering& numbering() const { return model.numbering; }
  std::size_t num_numbers() const { return 3 * model.num_points(); }

  void check(const StateView& at) const {
    if (!std::isfinite(at.time)) throw InputError("", "t = " + text(at.time) + " is not a time");
    check_size(at.positions.size(), num_numbers(), "positions");
    if (!at.velocities.empty()) check_size(at.velocities.size(), num_numbers(), "velocities");
  }

  /// Gathers positions and velocities (at rest if none are given), with the prescribed motion of supports.
  void gather(const StateView& at, std::vector<double>* inner_r, std::vector<double>* inner_v) {
    check(at);
    inner_r->resize(num_numbers());
    inner_v->resize(num_numbers());
    numbering().gather_points(at.positions, *inner_r, model.parallel);
    if (at.velocities.empty())
      std::fill(inner_v->begin(), inner_v->end(), 0.0);
    else
      numbering().gather_points(at.velocities, *inner_v, model.parallel);
    work.prescribe_all(at.time, inner_r->data(), inner_v->data());
  }

  /// Requests a solution to rounding, and a failure if friction has several solutions.
  static constexpr Request demanding{.exact = true, .verification = Verification::Always, .refuses_several = true};

  /// Finds w and what belongs to it, and eta if `with_reactions` is true.
  const Outcome& solve(const StateView& at, bool with_reactions = false) {
    stands_there = false;  // stays false if a host's callable throws
    now.report = {};
    gather(at, &now.r, &now.v);
    now.t = at.time;
    if (may_move_points) {
      given_r = now.r;
      given_v = now.v;
    }
    now.outcome = find_accelerations();
    if (now.outcome.ok()) {
      now.eta.resize(with_reactions ? num_numbers() : 0);
      const Kinematics points{now.t, now.r.data(), now.v.data()},
          own = has_own_variables ? Kinematics{now.t, x.data(), x_dot.data()} : points;
      now.outcome = forms.reactions({own, points}, demanding, now.found, now.lambda.data(),
                                    with_reactions ? now.eta.data() : nullptr);
    }
    stands_there = true;
    return now.outcome;
  }

  /// Returns the system as a prestress holds it at the state where it stands, or null where none does. The equations
  /// alone would let these points move.
  HeldByPrestress* held_by_prestress() {
    if (forms.normal == nullptr || !forms.normal->linearization().dependences().is_found()) return nullptr;
    std::vector<Index> points = forms.rank(now.r.data(), false).prestress_rigid_points;
    if (points.empty()) return nullptr;
    std::optional<HeldByPrestress>& held = made.held;
    if (!held || held->points != points) {
      System system = model.system;
      hold_rigid_points(&system, points);
      std::vector<std::size_t> unknown = list_prestress_rigid_equations(model.system, points);
      held.emplace(std::move(points), std::move(unknown), Dynamics(std::move(system), options));
    }
    return &*held;
  }

  /// Fails by name if points stand in a corner of a guide, where no side of it holds.
  Outcome check_corners(const Kinematics& own) {
    if (corners == nullptr) return {};
    std::vector<double> arguments(corners->num_terms());
    corners->evaluate_terms(own, arguments.data());
    for (std::size_t k = 0; k < arguments.size(); ++k) {
      if (arguments[k] != 0.0) continue;
      if (Outcome stands = corners->check_standing(own, k); !stands.ok()) return stands;
    }
    return {};
  }

  Outcome find_accelerations() {
    if (!has_own_variables) {
      if (Outcome stands = check_corners({now.t, now.r.data(), now.v.data()}); !stands.ok()) return stands;
      return form.begin(now.t, now.r.data(), now.v.data(), demanding, {now.w.data(), nullptr, &now.report, &now.found});
    }
    if (Outcome outcome = form.set_state(now.t, now.r.data(), now.v.data(), x.data(), x_dot.data()); !outcome.ok())
      return outcome;
    if (Outcome stands = check_corners({now.t, x.data(), x_dot.data()}); !stands.ok()) return stands;
    if (Outcome outcome =
            form.begin(now.t, x.data(), x_dot.data(), demanding, {x_ddot.data(), nullptr, &now.report, &now.found});
        !outcome.ok())
      return outcome;
    form.write_points({now.t, x.data(), x_dot.data()}, x_ddot.data(), now.found, now.r.data(), now.v.data(),
                      now.w.data());
    return {};
  }

  /// Returns true if the host's arrays are those of the normal form, and accelerations and multipliers are all that is
  /// wanted. Then nothing needs to be copied.
  bool can_solve_in_place(const StateView& at, const SolveArrays& wanted) {
    const bool are_arrays_of_form = numbering().is_natural && &form == forms.normal.get() && !may_move_points;
    const bool wants_more = !wanted.reactions.empty() || !wanted.support_forces.empty() ||
                            !wanted.active_forces.empty() || !wanted.friction_forces.empty() ||
                            options.form == Form::Both;
    const auto is_apart = [&](std::span<const double> read) {
      const std::span<const double> written = wanted.accelerations;
      return std::less_equal<>()(written.data() + written.size(), read.data()) ||
             std::less_equal<>()(read.data() + read.size(), written.data());
    };
    if (!is_apart(at.positions) || !is_apart(at.velocities)) return false;
    return are_arrays_of_form && corners == nullptr && !at.velocities.empty() && !wanted.accelerations.empty() &&
           !wants_more && has_prescribed_supports(at);
  }
  /// Prescribes the accelerations of supports. Returns true if they stand and move in the host's arrays as prescribed.
  bool has_prescribed_supports(const StateView& at) {
    if (model.num_moving() == model.num_points()) return true;
    const std::size_t first = 3 * model.num_moving();
    for (const auto& [given, own] : {std::pair(at.positions, &y), std::pair(at.velocities, &z)}) {
      own->resize(num_numbers());
      std::ranges::copy(given.subspan(first), own->begin() + static_cast<std::ptrdiff_t>(first));
    }
    work.prescribe_all(at.time, y.data(), z.data());
    return std::ranges::equal(at.positions.subspan(first), std::span(y).subspan(first)) &&
           std::ranges::equal(at.velocities.subspan(first), std::span(z).subspan(first));
  }
  /// Finds w and lambda where the host's arrays stand. What is asked later about this state is solved anew.
  SolveReport solve_in_place(const StateView& at, const SolveArrays& wanted);

  /// Solves at this state, unless the forms are current for it and, if reactions are wanted, know them.
  const Outcome& stand_at(const StateView& at, bool with_reactions = false) {
    gather(at, &y, &z);
    const bool is_there = stands_there && at.time == now.t && y == (may_move_points ? given_r : now.r) &&
                          z == (may_move_points ? given_v : now.v);
    const bool is_enough = !with_reactions || !now.eta.empty() || !now.outcome.ok();
    return is_there && is_enough ? now.outcome : solve(at, with_reactions);
  }

  /// Moves to a state other than the one solved last, whose r is `y` and v is `z`.
  void leave_for(const StateView& at) {
    stands_there = false;
    gather(at, &y, &z);
  }

  void write_forces(const SolveArrays& wanted);
  void write_coordinates(const SolveArrays& wanted) const;
};

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
  std::string why_not;
  (void)live(implementation_, "Dynamics").forms.main->series(&why_not);
  return why_not;
}

const PlanSummary& Dynamics::plan() const {
  return live(implementation_, "Dynamics").forms.plan;
}
PhaseTimes Dynamics::phase_times() const {
  return live(implementation_, "Dynamics").work.times;
}
Counters Dynamics::counters() const {
  return live(implementation_, "Dynamics").work.counters;
}

/// Writes the load that supports carry (K lambda + f there), f and tau, for which the forms must be current.
void Dynamics::Implementation::write_forces(const SolveArrays& wanted) {
  if (!wanted.support_forces.empty()) {
    for (std::size_t i = 0; i < model.num_points(); ++i) {
      const bool moves = i < model.num_moving();
      store(wanted.support_forces.data(), numbering().user_point[i],
            moves ? Vec3{} : load(now.eta.data(), i) + load(work.f.data(), i));
    }
  }
  if (!wanted.active_forces.empty()) numbering().scatter_points(work.f, wanted.active_forces);
  if (wanted.friction_forces.empty()) return;
  std::vector<double> friction(num_numbers());
  form.write_friction(now.found, friction.data());
  numbering().scatter_points(friction, wanted.friction_forces);
}

void Dynamics::Implementation::write_coordinates(const SolveArrays& wanted) const {
  const auto write = [&](const std::vector<double>& inner, std::span<double> users) {
    if (!users.empty()) work.coordinates.scatter(inner.data(), users.data());
  };
  write(x, wanted.coordinates);
  write(x_dot, wanted.coordinate_rates);
  write(x_ddot, wanted.coordinate_accelerations);
}

SolveReport Dynamics::Implementation::solve_in_place(const StateView& at, const SolveArrays& wanted) {
  stands_there = false;
  SolveReport report;
  const Kinematics points{at.time, at.positions.data(), at.velocities.data()};
  report.outcome =
      form.accelerations(points, demanding.evaluated_anew(), {wanted.accelerations.data(), nullptr, &report, nullptr});
  if (!report.outcome.ok() || wanted.multipliers.empty()) return report;
  const std::vector<double>* lambda = &forms.normal->dynamics().multipliers();
  if (forms.normal->linearization().dependences().is_found()) {
    now.lambda = *lambda;
    forms.normal->minimize_multipliers(points, now.lambda.data());
    lambda = &now.lambda;
  }
  numbering().scatter_rows(*lambda, wanted.multipliers, model.parallel);
  return report;
}

SolveReport Dynamics::solve(const StateView& at, const SolveArrays& wanted) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  const auto check_wanted = [](std::span<const double> array, std::size_t size, const char* name) {
    if (!array.empty()) check_size(array.size(), size, name);
  };
  const std::size_t num_coordinates = self.forms.is_tangent() ? plan().coordinates : 0;
  check_wanted(wanted.accelerations, self.num_numbers(), "accelerations");
  check_wanted(wanted.multipliers, num_equations(), "multipliers");
  check_wanted(wanted.reactions, self.num_numbers(), "reactions");
  check_wanted(wanted.support_forces, self.num_numbers(), "support_forces");
  check_wanted(wanted.active_forces, self.num_numbers(), "active_forces");
  check_wanted(wanted.friction_forces, self.num_numbers(), "friction_forces");
  check_wanted(wanted.coordinates, num_coordinates, "coordinates");
  check_wanted(wanted.coordinate_rates, num_coordinates, "coordinate_rates");
  check_wanted(wanted.coordinate_accelerations, num_coordinates, "coordinate_accelerations");
  self.check(at);
  if (self.can_solve_in_place(at, wanted)) return self.solve_in_place(at, wanted);
  const bool with_reactions =
      !wanted.reactions.empty() || !wanted.support_forces.empty() || self.options.form == Form::Both;
  Outcome outcome = self.solve(at, with_reactions);
  SolveReport report = self.now.report;
  report.outcome = std::move(outcome);
  if (!report.outcome.ok()) return report;
  if (self.options.form == Form::Both) {
    if (Outcome compared = self.forms.compare({at.time, self.now.r.data(), self.now.v.data()}, self.demanding,
                                              self.now.w.data(), self.now.eta.data(), &report.forms_disagreement);
        !compared.ok()) {
      report.outcome = std::move(compared);
      return report;
    }
  }
  if (!wanted.accelerations.empty())
    self.numbering().scatter_points(self.now.w, wanted.accelerations, self.model.parallel);
  if (!wanted.multipliers.empty())
    self.numbering().scatter_rows(self.now.lambda, wanted.multipliers, self.model.parallel);
  if (!wanted.reactions.empty()) self.numbering().scatter_points(self.now.eta, wanted.reactions, self.model.parallel);
  self.write_forces(wanted);
  self.write_coordinates(wanted);
  return report;
}

Solution Dynamics::solution(const StateView& at) {
  Implementation& self = live(implementation_, "Dynamics");
  Solution now = make_solution(system(), self.forms.is_tangent() ? plan().coordinates : 0);
  now.time = at.time;
  now.outcome = solve(at, {.accelerations = now.accelerations,
                           .multipliers = now.multipliers,
                           .reactions = now.reactions,
                           .support_forces = now.support_forces,
                           .coordinates = now.coordinates,
                           .coordinate_rates = now.coordinate_rates})
                    .outcome;
  self.numbering().scatter_points(self.now.r, now.positions);
  self.numbering().scatter_points(self.now.v, now.velocities);
  now.position_violation = self.work.position_violation(at.time, self.now.r.data());
  now.degrees_of_freedom = static_cast<std::size_t>(self.forms.degrees_of_freedom());
  if (auto* const held = self.held_by_prestress()) {
    now = held->dynamics.solution(at);
    forget_equations(system(), held->unknown, &now);
  } else {
    now.self_stress = find_self_stress(self.forms);
  }
  return now;
}

RankReport Dynamics::rank(const StateView& at, bool thoroughly) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  // The rank is also defined if the accelerations have no solution.
  if (!self.stand_at(at).ok() && self.forms.normal != nullptr)
    (void)self.forms.normal->linearise(at.time, self.now.r.data());
  return self.forms.rank(self.now.r.data(), thoroughly);
}

Split Dynamics::split(const StateView& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  const std::size_t size = self.num_numbers(), moving = 3 * self.numbering().num_moving;
  std::vector<double> w_N(size), f_N(size), rest(size, 0.0);
  Split result;
  result.outcome = self.stand_at(at);
  if (auto* const held = self.held_by_prestress()) return held->dynamics.split(at);
  if (result.outcome.ok()) {
    if (!self.made.split) self.made.split = std::make_unique<AccelerationSplit>(self.forms);
    result.outcome = self.made.split->find(self.now, w_N.data(), f_N.data());
  }
  if (!result.outcome.ok()) return result;
  // u_T = u - u_N; both are 0 at supports.
  const auto write = [&](const std::vector<double>& u, const std::vector<double>& u_N, std::vector<double>* tangent,
                         std::vector<double>* normal) {
    tangent->resize(size);
    normal->resize(size);
    for (std::size_t i = 0; i < moving; ++i) rest[i] = u[i] - u_N[i];
    self.numbering().scatter_points(rest, *tangent);
    self.numbering().scatter_points(u_N, *normal);
  };
  write(self.now.w, w_N, &result.tangent_accelerations, &result.normal_accelerations);
  write(self.work.f, f_N, &result.tangent_forces, &result.normal_forces);
  write(self.made.split->friction(), self.made.split->normal_friction(), &result.tangent_friction,
        &result.normal_friction);
  result.mass_coupling = self.made.split->mass_coupling();
  return result;
}

ReactionsByCause Dynamics::reactions_by_cause(const StateView& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  ReactionsByCause result{self.stand_at(at), {}};
  if (auto* const held = self.held_by_prestress()) {
    result = held->dynamics.reactions_by_cause(at);
    for (ReactionPart& part : result.parts)
      forget_equations(system(), held->unknown, &part.multipliers, {&part.reactions});
    return result;
  }
  if (!result.outcome.ok()) return result;
  if (!self.made.causes) self.made.causes = std::make_unique<ReactionDecomposition>(self.forms);
  result.parts =
      self.made.causes->find(self.now.t, self.now.r.data(), self.now.v.data(), self.x.data(), self.x_dot.data());
  return result;
}

FrictionBlocks Dynamics::friction_by_blocks(const StateView& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  FrictionBlocks result{.outcome = self.stand_at(at), .multipliers = {}, .friction = {}};
  if (!result.outcome.ok()) return result;
  if (!self.model.has_friction()) throw InputError("/friction", "there is none, so that nothing is to be found");
  constexpr int most_iterations = 2000;
  result.outcome = iterate_friction_blocks(*self.forms.normal, self.work, {self.now.t, self.now.r, self.now.v},
                                           most_iterations, &result);
  return result;
}

Certificate Dynamics::certify(const StateView& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  const Outcome& outcome = self.stand_at(at, true);
  if (auto* const held = self.held_by_prestress()) return held->dynamics.certify(at);
  if (!outcome.ok()) return make_failed_certificate(outcome);
  self.stands_there = false;  // certifying evaluates the other form, and other times
  std::vector<double> tau(self.num_numbers());
  self.form.write_friction(self.now.found, tau.data());
  return detail::certify(self.forms, {self.now.t, self.now.r, self.now.v, self.now.w, self.now.eta, self.now.lambda,
                                      tau, self.now.report.friction});
}

ProjectionReport Dynamics::project_positions(const MutableState& state) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.leave_for({.time = state.time, .positions = state.positions});
  self.before = self.y;
  ProjectionReport report = self.form.project_point_positions(state.time, self.y.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.y, state.positions);
  report.correction = self.model.largest_move(self.y.data(), self.before.data());
  return report;
}

ProjectionReport Dynamics::project_velocities(const MutableVelocities& state) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  check_size(state.velocities.size(), self.num_numbers(), "velocities");
  self.leave_for({.time = state.time, .positions = state.positions, .velocities = state.velocities});
  self.before = self.z;
  ProjectionReport report = self.form.project_point_velocities(state.time, self.y.data(), self.z.data());
  if (report.outcome.ok()) self.numbering().scatter_points(self.z, state.velocities);
  report.correction = self.model.largest_move(self.z.data(), self.before.data());
  return report;
}

StartReport Dynamics::start(const MutableState& state, StartMode mode) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  check_enum(mode, StartMode::Project, "/motion/start");
  check_size(state.velocities.size(), self.num_numbers(), "velocities");
  self.leave_for({.time = state.time, .positions = state.positions, .velocities = state.velocities});
  StartReport report = self.forms.start(state.time, self.y.data(), self.z.data(), mode);
  if (report.outcome.ok()) {
    self.numbering().scatter_points(self.y, state.positions);
    self.numbering().scatter_points(self.z, state.velocities);
  }
  return report;
}

double Dynamics::position_violation(const StateView& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.leave_for(at);
  return self.work.position_violation(at.time, self.y.data());
}

double Dynamics::velocity_violation(const StateView& at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Dynamics");
  self.leave_for(at);
  return self.work.velocity_violation(at.time, self.y.data(), self.z.data());
}

}  // namespace tanor
