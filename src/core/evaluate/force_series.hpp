#pragma once

#include <span>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "evaluate/family.hpp"
#include "evaluate/program_family.hpp"
#include "evaluate/time_series.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The active forces of a system as series in time.
///
/// Forces write blocks of three numbers, one for each member or for each of its points. `incidences` gives the points
/// of the blocks; gathered point by point, the blocks are the force there.
class ForceSeries {
 public:
  ForceSeries(const System& system, const Numbering& numbering, double t0);

  /// Names the force that has no series, and why. Returns an empty string if all have one.
  const std::string& obstacle() const { return obstacle_; }
  const std::vector<Incidence>& incidences() const { return incidences_; }
  std::size_t num_blocks() const { return static_cast<std::size_t>(num_blocks_); }

  void begin(double t, int order);
  double smooth_until() const { return table_.smooth_until(); }

  /// Writes coefficient k of the force in each block. The points are known up to k + 1.
  void advance(const Parallel& parallel, int k, std::span<double* const> coefficients, double* blocks);
  /// Returns the acceleration of gravity, which is the same everywhere, m/s^2.
  Vec3 gravity() const { return gravity_; }

 private:
  struct Group {
    ProgramFamily family;
    Index first_block;
    bool is_energy;  // blocks are -dU/dr of each point instead of the program's results
    std::size_t blocks_of_member;
  };
  class Reader;
  template <class Lane>
  static void write_forces(const Group& group, const Lane* lanes, std::size_t chunk, int k, double* blocks);

  Vec3 gravity_{};
  TimeSeriesTable table_;
  std::vector<Group> groups_;
  std::vector<Incidence> incidences_;
  Index num_blocks_ = 0;
  std::string obstacle_;
};

}  // namespace tanor::detail
