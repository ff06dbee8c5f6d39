#include "simulation/saved_state.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <type_traits>

#include <tanor/enum_names.hpp>
#include <tanor/report_fields.hpp>

#include "base/archive.hpp"
#include "base/checksum.hpp"
#include "base/saved_frame.hpp"
#include "base/text.hpp"

namespace tanor::detail {

template <class AnyTruth, class Visit>
void visit_parts(AnyTruth& truth, Visit& visit) requires std::is_same_v<std::remove_const_t<AnyTruth>, Truth> {
  visit(truth.is_true, truth.is_given_up, truth.last_passage, truth.looks);
}

namespace {

SavedHeader header_of(std::uint64_t fingerprint) {
  return {.magic = {'t', 'a', 'n', 'o', 'r', ' ', 's', 't'}, .version = 15, .fingerprint = fingerprint};
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
template <class Archive, class AnySnapshot>
void exchange(Archive& archive, AnySnapshot& snapshot) {
  archive(snapshot.time, snapshot.positions, snapshot.velocities, snapshot.taken, snapshot.extremes, snapshot.passages,
          snapshot.truths, snapshot.report, snapshot.next_step, snapshot.last_error, snapshot.advance_begin,
          snapshot.advance_end, snapshot.discrete_state, snapshot.event_slopes, snapshot.memory, snapshot.drive_memory,
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
