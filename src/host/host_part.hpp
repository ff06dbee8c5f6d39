#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host/constrained_host.hpp"
#include "host/host_points.hpp"
#include "host/inventory.hpp"

namespace tanor {

/// What constraints connect. Its key is its smallest point.
struct HostIsland {
  Index key;
  std::int64_t weight;  ///< points and rows
};

/// The multipliers of a row in the last two steps, from which the next step's are guessed (see StepProjection).
struct MultiplierGuess {
  ConstraintId id;
  std::size_t row;  ///< of that constraint
  double last, before;
  bool was_checked;  ///< the host's positions were on the constraint
};

/// Some islands of a host that are planned together, by the host's numbers; the plan itself is `host`.
struct HostPart {
  std::vector<HostIsland> islands;       ///< ascending, like the lists below
  std::vector<Index> moving, places;     ///< points without and with supports
  std::vector<ConstraintId> members;     ///< its constraints
  std::vector<MultiplierGuess> guesses;  ///< until there is a plan
  std::unique_ptr<ConstrainedHost> host;
  bool has_own_threads = false;  ///< else it shares them with other parts

  Index key() const { return islands.front().key; }
  /// The plan's rows := the host's numbers of them, which have changed.
  void number_rows(const Inventory& inventory);
  /// The plan's points := the host's numbers of them, which have changed.
  void number_points(const HostPoints& points) const;

 private:
  bool has_rows_ = false;                     // their numbers
  std::size_t first_row_ = 0, last_row_ = 0;  // of the first and the last member
};

}  // namespace tanor
