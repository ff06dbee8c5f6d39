#pragma once

#include <tanor.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/constrainer.hpp>

/// \file The common parts of the calls of <tanor.h>.

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

namespace tanor::detail {

inline std::string& create_error() {
  static thread_local std::string error;
  return error;
}

inline int code_of(Status status) {
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

inline const Outcome& outcome_of(const Outcome& outcome) {
  return outcome;
}
inline const Outcome& outcome_of(const ConstraintReport& report) {
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

inline PointArray array_of(const tn_points& points) {
  return {points.data, points.stride, points.index};
}
inline ConstPointArray array_of(const tn_const_points& points) {
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

inline void require(const void* pointer, const char* name) {
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

inline ConstraintForces forces_of(const tn_wanted& wanted, const Constrainer& constrainer) {
  ConstraintForces result;
  if (wanted.multipliers != nullptr) result.multipliers = {wanted.multipliers, constrainer.num_rows()};
  result.forces = array_of(wanted.forces);
  result.stress = array_of(wanted.stress);
  return result;
}

inline HostState state_of(const tn_const_points& x, const tn_const_points& v, const tn_const_points& f,
                          const tn_points& w, const tn_wanted* wanted, const Constrainer& constrainer,
                          double time = 0.0) {
  const tn_wanted own = known_part(wanted);
  return {.positions = array_of(x),
          .velocities = array_of(v),
          .forces = array_of(f),
          .accelerations = array_of(w),
          .wanted = forces_of(own, constrainer),
          .time = time,
          .measures = own.measures != 0};
}

/// Writes as much of the report as `size` of the struct covers.
inline void write_numbers(const ConstraintReport& found, tn_report* report) {
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

/// Writes a list to `to`. `*size` is the room there and receives the size; if `to` is null, the call only asks for
/// that.
template <class Value>
void write_list(std::span<const Value> from, Value* to, size_t* size, const char* what) {
  require(size, "size");
  const size_t room = std::exchange(*size, from.size());
  if (to == nullptr) return;
  if (room < from.size())
    throw InputError("",
                     "there is room for " + std::to_string(room) + " of " + std::to_string(from.size()) + " " + what);
  std::ranges::copy(from, to);
}

/// Writes a text, cut off at `size` bytes with the zero at its end.
inline void write_text(std::string_view from, char* text, size_t size, const char* what) {
  if (text == nullptr || size == 0) throw InputError("", "there is no room for " + std::string(what));
  text[from.copy(text, size - 1)] = '\0';
}

}  // namespace tanor::detail
