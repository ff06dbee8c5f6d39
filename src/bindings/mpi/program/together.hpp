#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/archive.hpp"
#include "mpi/tanor_mpi.hpp"

namespace tanor::mpi {

/// Lets every rank do something without the others. What goes wrong on some rank goes wrong on all, as the first rank
/// that failed explains it: as an InputError, or as std::runtime_error where the machine has failed.
void do_together(MpiRanks& ranks, const std::function<void()>& work);

/// Lets the first rank do something for all.
void do_on_first(MpiRanks& ranks, const std::function<void()>& work);

/// Returns [rank] the value of each rank: a text, or a list (base/archive.hpp).
template <class Value>
std::vector<Value> gather(MpiRanks& ranks, const Value& own) {
  std::string bytes;
  detail::ByteWriter([&](std::span<const std::byte> part) {
    bytes.append(reinterpret_cast<const char*>(part.data()), part.size());
  })(own);
  std::vector<Value> all(static_cast<std::size_t>(ranks.size()));
  for (int rank = 0; rank < ranks.size(); ++rank) {
    std::string of_rank = bytes;
    ranks.share(rank, &of_rank);
    detail::ByteReader(std::as_bytes(std::span(of_rank)), [](const auto&) {})(all[static_cast<std::size_t>(rank)]);
  }
  return all;
}

}  // namespace tanor::mpi
