#pragma once

#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

/// \file Arrays of any size. Counts of MPI are int, so that large arrays go in pieces.
namespace tanor {

constexpr std::size_t largest_piece = std::size_t{1} << 28;  // elements of one call: numbers or bytes

/// Calls call(pointer, count) for pieces of the numbers, one behind the other.
template <class Number, class Call>
void in_pieces(std::span<Number> numbers, const Call& call, std::size_t most = largest_piece) {
  for (std::size_t first = 0; first < numbers.size(); first += most)
    call(numbers.data() + first, static_cast<int>(std::min(most, numbers.size() - first)));
}

constexpr int tag_of_arrays = 18;

/// Sends an array to a rank that takes it by `receive_array` with the same pieces.
template <class Number>
void send_array(MPI_Comm communicator, int to, std::span<const Number> numbers, std::size_t most = largest_piece) {
  const std::uint64_t size = numbers.size();
  MPI_Send(&size, 1, MPI_UINT64_T, to, tag_of_arrays, communicator);
  in_pieces(
      std::as_bytes(numbers),
      [&](const std::byte* first, int count) { MPI_Send(first, count, MPI_BYTE, to, tag_of_arrays, communicator); },
      most);
}

template <class Number>
std::vector<Number> receive_array(MPI_Comm communicator, int from, std::size_t most = largest_piece) {
  static_assert(std::is_trivially_copyable_v<Number>);
  std::uint64_t size = 0;
  MPI_Recv(&size, 1, MPI_UINT64_T, from, tag_of_arrays, communicator, MPI_STATUS_IGNORE);
  std::vector<Number> numbers(size);
  in_pieces(
      std::as_writable_bytes(std::span(numbers)),
      [&](std::byte* first, int count) {
        MPI_Recv(first, count, MPI_BYTE, from, tag_of_arrays, communicator, MPI_STATUS_IGNORE);
      },
      most);
  return numbers;
}

}  // namespace tanor
