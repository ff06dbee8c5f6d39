#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

/// \file Arrays of any size. Counts of MPI are int, so that large arrays go in pieces.
namespace tanor {

constexpr std::size_t largest_piece = std::size_t{1} << 28;  // elements of one call: numbers or bytes

/// Calls call(pointer, count) for pieces of the numbers, one behind the other.
template <class Number, class Call>
void in_pieces(std::span<Number> numbers, const Call& call, std::size_t most = largest_piece) {
  for (std::size_t first = 0; first < numbers.size(); first += most)
    call(numbers.data() + first, static_cast<int>(std::min(most, numbers.size() - first)));
}

}  // namespace tanor
