#pragma once

#include <span>
#include <vector>

namespace tanor::embed {

/// The options in the words of a script.
struct RodOptions {
  std::vector<int> types;  ///< types of bonds
  double length = 0.0;     ///< length of all rods; 0 for the one that each has when it is first seen
  double tolerance = 0.0;  ///< |distance - length|/length that a step may leave; 0 for rounding
  int store_every = 0;     ///< steps from tensions to tensions; 0 if none are stored
};

/// Reads the words behind `fix ID group tanor/rods`:
///
///   bond 1 2 … [length initial|VALUE] [tolerance VALUE] [store no|yes|STEPS]
///
/// Throws std::invalid_argument with what is wrong.
RodOptions read_rod_options(std::span<char* const> words, int num_bond_types);

}  // namespace tanor::embed
