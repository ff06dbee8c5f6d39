#include "host/handle_state.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "base/checksum.hpp"
#include "base/memory.hpp"
#include "base/text.hpp"

namespace tanor {

namespace {

constexpr std::uint32_t format = 1;

struct Header {
  std::array<char, 8> magic{'t', 'a', 'n', 'o', 'r', ' ', 'c', 'o'};
  std::uint32_t version = format;
  std::uint32_t byte_order = 0x01020304;  // reads otherwise on a machine with another order
  std::uint64_t fingerprint = 0;
};

[[noreturn]] void refuse(const std::string& why) {
  throw InputError("/state", why);
}

/// Of the masses, and of what is constrained, as the host numbers it.
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

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  Checksum sum;
  sum.add(bytes);
  return sum.value();
}

}  // namespace

std::vector<std::byte> save_state(HostParts* parts) {
  std::vector<double> numbers;
  Memory memory(&numbers);
  parts->exchange_memory(memory);
  Header header;
  header.fingerprint = fingerprint_of(*parts);
  std::vector<std::uint64_t> words;
  for (const std::uint64_t word : std::bit_cast<std::array<std::uint64_t, 3>>(header)) words.push_back(word);
  for (const double number : numbers) words.push_back(std::bit_cast<std::uint64_t>(number));
  words.push_back(checksum_of(std::as_bytes(std::span(words))));
  const auto bytes = std::as_bytes(std::span(words));
  return {bytes.begin(), bytes.end()};
}

void restore_state(std::span<const std::byte> bytes, HostParts* parts) {
  const Header wanted;
  Header header;
  std::uint64_t sum = 0;
  if (bytes.size() < sizeof header + sizeof sum) refuse("it ends too early");
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != wanted.magic) refuse("these are no bytes that a Constrainer saved");
  if (header.byte_order != wanted.byte_order) refuse("it was saved on a machine with another order of bytes");
  if (header.version != wanted.version)
    refuse("its format is " + text(header.version) + ", this version of tanor reads " + text(wanted.version));
  std::memcpy(&sum, bytes.last(sizeof sum).data(), sizeof sum);
  if (sum != checksum_of(bytes.first(bytes.size() - sizeof sum)))
    refuse("it is damaged or cut off: its checksum is another one");
  if (header.fingerprint != fingerprint_of(*parts)) refuse("it belongs to other points or constraints");
  const std::span<const std::byte> body = bytes.subspan(sizeof header, bytes.size() - sizeof header - sizeof sum);
  std::vector<double> numbers(body.size() / sizeof(double));
  if (!numbers.empty()) std::memcpy(numbers.data(), body.data(), numbers.size() * sizeof(double));
  Memory memory{std::span<const double>(numbers)};
  parts->exchange_memory(memory);
  memory.finish();
}

}  // namespace tanor
