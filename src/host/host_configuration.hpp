#pragma once

#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/linearization.hpp"
#include "host/incoming_points.hpp"
#include "host/periodic_images.hpp"
#include "host/point_transfer.hpp"

namespace tanor {

/// The positions of a host at which K and the factor of S stand, in a periodic cell at the images that its constraints
/// mean. They serve the next call, too, where the same positions are given.
struct HostConfiguration {
  Workspace& work;
  Linearization& linearization;
  const PointTransfer& transfer;
  std::unique_ptr<PeriodicImages> images;  ///< null: there is no cell
  std::vector<double> r, host;             ///< [3n] positions; in a cell also as the host has them
  PeriodicCell cell;                       ///< of these
  double time = 0.0;
  bool stands = false;       ///< K and the factor are there
  bool was_checked = false;  ///< the host's first positions were on the constraints
  bool was_called = false;   ///< the positions are those with which the host's last call began

  /// All outlive it.
  HostConfiguration(Workspace& moving, Linearization& of_it, const PointTransfer& to_host)
      : work(moving), linearization(of_it), transfer(to_host), r(3 * moving.model().num_points()) {}

  void set_images(std::unique_ptr<PeriodicImages> given);
  const PeriodicCell* present_cell() const { return images ? &images->cell() : nullptr; }

  /// Goes to the host's positions in a cell; null: in the cell of `r`, if these are its positions bit by bit, else in
  /// the present one. What has to be brought there is added to `incoming`. Returns whether K and the factor of S stand
  /// there already.
  bool find(const ConstPointArray& positions, double t, const PeriodicCell* of_positions, IncomingPoints* incoming);
  /// The same, with K and the factor of S; what else is in `incoming` is brought, too.
  Outcome stand_at(const ConstPointArray& positions, double t, const PeriodicCell* of_positions,
                   IncomingPoints* incoming);
  /// In the present cell.
  Outcome stand_at(const ConstPointArray& positions, double t) {
    LargestSquare largest;
    IncomingPoints incoming(transfer, &largest);
    return stand_at(positions, t, present_cell(), &incoming);
  }
};

/// Positions of a host that a call moves.
struct MovedPositions {
  const HostConfiguration& place;
  std::vector<double> r;       ///< [3n]
  std::vector<double> before;  ///< in a cell: r before it moved

  /// The configuration outlives it.
  explicit MovedPositions(const HostConfiguration& from) : place(from), r(from.r.size()) {}

  /// r := the host's positions, at the images that constraints mean in the present cell.
  void gather(const ConstPointArray& positions);
  /// r := the host's positions after a step from `place`; where there is no cell `incoming` brings them.
  void follow(const ConstPointArray& positions, IncomingPoints* incoming);
  /// The host's positions := r, in a cell as moves, at whatever images they are. Returns the largest move.
  double scatter(const PointArray& positions);
};

}  // namespace tanor
