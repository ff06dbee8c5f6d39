#include <tanor.h>

#include <algorithm>
#include <array>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/build_info.hpp>
#include <tanor/constrainer.hpp>
#include <tanor/velocity_verlet.hpp>
#include <tanor/version.hpp>

#include "host/c_call.hpp"
#include "host/host_input.hpp"
#include "host/point_address.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

PeriodicCell make_cell(const double* edges, const int* repeats) {
  require(edges, "cell");
  PeriodicCell result;
  for (std::size_t k = 0; k < 9; ++k) result.edges[k / 3][k % 3] = edges[k];
  for (std::size_t k = 0; k < 3; ++k) result.repeats[k] = repeats == nullptr || repeats[k] != 0;
  return result;
}

Vector3 vector_at(const double* numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

/// The layout of a kind in tn_add: the points and the numbers of a member. If `has_number`, the last number is the
/// member's own, and the group has the others.
struct KindLayout {
  size_t num_points, num_parameters;
  bool has_number;
  Constraint (*make)(const double* parameters);
};
KindLayout layout_of(tn_kind kind) {
  switch (kind) {
    case TN_ROD:
      return {2, 1, true, [](const double*) -> Constraint { return Rods{}; }};
    case TN_ANGLE:
      return {3, 1, true, [](const double*) -> Constraint { return Angles{}; }};
    case TN_PLANE:
      return {1, 4, true, [](const double* p) -> Constraint { return Planes{.normal = vector_at(p)}; }};
    case TN_SPHERE:
      return {1, 4, true, [](const double* p) -> Constraint { return Spheres{.center = vector_at(p)}; }};
    case TN_LINE:
      return {1, 6, false, [](const double* p) -> Constraint {
                return Lines{.origin = vector_at(p), .direction = vector_at(p + 3)};
              }};
    case TN_CIRCLE:
      return {1, 7, true, [](const double* p) -> Constraint {
                return Circles{.center = vector_at(p), .normal = vector_at(p + 3)};
              }};
  }
  throw InputError("", "there is no kind " + std::to_string(static_cast<int>(kind)));
}

/// Makes a group of the members [begin, end), which have the same shape.
Constraint make_group(const KindLayout& layout, size_t begin, size_t end, const int32_t* points,
                      const double* parameters) {
  Constraint constraint = layout.make(parameters != nullptr ? parameters + begin * layout.num_parameters : nullptr);
  std::visit(
      [&]<class Kind>(Kind& group) {
        for (size_t k = begin; k < end; ++k) {
          auto& members = group.*KindOf<Kind>::members;
          using Member = typename std::remove_cvref_t<decltype(members)>::value_type;
          const int32_t* const own = points + k * layout.num_points;
          if constexpr (std::is_same_v<Member, Index>) {
            members.push_back(*own);
          } else if constexpr (!std::is_same_v<Member, std::vector<Index>>) {
            std::copy_n(own, layout.num_points, members.emplace_back().begin());
          }
        }
        if constexpr (requires { KindOf<Kind>::parameter; }) {
          std::vector<double> numbers;
          for (size_t k = begin; parameters != nullptr && k < end; ++k)
            numbers.push_back(parameters[(k + 1) * layout.num_parameters - 1]);
          group.*KindOf<Kind>::parameter = std::move(numbers);
        }
      },
      constraint);
  return constraint;
}

/// Adds members laid out as in tn_add, in groups of neighbours with the same shape. If one of them is wrong, none is
/// added. Returns their ids.
std::vector<ConstraintId> add_members(Constrainer* constrainer, tn_kind kind, size_t count, const int32_t* points,
                                      const double* parameters) {
  const KindLayout layout = layout_of(kind);
  const size_t width = layout.num_parameters, shape = layout.has_number ? width - 1 : width;
  if (count > 0 && shape > 0 && parameters == nullptr) throw InputError("", "parameters is a null pointer");
  std::vector<ConstraintId> added;
  try {
    for (size_t begin = 0, end = 0; begin < count; begin = end) {
      const auto has_shape = [&](size_t k) {
        const double* const first = shape > 0 ? parameters + begin * width : nullptr;
        return shape == 0 || std::equal(first, first + shape, parameters + k * width);
      };
      while (end < count && has_shape(end)) ++end;
      end = std::max(end, begin + 1);  // a NaN differs from itself; `add` refuses it
      const ConstraintId id = constrainer->add(make_group(layout, begin, end, points, parameters));
      for (size_t k = begin; k < end; ++k) added.push_back(id + static_cast<ConstraintId>(k - begin));
    }
  } catch (const InputError&) {
    constrainer->remove(added);
    throw;
  }
  return added;
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
    const ConstraintId first = self.constrainer().add(std::move(rods), {}, std::move(own));
    for (std::size_t k = 0; ids != nullptr && k < count; ++k) ids[k] = first + static_cast<ConstraintId>(k);
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
  return guard(system,
               [&](tn_system& self) { write_text(self.constrainer().row_name(row), text, size, "the name of a row"); });
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
    return constrainer.solve(state_of(x, v, f, w, wanted, constrainer));
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
    const std::vector<std::byte> bytes = self.constrainer().save();
    write_list<std::byte>(bytes, static_cast<std::byte*>(data), size, "bytes");
  });
}

int tn_restore(tn_system* system, const void* data, size_t size) {
  return guard(system, [&](tn_system& self) {
    self.constrainer().restore(list_of(static_cast<const std::byte*>(data), size, "data"));
  });
}

}  // extern "C"
