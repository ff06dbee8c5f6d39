#pragma once

#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/linearization.hpp"
#include "host/incoming_points.hpp"
#include "host/moved_points.hpp"
#include "host/periodic_images.hpp"
#include "host/point_transfer.hpp"

namespace tanor::detail {

/// The positions of a host at which K and the factor of S were evaluated, in a periodic cell at the images that its
/// constraints mean. The next call uses them again if it is given the same positions.
struct HostConfiguration {
  Workspace& work;
  Linearization& linearization;
  const PointTransfer& transfer;
  std::unique_ptr<PeriodicImages> images;  ///< null if there is no cell
  std::vector<double> r, host;             ///< [3n] positions; in a cell `host` has them as the host does
  PeriodicCell cell;                       ///< the cell of these positions
  PeriodicCell cell_of_offsets;            ///< the cell for which constraints are evaluated
  double time = 0.0;
  bool stands = false;       ///< K and the factor belong to `r`
  bool was_checked = false;  ///< the host's first positions were on the constraints
  bool was_called = false;   ///< the positions are those with which the host's last call began

  /// All arguments outlive it.
  HostConfiguration(Workspace& moving, Linearization& of_it, const PointTransfer& to_host)
      : work(moving), linearization(of_it), transfer(to_host), r(3 * moving.model().num_points()) {}

  void set_images(std::unique_ptr<PeriodicImages> given);
  /// Gives rods that close a way round the cell their offsets in a cell, with which constraints are evaluated from here
  /// on.
  void set_offsets(const PeriodicCell& of_cell);
  /// Returns by how much these offsets differ in the present cell from those in the cell of `r`.
  std::span<const Constraints::RowOffset> offset_changes();
  const PeriodicCell* present_cell() const { return images ? &images->cell() : nullptr; }

  /// Goes to the host's positions in the cell `of_positions`. If that is null, the cell is that of `r` if these are its
  /// positions bit by bit, else the present one. Positions that have to be copied are added to `incoming`. Returns true
  /// if K and the factor of S belong to these positions already.
  bool find(const ConstPointArray& positions, double t, const PeriodicCell* of_positions, IncomingPoints* incoming);
  /// Does the same and evaluates K and the factor of S. All arrays in `incoming` are copied.
  Outcome stand_at(const ConstPointArray& positions, double t, const PeriodicCell* of_positions,
                   IncomingPoints* incoming);
  /// Does the same in the present cell.
  Outcome stand_at(const ConstPointArray& positions, double t) {
    LargestSquare largest;
    IncomingPoints incoming(transfer, &largest);
    return stand_at(positions, t, present_cell(), &incoming);
  }
};

/// Positions of a host that a call moves.
class MovedPositions {
 public:
  /// The configuration outlives it. If `keeps_copy` is true, nothing is moved in place.
  MovedPositions(HostConfiguration& from, bool keeps_copy)
      : place_(from), points_(from.transfer, from.r.size(), keeps_copy) {}

  double* r() { return points_.data(); }  ///< [3n]
  MovedPoints& points() { return points_; }

  /// Copies the host's positions, to the images that constraints mean in the present cell.
  void gather(const ConstPointArray& positions);
  /// Takes the host's positions after a step from `place`, in place if that is allowed and there is no cell. Without a
  /// cell `incoming` copies them.
  void follow(const PointArray& positions, bool in_place, IncomingPoints* incoming);
  /// Moves the host's positions to r. In a cell it adds the moves, so each point stays at the host's image. Returns the
  /// largest move if that is wanted, else 0.
  double write(const PointArray& positions, bool measures);

 private:
  HostConfiguration& place_;
  MovedPoints points_;
  std::vector<double> before_;  // r before it moved, in a cell only
};

}  // namespace tanor::detail
