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

/// Reports of numbers alone, whose bytes have no gaps and stand in a snapshot in the order of the members.
template <class Report, class... Reports>
concept OneOf = (std::is_same_v<Report, Reports> || ...);
template <OneOf<RankChange, SingularPassage, Counters, EnergyReport, Violations, NearestToSingular, PhaseTimes> Report>
inline constexpr bool is_plain_bytes<Report> = true;

namespace {

SavedHeader header_of(std::uint64_t fingerprint) {
  return {.magic = {'t', 'a', 'n', 'o', 'r', ' ', 's', 't'}, .version = 9, .fingerprint = fingerprint};
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
  archive(report.violation, report.last_violation, report.nearest_to_singular, report.last_reciprocal_condition);
  archive(report.rank_changes.start, report.rank_changes.now, report.rank_changes.count, report.rank_changes.first);
  archive(report.singular_passages.count, report.singular_passages.first, report.times, report.energy);
  exchange_friction(archive, report.friction);
  archive(report.counters);
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
