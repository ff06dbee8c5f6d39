#include <tanor.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tanor/constrainer.hpp>
#include <tanor/version.hpp>

/// A Constrainer that is made when it is first needed, from what was added until then.
struct tn_system {
  std::vector<double> masses, positions;
  std::vector<tanor::Constraint> constraints;
  std::size_t num_rows = 0;
  std::vector<std::array<int, 3>> images;                         // [row]; empty: nearest ones
  std::optional<tanor::PeriodicCell> first_cell, cell, old_cell;  // the first one is that of `positions`
  tanor::SolverOptions options;
  std::optional<tanor::Constrainer> constrainer;  // none: something was added since
  std::string error;

  tanor::Constrainer& planned() {
    if (constrainer) return *constrainer;
    if (first_cell) {
      constrainer.emplace(masses, constraints, positions, tanor::Periodicity{*first_cell, images}, options);
      constrainer->set_cell(*cell);
    } else {
      constrainer.emplace(masses, constraints, positions, options);
    }
    return *constrainer;
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

/// Nothing is thrown across: what `call` throws becomes a code, and its text goes into `error`.
template <class Call>
int guard(std::string* error, const Call& call) noexcept {
  try {
    try {
      const Outcome outcome = call();
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
    return TN_EINTERNAL;  // no memory for the text either
  }
}

/// The same for calls on a handle, which may be null.
template <class Call>
int guard(tn_system* system, const Call& call) noexcept {
  if (system == nullptr)
    return guard(&create_error(), []() -> Outcome { throw InputError("", "the system is a null pointer"); });
  return guard(&system->error, [&] { return call(system->planned()); });
}

PointArray array_of(const tn_points& points) {
  return {points.data, points.stride, points.index};
}
ConstPointArray array_of(const tn_const_points& points) {
  return {points.data, points.stride, points.index};
}

/// What `size` says that there is.
template <class Struct>
Struct known_part(const Struct* given) {
  Struct result{};
  if (given == nullptr) return result;
  if (given->size < sizeof(given->size))
    throw InputError("", "size = " + std::to_string(given->size) + " of a struct is not sizeof it");
  std::memcpy(&result, given, std::min<std::size_t>(given->size, sizeof(Struct)));
  return result;
}

PeriodicCell make_cell(const double* edges, const int* repeats) {
  if (edges == nullptr) throw InputError("/cell", "the edges are a null pointer");
  PeriodicCell result;
  for (std::size_t k = 0; k < 9; ++k) result.edges[k / 3][k % 3] = edges[k];
  for (std::size_t k = 0; k < 3; ++k) result.repeats[k] = repeats == nullptr || repeats[k] != 0;
  return result;
}

ConstraintForces forces_of(const tn_wanted& wanted, std::size_t num_rows) {
  ConstraintForces result;
  if (wanted.multipliers != nullptr) result.multipliers = {wanted.multipliers, num_rows};
  result.forces = array_of(wanted.forces);
  result.stress = array_of(wanted.stress);
  return result;
}

Outcome write_report(ConstraintReport found, tn_report* report) {
  if (report != nullptr) {
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
  return std::move(found.outcome);
}

}  // namespace

extern "C" {

// ---- life ----

int tn_abi(void) {
  return TN_ABI;
}

const char* tn_version(void) {
  return TANOR_VERSION;
}

int tn_create(tn_system** out, size_t num_points, const double* masses, tn_const_points positions,
              const tn_options* options) {
  if (out != nullptr) *out = nullptr;
  return guard(&create_error(), [&]() -> Outcome {
    if (out == nullptr) throw InputError("", "out is a null pointer");
    if (masses == nullptr || positions.data == nullptr) throw InputError("", "masses or positions are a null pointer");
    auto system = std::make_unique<tn_system>();
    system->options.threads = known_part(options).threads;
    system->masses.assign(masses, masses + num_points);
    const ptrdiff_t stride = positions.stride != 0 ? positions.stride : static_cast<ptrdiff_t>(3 * sizeof(double));
    for (std::size_t i = 0; i < num_points; ++i) {
      const ptrdiff_t number = positions.index != nullptr ? positions.index[i] : static_cast<ptrdiff_t>(i);
      double point[3];
      std::memcpy(point, reinterpret_cast<const char*>(positions.data) + number * stride, sizeof(point));
      system->positions.insert(system->positions.end(), point, point + 3);
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
                size_t* first_row) {
  if (system == nullptr) return guard(system, [](Constrainer&) { return Outcome{}; });
  return guard(&system->error, [&]() -> Outcome {
    if (pairs == nullptr && count > 0) throw InputError("", "pairs are a null pointer");
    Rods rods;
    for (std::size_t k = 0; k < count; ++k) rods.pairs.push_back({pairs[2 * k], pairs[2 * k + 1]});
    if (lengths != nullptr) rods.length = std::vector<double>(lengths, lengths + count);
    System whole;  // checks what is added before it is kept
    whole.masses = system->masses;
    whole.positions = system->positions;
    for (double& mass : whole.masses) mass = mass < std::numeric_limits<double>::infinity() ? mass : 1.0;
    whole.constraints = {rods};
    validate(whole);
    system->constraints.push_back(std::move(rods));
    system->constrainer.reset();
    if (first_row != nullptr) *first_row = system->num_rows;
    if (images != nullptr) system->images.resize(system->num_rows);
    for (std::size_t k = 0; k < count && images != nullptr; ++k)
      system->images.push_back({images[3 * k], images[3 * k + 1], images[3 * k + 2]});
    system->num_rows += count;
    if (!system->images.empty()) system->images.resize(system->num_rows);
    return {};
  });
}

int tn_set_box(tn_system* system, const double cell[9], const int repeats[3]) {
  if (system == nullptr) return tn_plan(system);
  return guard(&system->error, [&]() -> Outcome {
    const PeriodicCell next = make_cell(cell, repeats);
    if (!system->first_cell) {
      system->first_cell = next;
      system->constrainer.reset();
    } else if (system->constrainer) {
      system->constrainer->set_cell(next);
    }
    system->cell = next;
    return {};
  });
}

int tn_set_old_box(tn_system* system, const double cell[9]) {
  if (system == nullptr) return tn_plan(system);
  return guard(&system->error, [&]() -> Outcome {
    if (!system->cell) throw InputError("/cell", "there is none; tn_set_box gives one");
    system->old_cell = make_cell(cell, nullptr);
    system->old_cell->repeats = system->cell->repeats;
    return {};
  });
}

int tn_plan(tn_system* system) {
  return guard(system, [](Constrainer&) { return Outcome{}; });
}

size_t tn_num_points(const tn_system* system) {
  return system != nullptr ? system->masses.size() : 0;
}

size_t tn_num_rows(const tn_system* system) {
  return system != nullptr ? system->num_rows : 0;
}

int tn_row_name(tn_system* system, size_t row, char* text, size_t size) {
  return guard(system, [&](Constrainer& constrainer) -> Outcome {
    const std::string name = constrainer.row_name(row);
    if (text == nullptr || size == 0) throw InputError("", "there is no room for the name of a row");
    const std::size_t length = std::min(name.size(), size - 1);
    std::memcpy(text, name.data(), length);
    text[length] = '\0';
    return {};
  });
}

// ---- a step ----

int tn_constrain_positions(tn_system* system, double dt, tn_const_points x_old, tn_points x, tn_points v,
                           const tn_wanted* wanted, tn_report* report) {
  return guard(system, [&](Constrainer& constrainer) {
    const tn_wanted own = known_part(wanted);
    const std::optional<PeriodicCell> old_cell = std::exchange(system->old_cell, std::nullopt);
    return write_report(constrainer.constrain_positions({.step = dt,
                                                         .old_positions = array_of(x_old),
                                                         .positions = array_of(x),
                                                         .velocities = array_of(v),
                                                         .wanted = forces_of(own, constrainer.num_rows()),
                                                         .old_cell = old_cell ? &*old_cell : nullptr,
                                                         .measures = own.measures != 0}),
                        report);
  });
}

int tn_constrain_velocities(tn_system* system, double dt, tn_const_points x, tn_points v, const tn_wanted* wanted,
                            tn_report* report) {
  return guard(system, [&](Constrainer& constrainer) {
    const tn_wanted own = known_part(wanted);
    return write_report(constrainer.constrain_velocities({.step = dt,
                                                          .positions = array_of(x),
                                                          .velocities = array_of(v),
                                                          .wanted = forces_of(own, constrainer.num_rows()),
                                                          .measures = own.measures != 0}),
                        report);
  });
}

// ---- an instant ----

int tn_solve(tn_system* system, tn_const_points x, tn_const_points v, tn_const_points f, tn_points w,
             const tn_wanted* wanted, tn_report* report) {
  return guard(system, [&](Constrainer& constrainer) {
    const tn_wanted own = known_part(wanted);
    return write_report(constrainer.solve({.positions = array_of(x),
                                           .velocities = array_of(v),
                                           .forces = array_of(f),
                                           .accelerations = array_of(w),
                                           .wanted = forces_of(own, constrainer.num_rows()),
                                           .measures = own.measures != 0}),
                        report);
  });
}

int tn_project_forces(tn_system* system, tn_const_points x, tn_points f, tn_report* report) {
  return guard(system, [&](Constrainer& constrainer) {
    return write_report(constrainer.project_forces(array_of(x), array_of(f)), report);
  });
}

int tn_project_positions(tn_system* system, tn_points x, tn_report* report) {
  return guard(system, [&](Constrainer& constrainer) {
    return write_report(constrainer.project_positions(array_of(x)), report);
  });
}

int tn_log_det(tn_system* system, tn_const_points x, double* value, tn_points gradient) {
  return guard(system, [&](Constrainer& constrainer) -> Outcome {
    if (value == nullptr) throw InputError("", "value is a null pointer");
    const LogDeterminant found = constrainer.log_det(array_of(x), array_of(gradient));
    if (found.outcome.ok()) *value = found.value;
    return found.outcome;
  });
}

int tn_violation(tn_system* system, tn_const_points x, tn_report* report) {
  return guard(system,
               [&](Constrainer& constrainer) { return write_report(constrainer.violation(array_of(x)), report); });
}

int tn_removed_dof(tn_system* system, tn_const_points x, size_t* removed) {
  return guard(system, [&](Constrainer& constrainer) -> Outcome {
    if (removed == nullptr) throw InputError("", "removed is a null pointer");
    *removed = constrainer.rank(array_of(x)).rank;
    return {};
  });
}

}  // extern "C"
