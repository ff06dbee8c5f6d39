#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

/// \file Serialization of numbers, texts, lists and structs made of them, in the byte order of this machine. A type
/// that is neither a number nor a list names its parts in a function visit_parts(value, visit), which calls visit(part
/// …).
namespace tanor::detail {

/// True for types that are copied byte by byte: numbers, and structs that declare themselves here because they have no
/// gaps.
template <class Value>
inline constexpr bool is_plain_bytes = std::is_arithmetic_v<Value> || std::is_enum_v<Value>;
template <class Value>
concept PlainBytes = is_plain_bytes<Value>;
template <class Value>
concept ByteList = !PlainBytes<Value> && requires(Value list) {
  list.data();
  list.resize(0);
};

/// Writes values as bytes and passes these on by to(std::span<const std::byte>).
template <class Sink>
class ByteWriter {
 public:
  explicit ByteWriter(Sink to) : to_(to) {}

  template <class... Values>
  void operator()(const Values&... values) const {
    (put(values), ...);
  }

 private:
  template <PlainBytes Value>
  void put(const Value& value) const {
    to_(std::as_bytes(std::span(&value, 1)));
  }
  template <ByteList List>
  void put(const List& list) const {
    put(std::uint64_t{list.size()});
    if constexpr (PlainBytes<typename List::value_type>) {
      to_(std::as_bytes(std::span(list)));
    } else {
      for (const auto& item : list) put(item);
    }
  }
  template <class Value>
  void put(const Value& value) const {
    visit_parts(value, *this);
  }

  Sink to_;
};

/// Thrown if the bytes end before the values that they begin.
struct EndsTooEarly {};

/// Reads back what a ByteWriter wrote. Throws EndsTooEarly before it allocates more items than the bytes can hold.
/// Calls check(number) for each number that it reads, apart from the items of lists of numbers.
template <class Check>
class ByteReader {
 public:
  ByteReader(std::span<const std::byte> bytes, Check check) : left_(bytes), check_(check) {}

  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }
  std::size_t num_left() const { return left_.size(); }

 private:
  void copy(void* to, std::size_t size) {
    if (size > left_.size()) throw EndsTooEarly();
    if (size > 0) std::memcpy(to, left_.data(), size);
    left_ = left_.subspan(size);
  }
  template <PlainBytes Value>
  void take(Value& value) {
    copy(&value, sizeof value);
    check_(value);
  }
  template <ByteList List>
  void take(List& list) {
    using Item = typename List::value_type;
    constexpr std::size_t least_bytes = PlainBytes<Item> ? sizeof(Item) : sizeof(std::uint64_t);
    std::uint64_t size = 0;
    copy(&size, sizeof size);
    if (size > left_.size() / least_bytes) throw EndsTooEarly();
    list.resize(size);
    if constexpr (PlainBytes<Item>) {
      copy(list.data(), size * sizeof(Item));
    } else {
      for (Item& item : list) take(item);
    }
  }
  template <class Value>
  void take(Value& value) {
    visit_parts(value, *this);
  }

  std::span<const std::byte> left_;
  Check check_;
};

}  // namespace tanor::detail
