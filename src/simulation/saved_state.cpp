#include "simulation/saved_state.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <type_traits>

#include <tanor/enum_names.hpp>

#include "base/checksum.hpp"
#include "base/saved_frame.hpp"
#include "base/text.hpp"

namespace tanor {

namespace {

SavedHeader header_of(std::uint64_t fingerprint) {
  return {.magic = {'t', 'a', 'n', 'o', 'r', ' ', 's', 't'}, .version = 4, .fingerprint = fingerprint};
}
constexpr SavedBy by{"/snapshot", "a Simulation", "another system"};

[[noreturn]] void refuse(const std::string& why) {
  throw InputError("/snapshot", why);
}

template <class Number>
concept PlainNumber = std::is_arithmetic_v<Number> || std::is_enum_v<Number>;

template <class Enum>
bool is_value(Enum value) {
  return name_of(value) != "?";
}
bool is_value(Method method) {
  return std::ranges::any_of(methods(), [&](const MethodTraits& each) { return each.method == method; });
}

/// Counts the bytes of numbers, texts and lists.
struct Counter {
  template <class... Values>
  void operator()(const Values&... values) {
    (add(values), ...);
  }

  std::size_t bytes = 0;

 private:
  template <PlainNumber Number>
  void add(const Number&) {
    bytes += sizeof(Number);
  }
  template <class List>
  void add(const List& list) {
    bytes += sizeof(std::uint64_t) + std::as_bytes(std::span(list)).size();
  }
};

/// Appends numbers, texts and lists to bytes.
class Writer {
 public:
  explicit Writer(std::vector<std::byte>* bytes) : bytes_(*bytes) {}

  template <class... Values>
  void operator()(Values&... values) {
    (put(values), ...);
  }

 private:
  template <class Values>
  void append(const Values& values) {
    const auto bytes = std::as_bytes(std::span(values));
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  template <PlainNumber Number>
  void put(const Number& number) {
    append(std::span(&number, 1));
  }
  /// Of numbers or characters.
  template <class List>
  void put(const List& list) {
    const std::uint64_t size = list.size();
    put(size);
    append(list);
  }

  std::vector<std::byte>& bytes_;
};

/// Reads back what a Writer wrote.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }
  void finish() const {
    if (!left_.empty()) refuse("it holds " + text(left_.size()) + " bytes too many");
  }

 private:
  void copy(void* to, std::size_t size) {
    if (size > left_.size()) refuse("it ends too early");
    if (size > 0) std::memcpy(to, left_.data(), size);
    left_ = left_.subspan(size);
  }
  template <PlainNumber Number>
  void take(Number& number) {
    copy(&number, sizeof number);
    if constexpr (std::is_enum_v<Number>) {
      if (!is_value(number)) refuse("it holds " + text(static_cast<int>(number)) + ", no value of an enumeration");
    }
  }
  template <class List>
  void take(List& list) {
    std::uint64_t size = 0;
    take(size);
    if (size > left_.size() / sizeof(typename List::value_type)) refuse("it ends too early");
    list.resize(size);
    copy(list.data(), size * sizeof(typename List::value_type));
  }

  std::span<const std::byte> left_;
};

/// archive(number …) for everything in a snapshot, in one order for both directions.
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
          report.nearest_to_singular.reciprocal_condition, report.nearest_to_singular.time);
  archive(report.rank_changes.start, report.rank_changes.now, report.rank_changes.count, report.rank_changes.first);
  archive(report.singular_passages.count, report.singular_passages.first);
  archive(report.times.evaluate, report.times.assemble, report.times.factor, report.times.solve, report.times.friction);
  exchange_energy(archive, report.energy);
  exchange_friction(archive, report.friction);
  exchange_counters(archive, report.counters);
}

template <class Archive, class AnySnapshot>
void exchange(Archive& archive, AnySnapshot& snapshot) {
  archive(snapshot.time, snapshot.positions, snapshot.velocities);
  exchange_report(archive, snapshot.report);
  archive(snapshot.next_step, snapshot.last_error, snapshot.advance_begin, snapshot.advance_end,
          snapshot.discrete_state, snapshot.event_slopes, snapshot.memory, snapshot.drive_memory,
          snapshot.singular_memory, snapshot.rounding_memory, snapshot.stiff_memory, snapshot.state_before);
}

}  // namespace

std::vector<std::byte> pack(const Snapshot& snapshot, std::uint64_t fingerprint) {
  const SavedHeader header = header_of(fingerprint);
  const auto first = std::as_bytes(std::span(&header, 1));
  Counter counter;
  exchange(counter, snapshot);
  std::vector<std::byte> bytes;
  bytes.reserve(first.size() + counter.bytes + sizeof(std::uint64_t));
  bytes.assign(first.begin(), first.end());
  Writer writer(&bytes);
  exchange(writer, snapshot);
  const std::uint64_t sum = checksum_of(bytes);
  writer(sum);
  return bytes;
}

Snapshot unpack(std::span<const std::byte> bytes, std::uint64_t fingerprint) {
  Reader reader(check_frame(bytes, header_of(fingerprint), by));
  Snapshot snapshot;
  exchange(reader, snapshot);
  reader.finish();
  return snapshot;
}

}  // namespace tanor
