#include "host/handle_state.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "base/checksum.hpp"
#include "base/memory.hpp"
#include "base/saved_frame.hpp"

namespace tanor::detail {

namespace {

SavedHeader header_of(std::uint64_t fingerprint) {
  return {.magic = {'t', 'a', 'n', 'o', 'r', ' ', 'c', 'o'}, .version = 1, .fingerprint = fingerprint};
}
constexpr SavedBy by{"/state", "a Constrainer", "other points or constraints"};

/// Returns a fingerprint of the masses and of the constraints, by the host's numbers.
std::uint64_t fingerprint_of(const HostParts& parts) {
  Checksum sum;
  const auto add = [&]<class Number>(Number number) { sum.add(std::span<const Number>(&number, 1)); };
  const HostPoints& points = parts.points();
  for (const Index point : points.of_host) add(points.mass[static_cast<std::size_t>(point)]);
  const Inventory& inventory = parts.inventory();
  for (ConstraintId id = 0; id < inventory.next_id(); ++id) {
    if (!inventory.has(id)) continue;
    add(inventory.kind(id));
    for (const Index point : inventory.points(id)) add(points.host_point[static_cast<std::size_t>(point)]);
  }
  return sum.value();
}

}  // namespace

std::vector<std::byte> save_state(HostParts* parts) {
  std::vector<double> numbers;
  Memory memory(&numbers);
  parts->exchange_memory(memory);
  const SavedHeader header = header_of(fingerprint_of(*parts));
  std::vector<std::uint64_t> words;
  for (const std::uint64_t word : std::bit_cast<std::array<std::uint64_t, 3>>(header)) words.push_back(word);
  for (const double number : numbers) words.push_back(std::bit_cast<std::uint64_t>(number));
  words.push_back(checksum_of(std::as_bytes(std::span(words))));
  const auto bytes = std::as_bytes(std::span(words));
  return {bytes.begin(), bytes.end()};
}

void restore_state(std::span<const std::byte> bytes, HostParts* parts) {
  const std::span<const std::byte> body = check_frame(bytes, header_of(fingerprint_of(*parts)), by);
  std::vector<double> numbers(body.size() / sizeof(double));
  if (!numbers.empty()) std::memcpy(numbers.data(), body.data(), numbers.size() * sizeof(double));
  Memory memory{std::span<const double>(numbers)};
  parts->exchange_memory(memory);
  memory.finish();
}

}  // namespace tanor::detail
