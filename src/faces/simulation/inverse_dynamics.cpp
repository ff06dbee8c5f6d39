#include <tanor/inverse_dynamics.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/check_size.hpp"
#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "base/text.hpp"
#include "dynamics/split.hpp"
#include "simulation/inverse_friction.hpp"
#include "system/one_sided.hpp"

namespace tanor {
using namespace detail;

namespace {

void check_time(double t) {
  if (!std::isfinite(t)) throw InputError("", "t = " + text(t) + " is not a time");
}

}  // namespace

struct InverseDynamics::Implementation {
  Workspace work;
  const Model& model{work.model()};
  std::optional<NormalSpace> normal;    // empty if coordinates alone are given
  std::optional<TangentSpace> tangent;  // empty otherwise
  std::optional<InverseFriction> friction;
  std::vector<double> blocks;       // blocks of K or A
  std::vector<double> row_norms;    // [rows] largest |gradient| at one of its points
  std::vector<double> r, v, w, w0;  // [3n] inner
  std::vector<double> q, q_dot;     // [s]

  static System without_sides(System system) {
    refuse_sides(system, "inverse dynamics knows both sides alone");
    return system;
  }

  Implementation(System system, const SolverOptions& options)
      : work(without_sides(std::move(system)), options, 0.0),
        row_norms(model.num_rows()),
        q(work.coordinates.num_coordinates()),
        q_dot(q.size()) {
    for (std::vector<double>* array : {&r, &v, &w, &w0}) array->resize(size());
    if (work.coordinates.empty() || model.num_rows() > 0) {
      normal.emplace(work);
      if (model.has_friction()) friction.emplace(work, *normal);
      blocks.resize(3 * work.constraints.num_blocks());
    } else {
      tangent.emplace(work);
      blocks.resize(3 * work.coordinates.num_blocks());
      work.coordinates.write_start(q.data(), q_dot.data());
    }
  }

  std::size_t size() const { return 3 * model.num_points(); }
  std::size_t moving() const { return 3 * model.num_moving(); }

  std::string name_point(std::size_t inner) const { return "point " + text(model.numbering.user_point[inner]); }

  /// Raises the violation to |x_i - y_i|/scale if that is larger, over a range of inner points.
  void compare(const std::vector<double>& x, const std::vector<double>& y, double scale, std::size_t begin,
               std::size_t end, Violation* violation) const {
    for (std::size_t i = begin; i < end; ++i) {
      const double by = norm(load(x.data(), i) - load(y.data(), i)) / scale;
      if (by > violation->largest) *violation = {by, name_point(i)};
    }
  }
  void compare(const std::vector<double>& rows, Violation* violation) const {
    for (std::size_t a = 0; a < rows.size(); ++a) {
      if (std::abs(rows[a]) > violation->largest) *violation = {std::abs(rows[a]), work.name_row(a)};
    }
  }

  MotionForces evaluate(double t, const MotionState& points);
  void put_supports(double t, MotionForces* result);
  Outcome measure_constraints(double t, MotionForces* result);
  Outcome measure_coordinates(double t, MotionForces* result);
  Outcome divide_force(double t, MotionForces* result);
};

/// Places supports as prescribed and measures by how much the given motion differs.
void InverseDynamics::Implementation::put_supports(double t, MotionForces* result) {
  const std::vector<double> r_given = r, v_given = v, w_given = w;
  work.prescribe_all(t, r.data(), v.data());
  work.write_support_accelerations(t, w.data());
  const std::size_t first = model.num_moving(), end = model.num_points();
  compare(r_given, r, model.scene_size, first, end, &result->position);
  compare(v_given, v, 1.0, first, end, &result->velocity);
  compare(w_given, w, 1.0, first, end, &result->acceleration);
}

Outcome InverseDynamics::Implementation::measure_constraints(double t, MotionForces* result) {
  std::vector<double> position(model.num_rows()), velocity(position), acceleration(position);
  if (!position.empty()) {
    work.constraints.measure(r.data(), v.data(), position.data(), velocity.data());
    // K'w + phi
    work.constraints.evaluate_right_side(model.parallel, r.data(), v.data(), w.data(), acceleration.data(),
                                         blocks.data());
    std::fill(row_norms.begin(), row_norms.end(), 0.0);
    for (const Incidence& incidence : model.incidences) {
      double& largest = row_norms[static_cast<std::size_t>(incidence.row)];
      largest = std::max(largest, norm(load(blocks.data(), incidence.block)));
    }
    for (double& length : row_norms) length = length > 0.0 ? length : 1.0;  // rows of contacts
    for (std::size_t a = 0; a < acceleration.size(); ++a) acceleration[a] /= row_norms[a];
  }
  compare(position, &result->position);
  compare(velocity, &result->velocity);
  compare(acceleration, &result->acceleration);
  return normal->factorize(t, r.data(), blocks.data());
}

/// Measures how far r, v, w are from what coordinates allow: the nearest r(q, t), A q_dot + r_t and A q_ddot + psi.
Outcome InverseDynamics::Implementation::measure_coordinates(double t, MotionForces* result) {
  std::vector<double> places = r, rates = v, psi(size()), part(size()), rest(size(), 0.0);
  const std::vector<double> no_rates(q.size(), 0.0);
  work.coordinates.locate(r.data(), q.data());
  work.coordinates.evaluate(model.parallel, q.data(), no_rates.data(), places.data(), rates.data(), psi.data(),
                            blocks.data());
  compare(r, places, model.scene_size, 0, model.num_moving(), &result->position);
  if (Outcome outcome = tangent->factorize(t, blocks.data()); !outcome.ok()) return outcome;
  // G q_dot = A'(v - r_t)
  for (std::size_t i = 0; i < moving(); ++i) rest[i] = v[i] - rates[i];
  tangent->project(rest.data(), part.data(), q_dot.data());
  compare(rest, part, 1.0, 0, model.num_moving(), &result->velocity);
  work.coordinates.evaluate(model.parallel, q.data(), q_dot.data(), places.data(), rates.data(), psi.data(), nullptr);
  for (std::size_t i = 0; i < moving(); ++i) rest[i] = w[i] - psi[i];
  tangent->project(rest.data(), part.data());
  compare(rest, part, 1.0, 0, model.num_moving(), &result->acceleration);
  return {};
}

/// Divides the force: Mw - f - tau = eta + u_T.
Outcome InverseDynamics::Implementation::divide_force(double t, MotionForces* result) {
  std::vector<double> force(size(), 0.0), tau(size(), 0.0), eta(size(), 0.0), control(size(), 0.0);
  for (std::size_t i = 0; i < moving(); ++i) force[i] = model.mass[i / 3] * w[i] - work.f[i];
  if (friction) {
    if (Outcome outcome = friction->find(t, r, v, blocks, force, &tau); !outcome.ok()) return outcome;
    for (std::size_t i = 0; i < moving(); ++i) force[i] -= tau[i];
  }
  if (normal) {
    std::vector<double> lambda(model.num_rows(), 0.0);
    normal->project(force.data(), eta.data(), lambda.data());
    for (std::size_t i = 0; i < moving(); ++i) control[i] = force[i] - eta[i];
    model.gather.reactions(model.parallel, blocks.data(), lambda.data(), eta.data());
    result->multipliers.resize(model.numbering.num_user_rows);
    model.numbering.scatter_rows(lambda, result->multipliers);
  } else {
    tangent->project(force.data(), control.data());
    for (std::size_t i = 0; i < moving(); ++i) eta[i] = force[i] - control[i];
    work.coordinates.add_support_reactions(eta.data());
  }
  for (std::size_t i = 0; i < model.num_moving(); ++i) {
    const double by = norm(load(control.data(), i));
    if (by <= result->largest_control) continue;
    result->largest_control = by;
    result->controlled_point = model.numbering.user_point[i];
  }
  for (std::vector<double>* array : {&result->reactions, &result->control_forces, &result->support_forces}) {
    array->resize(size());
  }
  if (friction) {
    result->friction.resize(size());
    model.numbering.scatter_points(tau, result->friction);
  }
  model.numbering.scatter_points(eta, result->reactions);
  model.numbering.scatter_points(control, result->control_forces);
  // The load of supports is the constraints' force and f there.
  std::fill_n(eta.begin(), moving(), 0.0);
  for (std::size_t i = moving(); i < size(); ++i) eta[i] += work.f[i];
  model.numbering.scatter_points(eta, result->support_forces);
  return {};
}

MotionForces InverseDynamics::Implementation::evaluate(double t, const MotionState& points) {
  check_time(t);
  check_size(points.value.size(), size(), "positions");
  check_size(points.rate.size(), size(), "velocities");
  check_size(points.acceleration.size(), size(), "accelerations");
  work.set_time(t);
  work.constraints.choose_frames();
  model.numbering.gather_points(points.value, r);
  model.numbering.gather_points(points.rate, v);
  model.numbering.gather_points(points.acceleration, w);
  MotionForces result;
  put_supports(t, &result);
  if (!std::isfinite(work.evaluate_free(t, r.data(), v.data(), w0.data()) + model.largest_norm(r.data()) +
                     model.largest_norm(v.data()) + model.largest_norm(w.data()))) {
    result.outcome = model.not_finite(t);
    return result;
  }
  result.outcome = normal ? measure_constraints(t, &result) : measure_coordinates(t, &result);
  if (result.outcome.ok()) result.outcome = divide_force(t, &result);
  return result;
}

InverseDynamics::InverseDynamics(System system, SolverOptions options)
    : implementation_(make_quietly<Implementation>(std::move(system), options)) {}
InverseDynamics::InverseDynamics(InverseDynamics&&) noexcept = default;
InverseDynamics& InverseDynamics::operator=(InverseDynamics&&) noexcept = default;
InverseDynamics::~InverseDynamics() = default;

const System& InverseDynamics::system() const {
  return live(implementation_, "InverseDynamics").model.system;
}
std::size_t InverseDynamics::num_equations() const {
  return live(implementation_, "InverseDynamics").model.numbering.num_user_rows;
}
std::size_t InverseDynamics::num_coordinates() const {
  return live(implementation_, "InverseDynamics").q.size();
}

MotionForces InverseDynamics::evaluate(double t, const MotionState& points) {
  const QuietTraps quiet;
  return live(implementation_, "InverseDynamics").evaluate(t, points);
}

MotionState InverseDynamics::place(double t, const MotionState& coordinates) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "InverseDynamics");
  Workspace& work = self.work;
  const Model& model = self.model;
  check_time(t);
  if (work.coordinates.empty()) throw InputError("/coordinates", "a motion q(t) needs coordinates; none are given");
  if (work.coordinates.has_charts()) {
    throw InputError("/coordinates",
                     "a motion q(t) needs coordinates of one meaning; spheres, bodies and directions in "
                     "space have charts that move along: give r(t) instead");
  }
  const std::size_t s = num_coordinates();
  const auto gather = [&](const std::vector<double>& given, const char* name) {
    check_size(given.size(), s, name);
    std::vector<double> result(s);
    work.coordinates.gather(given.data(), result.data());
    return result;
  };
  const std::vector<double> q = gather(coordinates.value, "q"), q_dot = gather(coordinates.rate, "q_dot"),
                            q_ddot = gather(coordinates.acceleration, "q_ddot");
  std::vector<double> r(self.size()), v(self.size()), psi(self.size()), w(self.size()),
      blocks(3 * work.coordinates.num_blocks());
  work.set_time(t);
  work.prescribe_all(t, r.data(), v.data());
  work.write_support_accelerations(t, psi.data());
  work.coordinates.evaluate(model.parallel, q.data(), q_dot.data(), r.data(), v.data(), psi.data(), blocks.data());
  // w = A q_ddot + psi
  work.coordinates.apply(model.parallel, blocks.data(), q_ddot.data(), w.data());
  for (std::size_t i = 0; i < self.size(); ++i) w[i] = (i < self.moving() ? w[i] : 0.0) + psi[i];

  MotionState result{std::vector<double>(self.size()), std::vector<double>(self.size()),
                     std::vector<double>(self.size())};
  model.numbering.scatter_points(r, result.value);
  model.numbering.scatter_points(v, result.rate);
  model.numbering.scatter_points(w, result.acceleration);
  return result;
}

}  // namespace tanor
