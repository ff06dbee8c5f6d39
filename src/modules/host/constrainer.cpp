#include <tanor/constrainer.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "base/live.hpp"
#include "base/quiet_traps.hpp"
#include "host/host_input.hpp"
#include "host/host_observables.hpp"
#include "host/host_parts.hpp"
#include "host/point_address.hpp"
#include "system/one_sided.hpp"
#include "system/strengths.hpp"

namespace tanor {
using namespace detail;

struct Constrainer::Implementation : HostParts {
  using HostParts::HostParts;

  void check(const ConstraintForces& wanted) const {
    if (!wanted.multipliers.empty()) check_size(wanted.multipliers.size(), inventory().num_rows(), "multipliers");
    check_array(wanted.forces, num_points(), 3, "forces");
    check_array(wanted.stress, num_points(), 9, "stress");
  }
  /// Checks the arguments that every call has: positions, time, and what is wanted there.
  void check(const ConstPointArray& positions, double time, const ConstraintForces& wanted = {},
             const char* name = "positions") const {
    check_finite(time, "time");
    require_array(positions, num_points(), name);
    check(wanted);
  }
  void clear_supports(const PointArray& array, std::size_t width) const;
  ConstraintReport sum_up();
  template <class Find, class Write>
  ConstraintReport call(const Find& find, const Write& write, const ConstraintForces& wanted = {});
  template <class Find>
  ConstraintReport call(const Find& find) {
    return call(find, [](ConstrainedHost&, PartReport*) {});
  }
  void write_supports(const ConstraintForces& wanted);
  ConstraintReport solve(const HostState& at);
  void write_solution(const HostState& at);
  HostObservables& add_observables() {
    if (observables == nullptr) observables = std::make_unique<HostObservables>(*this);
    return *observables;
  }

  std::unique_ptr<HostObservables> observables{};  // null if there are none
};

namespace {

/// One call on a handle, with floating-point traps off and all changes planned.
template <class Pointer>
class Call {
 public:
  explicit Call(const Pointer& implementation) : self_(live(implementation, "Constrainer")) { (void)self_.plan(); }
  auto& operator*() { return self_; }
  auto* operator->() { return &self_; }

 private:
  const QuietTraps quiet_;
  typename Pointer::element_type& self_;
};

}  // namespace

void Constrainer::Implementation::clear_supports(const PointArray& array, std::size_t width) const {
  if (!array) return;
  for (const Index point : supports()) {
    const Index host = points().host_point[static_cast<std::size_t>(point)];
    std::fill_n(address_of(array, static_cast<std::size_t>(host), width), width * sizeof(double), std::byte{});
  }
}

/// Combines the parts' reports. If several parts failed, the outcome is that of the first one.
ConstraintReport Constrainer::Implementation::sum_up() {
  ConstraintReport all;
  double worst = -1.0;
  for (std::size_t k = 0; k < size(); ++k) {
    PartReport& own = reports()[k];
    all.iterations = std::max(all.iterations, own.iterations);
    all.violation = larger(all.violation, own.violation);
    all.correction = larger(all.correction, own.correction);
    all.largest_turn = larger(all.largest_turn, own.largest_turn);
    all.work += own.work;
    for (std::size_t d = 0; d < all.virial.size(); ++d) all.virial[d] += own.virial[d];
    const bool fails = all.outcome.ok() && !own.outcome.ok();
    if (fails) all.outcome = {own.outcome.status, with_names(k, own.outcome.what)};
    if (fails || (all.outcome.ok() && own.worst > worst)) {
      worst = own.worst;
      all.worst_row = own.worst_row;
    }
  }
  return all;
}

/// Calls find(part, its report) for all parts and, if all of them have succeeded, write(part, its report), and writes
/// what is wanted at supports. Otherwise no array of the host has changed.
template <class Find, class Write>
ConstraintReport Constrainer::Implementation::call(const Find& find, const Write& write,
                                                   const ConstraintForces& wanted) {
  const auto restore = [&] { for_each([](ConstrainedHost& part, PartReport*) { part.restore(); }); };
  try {
    for_each([&](ConstrainedHost& part, PartReport* report) {
      *report = {};
      find(part, report);
    });
  } catch (...) {  // a function of the host in one part; others may have moved
    restore();
    throw;
  }
  const auto is_ok = [](const PartReport& report) { return report.outcome.ok(); };
  if (!std::ranges::all_of(reports(), is_ok)) {
    restore();
    return sum_up();
  }
  for_each(write);
  write_supports(wanted);
  return sum_up();
}

/// Writes what is wanted at supports, where the parts add up.
void Constrainer::Implementation::write_supports(const ConstraintForces& wanted) {
  clear_supports(wanted.forces, 3);
  clear_supports(wanted.stress, 9);
  for (std::size_t k = 0; k < size(); ++k) (*this)[k].add_to_supports(wanted);
}

// ---- life ----

Constrainer::Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
                         const SolverOptions& options)
    : Constrainer(masses, std::move(constraints), at, nullptr, options) {}
Constrainer::Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
                         const Periodicity& periodicity, const SolverOptions& options)
    : Constrainer(masses, std::move(constraints), at, &periodicity, options) {}
Constrainer::Constrainer(std::span<const double> masses, std::vector<Constraint> constraints, ConstPointArray at,
                         const Periodicity* periodicity, const SolverOptions& options) {
  const QuietTraps quiet;
  HostPoints points = make_points(masses, at);
  const System system = make_system(points, std::move(constraints));
  validate(system);
  refuse_sides(system, one_sided_host);
  refuse_breaks(system, unbreakable_host);
  std::span<const std::array<int, 3>> images;
  std::optional<PeriodicCell> cell;
  if (periodicity != nullptr) {
    images = periodicity->images;
    cell = periodicity->cell;
    (void)Lattice(*cell);
    if (!images.empty() && images.size() != num_equations(system)) {
      throw InputError("/cell", "images has " + std::to_string(images.size()) + " entries; " +
                                    std::to_string(num_equations(system)) + " are needed, one a row");
    }
  }
  implementation_ = std::make_unique<Implementation>(std::move(points), cell, options);
  for (const Constraint& group : system.constraints) {
    const GroupShape shape = shape_of(group);
    const auto own = images.subspan(0, images.empty() ? 0 : shape.members * shape.rows_per_member);
    images = images.subspan(own.size());
    (void)add_group(group, {own.begin(), own.end()}, implementation_.get());
  }
  (void)implementation_->plan();
}
Constrainer::Constrainer(Constrainer&&) noexcept = default;
Constrainer& Constrainer::operator=(Constrainer&&) noexcept = default;
Constrainer::~Constrainer() = default;

void Constrainer::set_cell(const PeriodicCell& cell) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  if (self.cell() == nullptr) throw InputError("/cell", "there is none; it is given where the Constrainer is made");
  if (cell != *self.cell()) self.set_cell(cell);
}

// ---- what is constrained ----

void Constrainer::expect_edits() {
  live(implementation_, "Constrainer").expect_edits();
}

ConstraintId Constrainer::add(Constraint group, ConstPointArray at, std::vector<std::array<int, 3>> images) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_array(at, self.num_points(), 3, "positions");
  const Rods* const rods = std::get_if<Rods>(&group);
  if (at)
    self.set_positions(at);
  else if (rods == nullptr || rods->length.is_initial())  // rods of known lengths may be anywhere
    self.read_positions();
  check_group(self, group, images.size());
  return add_group(std::move(group), std::move(images), &self);
}

void Constrainer::remove(std::span<const ConstraintId> ids) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  std::set<ConstraintId> seen;
  for (const ConstraintId id : ids) {
    self.inventory().require(id);
    if (!seen.insert(id).second) throw InputError("", "the constraint with the id " + text(id) + " is removed twice");
  }
  self.remove(ids);
}

void Constrainer::set_lengths(std::span<const ConstraintId> ids, std::span<const double> lengths,
                              std::span<const double> rates) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_size(lengths.size(), ids.size(), "lengths");
  if (!rates.empty()) check_size(rates.size(), ids.size(), "rates");
  const auto rate = [&](std::size_t k) { return rates.empty() ? 0.0 : rates[k]; };
  for (std::size_t k = 0; k < ids.size(); ++k) self.inventory().check_length(ids[k], lengths[k], rate(k));
  for (std::size_t k = 0; k < ids.size(); ++k) self.set_length(ids[k], lengths[k], rate(k));
}

void Constrainer::set_masses(std::span<const Index> points, std::span<const double> masses) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_size(masses.size(), points.size(), "masses");
  const HostPoints& all = self.points();
  for (std::size_t k = 0; k < points.size(); ++k) {
    const auto point = static_cast<std::size_t>(points[k]);
    if (points[k] < 0 || point >= self.num_points())
      throw InputError("/masses/" + text(k), "there is no point " + text(points[k]));
    check_mass(masses[k], all.mass[static_cast<std::size_t>(all.of_host[point])], point);
  }
  for (std::size_t k = 0; k < points.size(); ++k)
    self.set_mass(all.of_host[static_cast<std::size_t>(points[k])], masses[k]);
}

void Constrainer::renumber(std::span<const std::int64_t> from, std::span<const double> masses, ConstPointArray at) {
  const QuietTraps quiet;
  Implementation& self = live(implementation_, "Constrainer");
  check_array(at, from.size(), 3, "positions");
  self.renumber(check_numbers(self, from, masses), masses);
  if (at) self.set_positions(at);
}

std::size_t Constrainer::update_plan() {
  const QuietTraps quiet;
  return live(implementation_, "Constrainer").plan();
}

std::size_t Constrainer::num_points() const {
  return live(implementation_, "Constrainer").num_points();
}
double Constrainer::mass(Index point) const {
  const HostPoints& points = live(implementation_, "Constrainer").points();
  if (point < 0 || static_cast<std::size_t>(point) >= points.of_host.size())
    throw InputError("", "there is no point " + text(point));
  return points.mass[static_cast<std::size_t>(points.of_host[static_cast<std::size_t>(point)])];
}
std::size_t Constrainer::num_rows() const {
  return live(implementation_, "Constrainer").inventory().num_rows();
}
RowRange Constrainer::rows(ConstraintId id) const {
  const Inventory& inventory = live(implementation_, "Constrainer").inventory();
  inventory.require(id);
  return {inventory.first_row(id), inventory.num_rows(id)};
}
std::string Constrainer::row_name(std::size_t row) const {
  return live(implementation_, "Constrainer").inventory().row_name(row);
}
const PlanSummary& Constrainer::plan() const {
  return live(implementation_, "Constrainer").summary();
}
Counters Constrainer::counters() const {
  return live(implementation_, "Constrainer").counters();
}

std::vector<std::byte> Constrainer::save() {
  return Call(implementation_)->save();
}
void Constrainer::restore(std::span<const std::byte> bytes) {
  Call(implementation_)->restore(bytes);
}

// ---- a step ----

ConstraintReport Constrainer::constrain_positions(const PositionStep& step) {
  Call self(implementation_);
  self->check(step.old_positions, step.time, step.wanted, "old_positions");
  require_array(step.positions, self->num_points(), "positions");
  check_array(step.velocities, self->num_points(), 3, "velocities");
  check_finite(step.step, "step");
  if (step.step == 0.0) throw InputError("", "step = 0: a step of no length has no velocities");
  if (!(step.tolerance >= 0.0)) throw InputError("", "tolerance = " + text(step.tolerance) + " is negative");
  return self->call([&](ConstrainedHost& part, PartReport* own) { part.find_positions(step, own); },
                    [&](ConstrainedHost& part, PartReport* own) { part.write_positions(step, own); }, step.wanted);
}

ConstraintReport Constrainer::constrain_velocities(const VelocityStep& step) {
  Call self(implementation_);
  self->check(step.positions, step.time, step.wanted);
  require_array(step.velocities, self->num_points(), "velocities");
  check_finite(step.step, "step");
  ConstraintReport report =
      self->call([&](ConstrainedHost& part, PartReport* own) { own->correction = part.find_speed(step, own); });
  const double speed = std::exchange(report.correction, 0.0);
  if (!report.outcome.ok()) return report;
  return self->call([&](ConstrainedHost& part, PartReport* own) { part.find_velocities(step, speed, own); },
                    [&](ConstrainedHost& part, PartReport* own) { part.write_velocities(step, own); }, step.wanted);
}

// ---- an instant ----

ConstraintReport Constrainer::Implementation::solve(const HostState& at) {
  check(at.positions, at.time, at.wanted);
  require_array(at.velocities, num_points(), "velocities");
  require_array(at.forces, num_points(), "forces");
  check_array(at.accelerations, num_points(), 3, "accelerations");
  ConstraintReport report = call([&](ConstrainedHost& part, PartReport* own) { part.find_accelerations(at, own); });
  if (report.outcome.ok()) write_solution(at);
  return report;
}

/// Writes what the last solve found to the arrays of `at`.
void Constrainer::Implementation::write_solution(const HostState& at) {
  for_each([&](ConstrainedHost& part, PartReport*) { part.write_accelerations(at); });
  clear_supports(at.accelerations, 3);
  write_supports(at.wanted);
}

ConstraintReport Constrainer::solve(const HostState& at) {
  return Call(implementation_)->solve(at);
}

ConstraintReport Constrainer::project_forces(ConstPointArray positions, PointArray forces, double time,
                                             const ConstraintForces& wanted) {
  Call self(implementation_);
  self->check(positions, time, wanted);
  require_array(forces, self->num_points(), "forces");
  return self->call([&](ConstrainedHost& part, PartReport* own) { part.find_forces(positions, forces, time, own); },
                    [&](ConstrainedHost& part, PartReport* own) { part.write_forces(forces, wanted, own); }, wanted);
}

ConstraintReport Constrainer::project_positions(PointArray positions, double time) {
  Call self(implementation_);
  self->check(positions, time);
  return self->call([&](ConstrainedHost& part, PartReport* own) { part.find_nearest(positions, time, own); },
                    [&](ConstrainedHost& part, PartReport* own) { part.write_nearest(positions, own); });
}

// ---- observables ----

std::size_t Constrainer::add_observable(const Observable& observable) {
  const QuietTraps quiet;
  return live(implementation_, "Constrainer").add_observables().add(observable);
}

void Constrainer::remove_observable(std::size_t number) {
  const QuietTraps quiet;
  live(implementation_, "Constrainer").add_observables().remove(number);
}

ConstraintReport Constrainer::observe(const HostState& at) {
  Call self(implementation_);
  HostObservables& observables = self->add_observables();
  self->check(at.positions, at.time, at.wanted);
  require_array(at.velocities, self->num_points(), "velocities");
  const Needs needs = observables.prepare(at.positions);
  ConstraintReport report;
  if (at.forces || needs.solves()) {
    report = self->solve(at);
    if (!report.outcome.ok()) return report;
    self->write_solution(observables.own_arrays(at));
  }
  observables.take(at, [&] { return self->find_rank(at.positions, at.time).rank; });
  return report;
}

std::span<const Observed> Constrainer::observed() const {
  const auto& observables = live(implementation_, "Constrainer").observables;
  return observables == nullptr ? std::span<const Observed>() : observables->observed();
}

// ---- questions ----

LogDeterminant Constrainer::log_det(ConstPointArray positions, PointArray gradient, double time) {
  Call self(implementation_);
  self->check(positions, time);
  check_array(gradient, self->num_points(), 3, "gradient");
  LogDeterminant sum;
  for (std::size_t k = 0; k < self->size(); ++k) {
    LogDeterminant own = (*self)[k].find_log_det(positions, static_cast<bool>(gradient), time);
    sum.value += own.value;
    if (own.outcome.ok() || !sum.outcome.ok()) continue;
    sum.outcome = {own.outcome.status, self->with_names(k, own.outcome.what)};
  }
  if (!gradient || !sum.outcome.ok()) return sum;
  self->clear_supports(gradient, 3);
  for (std::size_t k = 0; k < self->size(); ++k) (*self)[k].write_gradient(gradient);
  return sum;
}

ConstraintReport Constrainer::violation(ConstPointArray positions, double time) {
  Call self(implementation_);
  self->check(positions, time);
  return self->call([&](ConstrainedHost& part, PartReport* own) { part.find_violation(positions, time, own); });
}

RankReport Constrainer::rank(ConstPointArray positions, double time) {
  Call self(implementation_);
  self->check(positions, time);
  return self->find_rank(positions, time);
}

double Constrainer::removed_degrees_of_freedom(ConstPointArray positions, std::span<const std::uint8_t> flags,
                                               double time) {
  Call self(implementation_);
  self->check(positions, time);
  check_size(flags.size(), self->num_points(), "flags");
  std::vector<char> counts(self->inventory().num_rows(), 1);
  for (const RowDependence& dependence : self->find_rank(positions, time).dependences) counts[dependence.row] = 0;
  const HostPoints& points = self->points();
  double result = 0.0;
  for (std::size_t row = 0; row < counts.size(); ++row) {
    if (counts[row] == 0) continue;
    double moving = 0.0, flagged = 0.0;
    for (const Index point : self->inventory().points(self->inventory().id_of_row(row))) {
      if (points.is_support(point)) continue;
      moving += 1.0;
      flagged += flags[static_cast<std::size_t>(points.host_point[static_cast<std::size_t>(point)])] != 0 ? 1.0 : 0.0;
    }
    result += flagged / moving;
  }
  return result;
}

}  // namespace tanor
