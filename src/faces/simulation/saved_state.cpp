#include "simulation/saved_state.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <type_traits>

#include <tanor/enum_names.hpp>

#include "base/archive.hpp"
#include "base/checksum.hpp"
#include "base/saved_frame.hpp"
#include "base/text.hpp"

namespace tanor::detail {

template <>
inline constexpr bool is_plain_bytes<RankChange> = true;
template <>
inline constexpr bool is_plain_bytes<SingularPassage> = true;

namespace {

SavedHeader header_of(std::uint64_t fingerprint) {
  return {.magic = {'t', 'a', 'n', 'o', 'r', ' ', 's', 't'}, .version = 7, .fingerprint = fingerprint};
}
constexpr SavedBy by{"/snapshot", "a Simulation", "another system"};

[[noreturn]] void refuse(const std::string& why) {
  throw InputError("/snapshot", why);
}

template <class Enum>
bool is_value(Enum value) {
  return name_of(value) != "?";
}
bool is_value(Method method) {
  return std::ranges::any_of(methods(), [&](const MethodTraits& each) { return each.method == method; });
}

/// Refuses numbers that are no value of their enumeration.
struct CheckEnum {
  template <class Number>
  void operator()(const Number& number) const {
    if constexpr (std::is_enum_v<Number>) {
      if (!is_value(number)) refuse("it holds " + text(static_cast<int>(number)) + ", no value of an enumeration");
    }
  }
};

/// Calls archive(number …) for everything in a snapshot, in one order for both directions.
template <class Archive, class Counters>
void exchange_counters(Archive& archive, Counters& counters) {
  archive(counters.evaluations, counters.factorizations, counters.solves, counters.iterations,
          counters.split_factorizations, counters.rank_decisions, counters.friction_solves,
          counters.friction_iterations);
}

template <class Archive, class Energy>
void exchange_energy(Archive& archive, Energy& energy) {
  archive(energy.start, energy.now, energy.kinetic, energy.potential, energy.potential_at_start,
          energy.work_of_supports, energy.work_of_forces, energy.work_of_potentials, energy.work_of_friction,
          energy.scale, energy.largest_drift, energy.largest_drift_time);
}

template <class Archive, class Friction>
void exchange_friction(Archive& archive, Friction& friction) {
  archive(friction.solves, friction.iterations_mean, friction.iterations_max, friction.contraction_max,
          friction.error_bound, friction.uniqueness, friction.method_used, friction.residual_max, friction.several,
          friction.first_several, friction.uniqueness_reason);
}

template <class Archive, class Report>
void exchange_report(Archive& archive, Report& report) {
  archive(report.method, report.method_reason, report.time, report.steps, report.rejected, report.last_step,
          report.accuracy_warning, report.events, report.last_event);
  archive(report.start.position_correction, report.start.velocity_correction, report.start.relative);
  archive(report.violation.position, report.violation.velocity, report.violation.acceleration,
          report.last_violation.position, report.last_violation.velocity, report.last_violation.acceleration,
          report.nearest_to_singular.reciprocal_condition, report.nearest_to_singular.time,
          report.last_reciprocal_condition);
  archive(report.rank_changes.start, report.rank_changes.now, report.rank_changes.count, report.rank_changes.first);
  archive(report.singular_passages.count, report.singular_passages.first);
  archive(report.times.evaluate, report.times.assemble, report.times.factor, report.times.solve, report.times.friction);
  exchange_energy(archive, report.energy);
  exchange_friction(archive, report.friction);
  exchange_counters(archive, report.counters);
}

template <class Archive, class AnySnapshot>
void exchange(Archive& archive, AnySnapshot& snapshot) {
  archive(snapshot.time, snapshot.positions, snapshot.velocities, snapshot.taken, snapshot.observed,
          snapshot.observed_names);
  exchange_report(archive, snapshot.report);
  archive(snapshot.next_step, snapshot.last_error, snapshot.advance_begin, snapshot.advance_end,
          snapshot.discrete_state, snapshot.event_slopes, snapshot.memory, snapshot.drive_memory,
          snapshot.singular_memory, snapshot.rounding_memory, snapshot.stiff_memory, snapshot.state_before);
}

}  // namespace

std::vector<std::byte> pack(const Snapshot& snapshot, std::uint64_t fingerprint) {
  const SavedHeader header = header_of(fingerprint);
  const auto first = std::as_bytes(std::span(&header, 1));
  std::size_t size = first.size() + sizeof(std::uint64_t);
  ByteWriter counter([&](std::span<const std::byte> part) { size += part.size(); });
  exchange(counter, snapshot);
  std::vector<std::byte> bytes;
  bytes.reserve(size);
  ByteWriter writer([&](std::span<const std::byte> part) { bytes.insert(bytes.end(), part.begin(), part.end()); });
  bytes.assign(first.begin(), first.end());
  exchange(writer, snapshot);
  writer(checksum_of(bytes));
  return bytes;
}

Snapshot unpack(std::span<const std::byte> bytes, std::uint64_t fingerprint) {
  ByteReader reader(check_frame(bytes, header_of(fingerprint), by), CheckEnum());
  Snapshot snapshot;
  try {
    exchange(reader, snapshot);
  } catch (const EndsTooEarly&) {
    refuse("it ends too early");
  }
  if (reader.num_left() > 0) refuse("it holds " + text(reader.num_left()) + " bytes too many");
  return snapshot;
}

}  // namespace tanor::detail
