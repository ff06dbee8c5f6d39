#pragma once

#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Neighbourhoods that lie on several ranks, whose errors are measured against all of their points. All functions are
/// collective.
class SharedNeighbourhoods {
 public:
  /// Gives the scales of `work`, which is being made, the lengths of all ranks' points.
  SharedNeighbourhoods(Workspace& work, const Part& part);

  /// Replaces one number for each neighbourhood here by the largest of all ranks.
  void find_largest(std::span<double> of_neighbourhoods) const;

 private:
  void measure_lengths(Workspace& work, const Part& part);

  Ranks& ranks_;
  std::size_t num_shared_;
  struct Shared {
    std::size_t here, of_all;
  };
  std::vector<Shared> shared_;  // ascending
};

}  // namespace tanor::detail
