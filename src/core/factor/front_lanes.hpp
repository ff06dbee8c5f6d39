#pragma once

#include <cstddef>
#include <type_traits>
#include <utility>

#include "base/pack.hpp"
#include "factor/front_kernels.hpp"

/// \file The kernels of a factorization and those of a substitution share these functions.
namespace tanor::detail::kernels {

static_assert(front_width == num_lanes);

inline constexpr std::size_t tile = 4;  // columns that are worked on at once

/// Returns the first row of the lanes that hold row i.
constexpr std::size_t lanes_of(std::size_t i) {
  return i / front_width * front_width;
}

/// Calls body with the number of columns, 1 … most, as a compile-time constant.
template <std::size_t most = tile, class Body>
[[gnu::always_inline]] inline void with_columns(std::size_t columns, const Body& body) {
  if constexpr (most > 1) {
    if (columns < most) return with_columns<most - 1>(columns, body);
  }
  body(std::integral_constant<std::size_t, most>{});
}

/// Calls body(0), body(1), … with compile-time constants below `count`, without a loop.
template <std::size_t count, class Body>
[[gnu::always_inline]] inline void for_constants(const Body& body) {
  [&body]<std::size_t... k>(std::index_sequence<k...>) __attribute__((always_inline)) {
    (body(std::integral_constant<std::size_t, k>{}), ...);
  }
  (std::make_index_sequence<count>{});
}

}  // namespace tanor::detail::kernels
