#pragma once

#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/linearization.hpp"
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
    IncomingPoints incoming(transfer);
    return stand_at(positions, t, present_cell(), &incoming);
  }
};

}  // namespace tanor::detail
