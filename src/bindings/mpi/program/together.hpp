#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/messages.hpp"
#include "mpi/tanor_mpi.hpp"

namespace tanor::mpi {

/// Thrown on every rank if one of them could not do its part of something.
struct SomeRankFailed {
  cli::Failure failure;
};

/// Lets every rank do something without the others. What goes wrong on some rank goes wrong on all, as the first rank
/// that failed explains it.
void do_together(MpiRanks& ranks, const std::function<void()>& work);

/// Lets the first rank do something for all.
void do_on_first(MpiRanks& ranks, const std::function<void()>& work);

/// Returns [rank] the text of each rank.
std::vector<std::string> gather_texts(MpiRanks& ranks, const std::string& own);

/// Returns [rank] the lines of each rank.
std::vector<std::vector<std::string>> gather_lines(MpiRanks& ranks, const std::vector<std::string>& own);

}  // namespace tanor::mpi
