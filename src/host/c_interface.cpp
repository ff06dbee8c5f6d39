#include <tanor.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/build_info.hpp>
#include <tanor/constrainer.hpp>
#include <tanor/velocity_verlet.hpp>
#include <tanor/version.hpp>

#include "host/c_members.hpp"
#include "host/host_input.hpp"
#include "host/point_address.hpp"

/// A handle, whose Constrainer is made on first use; before that a cell may be set.
struct tn_system {
  std::vector<double> masses, positions;  // given to tn_create; kept until `made`
  std::optional<tanor::PeriodicCell> cell;
  tanor::PeriodicCell old_cell;  // of the next tn_constrain_positions
  bool has_old_cell = false;
  tanor::SolverOptions options;
  double tolerance = 0.0;  // of constrained positions
  std::optional<tanor::Constrainer> made;
  std::string error;

  tanor::Constrainer& constrainer() {
    if (made) return *made;
    if (cell)
      made.emplace(masses, std::vector<tanor::Constraint>{}, positions, tanor::Periodicity{*cell, {}}, options);
    else
      made.emplace(masses, std::vector<tanor::Constraint>{}, positions, options);
    masses = positions = {};
    return *made;
  }
};

namespace {

using namespace tanor;

std::string& create_error() {
  static thread_local std::string error;
  return error;
}

int code_of(Status status) {
  switch (status) {
    case Status::Ok:
      return TN_OK;
    case Status::Singular:
      return TN_SINGULAR;
    case Status::Contradictory:
      return TN_CONTRADICTORY;
    case Status::NotConverged:
      return TN_NOT_CONVERGED;
    case Status::NotFinite:
      return TN_NOT_FINITE;
    case Status::StepTooSmall:
    case Status::NoSolution:
    case Status::NotUnique:
      break;
  }
  return TN_EINTERNAL;
}

const Outcome& outcome_of(const Outcome& outcome) {
  return outcome;
}
const Outcome& outcome_of(const ConstraintReport& report) {
  return report.outcome;
}

/// Lets no exception pass. What `call`, which returns an Outcome or a report with one, throws becomes a code, and its
/// text goes into `error`.
template <class Call>
int guard(std::string* error, const Call& call) noexcept {
  try {
    try {
      const auto result = call();
      const Outcome& outcome = outcome_of(result);
      if (!outcome.ok()) *error = outcome.what;
      return code_of(outcome.status);
    } catch (const InputError& wrong) {
      *error = (wrong.where().empty() ? "" : wrong.where() + ": ") + wrong.what();
      return TN_EINVAL;
    } catch (const std::bad_alloc&) {
      *error = "no memory";
      return TN_ENOMEM;
    } catch (const std::exception& defect) {
      *error = defect.what();
      return TN_EINTERNAL;
    }
  } catch (...) {
    return TN_EINTERNAL;  // there is no memory for the text either
  }
}

/// Does the same for calls on a handle, which may be null.
template <class Call>
int guard(tn_system* system, const Call& call) noexcept {
  if (system == nullptr)
    return guard(&create_error(), []() -> Outcome { throw InputError("", "the system is a null pointer"); });
  return guard(&system->error, [&] {
    if constexpr (std::is_void_v<decltype(call(*system))>)
      return call(*system), Outcome{};
    else
      return call(*system);
  });
}

PointArray array_of(const tn_points& points) {
  return {points.data, points.stride, points.index};
}
ConstPointArray array_of(const tn_const_points& points) {
  return {points.data, points.stride, points.index};
}

/// Returns the part of a struct that its `size` covers; the rest is zero.
template <class Struct>
Struct known_part(const Struct* given) {
  Struct result{};
  if (given == nullptr) return result;
  if (given->size < sizeof(given->size))
    throw InputError("", "size = " + std::to_string(given->size) + " of a struct is not sizeof it");
  std::memcpy(&result, given, std::min<std::size_t>(given->size, sizeof(Struct)));
  return result;
}

void require(const void* pointer, const char* name) {
  if (pointer == nullptr) throw InputError("", std::string(name) + " is a null pointer");
}

/// Returns a list of `count` numbers, which may be absent.
template <class Number>
std::span<const Number> list_of(const Number* numbers, size_t count) {
  return {numbers, numbers != nullptr ? count : 0};
}

/// Returns the same list, which must be there.
template <class Number>
std::span<const Number> list_of(const Number* numbers, size_t count, const char* name) {
  if (count > 0) require(numbers, name);
  return list_of(numbers, count);
}

PeriodicCell make_cell(const double* edges, const int* repeats) {
  require(edges, "cell");
  PeriodicCell result;
  for (std::size_t k = 0; k < 9; ++k) result.edges[k / 3][k % 3] = edges[k];
  for (std::size_t k = 0; k < 3; ++k) result.repeats[k] = repeats == nullptr || repeats[k] != 0;
  return result;
}

ConstraintForces forces_of(const tn_wanted& wanted, const Constrainer& constrainer) {
  ConstraintForces result;
  if (wanted.multipliers != nullptr) result.multipliers = {wanted.multipliers, constrainer.num_rows()};
  result.forces = array_of(wanted.forces);
  result.stress = array_of(wanted.stress);
  return result;
}

/// Writes the ids of `count` members from `first` on.
void write_ids(ConstraintId first, size_t count, int64_t* ids) {
  for (size_t k = 0; ids != nullptr && k < count; ++k) ids[k] = first + static_cast<ConstraintId>(k);
}

/// Writes as much of the report as `size` of the struct covers.
void write_numbers(const ConstraintReport& found, tn_report* report) {
  tn_report own{};
  own.size = report->size;
  own.iterations = found.iterations;
  own.violation = found.violation;
  own.correction = found.correction;
  own.worst_row = found.worst_row == ConstraintReport::no_row ? -1 : static_cast<std::int64_t>(found.worst_row);
  own.largest_turn = found.largest_turn;
  own.work = found.work;
  std::copy(found.virial.begin(), found.virial.end(), own.virial);
  std::memcpy(report, &own, std::min<std::size_t>(report->size, sizeof(own)));
}

/// Calls find(constrainer, system) with the same care and writes what it found to `report`, which may be null.
template <class Find>
int report_on(tn_system* system, tn_report* report, const Find& find) noexcept {
  return guard(system, [&](tn_system& self) {
    ConstraintReport found = find(self.constrainer(), self);
    if (report != nullptr) write_numbers(found, report);
    return found;
  });
}

}  // namespace

extern "C" {

// ---- life ----

int tn_abi(void) {
  return TN_ABI;
}

const char* tn_version(void) {
  try {
    static const std::string text = tanor::describe(tanor::build_info());
    return text.c_str();
  } catch (const std::bad_alloc&) {
    return "tanor " TANOR_VERSION;
  }
}

int tn_create(tn_system** out, size_t num_points, const double* masses, tn_const_points positions,
              const tn_options* options) {
  if (out != nullptr) *out = nullptr;
  return guard(&create_error(), [&]() -> Outcome {
    if (out == nullptr) throw InputError("", "out is a null pointer");
    if (masses == nullptr || positions.data == nullptr) throw InputError("", "masses or positions are a null pointer");
    auto system = std::make_unique<tn_system>();
    const tn_options own = known_part(options);
    system->options.threads = own.threads;
    system->options.exact = own.inexact == 0;
    system->tolerance = own.tolerance;
    system->masses.assign(masses, masses + num_points);
    for (std::size_t i = 0; i < num_points; ++i) {
      check_mass(masses[i], std::nullopt, i);
      const std::array<double, 3> point = read_point(array_of(positions), i);
      system->positions.insert(system->positions.end(), point.begin(), point.end());
    }
    *out = system.release();
    return {};
  });
}

void tn_destroy(tn_system* system) {
  delete system;
}

const char* tn_create_error(void) {
  return create_error().c_str();
}

const char* tn_last_error(const tn_system* system) {
  return system != nullptr ? system->error.c_str() : create_error().c_str();
}

// ---- what is constrained ----

int tn_add_rods(tn_system* system, size_t count, const int32_t* pairs, const double* lengths, const int32_t* images,
                int64_t* ids) {
  return guard(system, [&](tn_system& self) {
    if (count == 0) return;
    require(pairs, "pairs");
    Rods rods;
    for (std::size_t k = 0; k < count; ++k) rods.pairs.push_back({pairs[2 * k], pairs[2 * k + 1]});
    if (lengths != nullptr) rods.length = std::vector<double>(lengths, lengths + count);
    std::vector<std::array<int, 3>> own;
    for (std::size_t k = 0; images != nullptr && k < count; ++k)
      own.push_back({images[3 * k], images[3 * k + 1], images[3 * k + 2]});
    write_ids(self.constrainer().add(std::move(rods), {}, std::move(own)), count, ids);
  });
}

int tn_add(tn_system* system, tn_kind kind, size_t count, const int32_t* points, const double* parameters,
           int64_t* ids) {
  return guard(system, [&](tn_system& self) {
    if (count > 0) require(points, "points");
    const std::vector<ConstraintId> added = add_members(&self.constrainer(), kind, count, points, parameters);
    if (ids != nullptr) std::ranges::copy(added, ids);
  });
}

int tn_remove(tn_system* system, size_t count, const int64_t* ids) {
  return guard(system, [&](tn_system& self) { self.constrainer().remove(list_of(ids, count, "ids")); });
}

int tn_set_lengths(tn_system* system, size_t count, const int64_t* ids, const double* lengths, const double* rates) {
  return guard(system, [&](tn_system& self) {
    self.constrainer().set_lengths(list_of(ids, count, "ids"), list_of(lengths, count, "lengths"),
                                   list_of(rates, count));
  });
}

int tn_set_masses(tn_system* system, size_t count, const int32_t* points, const double* masses) {
  return guard(system, [&](tn_system& self) {
    self.constrainer().set_masses(list_of(points, count, "points"), list_of(masses, count, "masses"));
  });
}

int tn_renumber(tn_system* system, size_t num_points, const int64_t* from, const double* masses, tn_const_points x) {
  return guard(system, [&](tn_system& self) {
    self.constrainer().renumber(list_of(from, num_points, "from"), list_of(masses, num_points, "masses"), array_of(x));
  });
}

int tn_set_box(tn_system* system, const double cell[9], const int repeats[3]) {
  return guard(system, [&](tn_system& self) {
    const PeriodicCell next = make_cell(cell, repeats);
    if (self.made && !self.cell) throw InputError("/cell", "the first one comes before the first constraints");
    if (self.made) self.made->set_cell(next);
    self.cell = next;
  });
}

int tn_set_old_box(tn_system* system, const double cell[9]) {
  return guard(system, [&](tn_system& self) {
    if (!self.cell) throw InputError("/cell", "there is none; tn_set_box gives one");
    self.old_cell = make_cell(cell, nullptr);
    self.old_cell.repeats = self.cell->repeats;
    self.has_old_cell = true;
  });
}

int tn_expect_edits(tn_system* system) {
  return guard(system, [&](tn_system& self) { self.constrainer().expect_edits(); });
}

int tn_plan(tn_system* system, size_t* islands) {
  return guard(system, [&](tn_system& self) {
    const size_t count = self.constrainer().update_plan();
    if (islands != nullptr) *islands = count;
  });
}

size_t tn_num_points(const tn_system* system) {
  if (system == nullptr) return 0;
  return system->made ? system->made->num_points() : system->masses.size();
}

size_t tn_num_rows(const tn_system* system) {
  return system != nullptr && system->made ? system->made->num_rows() : 0;
}

int tn_rows(tn_system* system, int64_t id, size_t* first, size_t* count) {
  return guard(system, [&](tn_system& self) {
    const RowRange rows = self.constrainer().rows(id);
    if (first != nullptr) *first = rows.first;
    if (count != nullptr) *count = rows.count;
  });
}

int tn_row_name(tn_system* system, size_t row, char* text, size_t size) {
  return guard(system, [&](tn_system& self) {
    const std::string name = self.constrainer().row_name(row);
    if (text == nullptr || size == 0) throw InputError("", "there is no room for the name of a row");
    const std::size_t length = std::min(name.size(), size - 1);
    std::memcpy(text, name.data(), length);
    text[length] = '\0';
  });
}

// ---- a step ----

int tn_constrain_positions(tn_system* system, double dt, tn_const_points x_old, tn_points x, tn_points v,
                           const tn_wanted* wanted, tn_report* report) {
  return report_on(system, report, [&](Constrainer& constrainer, tn_system& self) {
    const tn_wanted own = known_part(wanted);
    return constrainer.constrain_positions(
        {.step = dt,
         .old_positions = array_of(x_old),
         .positions = array_of(x),
         .velocities = array_of(v),
         .wanted = forces_of(own, constrainer),
         .old_cell = std::exchange(self.has_old_cell, false) ? &self.old_cell : nullptr,
         .measures = own.measures != 0,
         .tolerance = self.tolerance});
  });
}

int tn_constrain_velocities(tn_system* system, double dt, tn_const_points x, tn_points v, const tn_wanted* wanted,
                            tn_report* report) {
  return report_on(system, report, [&](Constrainer& constrainer, const tn_system&) {
    const tn_wanted own = known_part(wanted);
    return constrainer.constrain_velocities({.step = dt,
                                             .positions = array_of(x),
                                             .velocities = array_of(v),
                                             .wanted = forces_of(own, constrainer),
                                             .measures = own.measures != 0});
  });
}

// ---- an instant ----

int tn_solve(tn_system* system, tn_const_points x, tn_const_points v, tn_const_points f, tn_points w,
             const tn_wanted* wanted, tn_report* report) {
  return report_on(system, report, [&](Constrainer& constrainer, const tn_system&) {
    const tn_wanted own = known_part(wanted);
    return constrainer.solve({.positions = array_of(x),
                              .velocities = array_of(v),
                              .forces = array_of(f),
                              .accelerations = array_of(w),
                              .wanted = forces_of(own, constrainer),
                              .measures = own.measures != 0});
  });
}

int tn_project_forces(tn_system* system, tn_const_points x, tn_points f, const tn_wanted* wanted, tn_report* report) {
  return report_on(system, report, [&](Constrainer& constrainer, const tn_system&) {
    return constrainer.project_forces(array_of(x), array_of(f), 0.0, forces_of(known_part(wanted), constrainer));
  });
}

int tn_project_positions(tn_system* system, tn_points x, tn_report* report) {
  return report_on(system, report, [&](Constrainer& constrainer, const tn_system&) {
    return constrainer.project_positions(array_of(x));
  });
}

int tn_log_det(tn_system* system, tn_const_points x, double* value, tn_points gradient) {
  return guard(system, [&](tn_system& self) -> Outcome {
    require(value, "value");
    const LogDeterminant found = self.constrainer().log_det(array_of(x), array_of(gradient));
    if (found.outcome.ok()) *value = found.value;
    return found.outcome;
  });
}

int tn_violation(tn_system* system, tn_const_points x, tn_report* report) {
  return report_on(system, report,
                   [&](Constrainer& constrainer, const tn_system&) { return constrainer.violation(array_of(x)); });
}

int tn_removed_dof(tn_system* system, tn_const_points x, const uint8_t* group, double* removed) {
  return guard(system, [&](tn_system& self) {
    require(removed, "removed");
    Constrainer& constrainer = self.constrainer();
    *removed = group == nullptr
                   ? static_cast<double>(constrainer.rank(array_of(x)).rank)
                   : constrainer.removed_degrees_of_freedom(array_of(x), list_of(group, constrainer.num_points()));
  });
}

// ---- the time loop ----

int tn_run(tn_system* system, const tn_loop* loop, size_t* steps) {
  return guard(system, [&](tn_system& self) -> Outcome {
    require(loop, "loop");
    const tn_loop own = known_part(loop);
    VelocityVerlet steps_of_host{.step = own.dt,
                                 .steps = own.steps,
                                 .time = own.time,
                                 .positions = array_of(own.x),
                                 .velocities = array_of(own.v),
                                 .forces = array_of(own.f),
                                 .measures = own.measures != 0,
                                 .tolerance = self.tolerance};
    if (own.set_forces != nullptr) steps_of_host.set_forces = [&](double time) { own.set_forces(own.user, time); };
    if (own.observe != nullptr) {
      steps_of_host.observe = [&](const VelocityVerletProgress& now) {
        tn_report positions{}, velocities{};
        positions.size = velocities.size = sizeof(tn_report);
        write_numbers(now.positions, &positions);
        write_numbers(now.velocities, &velocities);
        const tn_progress progress{sizeof(tn_progress), now.steps, now.time, &positions, &velocities};
        return own.observe(own.user, &progress) != 0;
      };
    }
    VelocityVerletReport report = run(&self.constrainer(), steps_of_host);
    if (steps != nullptr) *steps = report.steps;
    return std::move(report.outcome);
  });
}

// ---- going on elsewhere ----

int tn_save(tn_system* system, void* data, size_t* size) {
  return guard(system, [&](tn_system& self) {
    require(size, "size");
    const std::vector<std::byte> bytes = self.constrainer().save();
    const size_t room = std::exchange(*size, bytes.size());
    if (data == nullptr) return;
    if (room < bytes.size())
      throw InputError("",
                       "there is room for " + std::to_string(room) + " of " + std::to_string(bytes.size()) + " bytes");
    std::memcpy(data, bytes.data(), bytes.size());
  });
}

int tn_restore(tn_system* system, const void* data, size_t size) {
  return guard(system, [&](tn_system& self) {
    self.constrainer().restore(list_of(static_cast<const std::byte*>(data), size, "data"));
  });
}

}  // extern "C"
