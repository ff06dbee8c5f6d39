#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <type_traits>

#include <tanor/constrainer.hpp>

/// \file One point in an array of a host, which need not be aligned.
namespace tanor::detail {

/// Returns the address of the host's point i, which has `width` numbers.
template <class Number>
auto* address_of(const BasicPointArray<Number>& array, std::size_t i, std::size_t width = 3) {
  using Byte = std::conditional_t<std::is_const_v<Number>, const std::byte, std::byte>;
  const auto stride = array.stride != 0 ? array.stride : static_cast<std::ptrdiff_t>(width * sizeof(double));
  const auto place = array.index != nullptr ? array.index[i] : static_cast<std::ptrdiff_t>(i);
  return reinterpret_cast<Byte*>(array.data) + place * stride;
}

inline std::array<double, 3> read_point(const ConstPointArray& from, std::size_t i) {
  std::array<double, 3> point;
  std::memcpy(point.data(), address_of(from, i), sizeof(point));
  return point;
}

inline void write_point(const std::array<double, 3>& point, const PointArray& to, std::size_t i) {
  std::memcpy(address_of(to, i), point.data(), sizeof(point));
}

}  // namespace tanor::detail
