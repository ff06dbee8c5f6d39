#pragma once

#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/forms.hpp"
#include "host/incoming_points.hpp"
#include "host/periodic_images.hpp"
#include "host/point_transfer.hpp"
#include "host/row_sums.hpp"
#include "host/schur_determinant.hpp"

namespace tanor {

/// What one call found in a part of the host's islands.
struct PartReport : ConstraintReport {
  double worst = -1.0;  ///< by how much `worst_row` is violated
};

/// Some islands of a host, planned together: everything in the inner order, and what is known from call to call. A call
/// is made of `find_…`, which writes nothing of the host's, and `write_…`, which follows where all parts have
/// succeeded. At supports, which several parts may share, `add_to_supports` adds to what the host's arrays hold.
struct ConstrainedHost {
  Forms forms;
  Workspace& work = forms.work;
  const Model& model = forms.model;
  MultiplierForm& form = *forms.normal;
  Linearization& linearization = form.linearization();
  PointTransfer transfer{model.numbering, model.parallel};
  RowSums sums{work};
  const SolverOptions options;
  /// Where K is, and the factor of S.
  struct Place {
    std::vector<double> r, host;  // [3n] positions; in a cell also as the host has them
    PeriodicCell cell;            // of these
    double time = 0.0;
    bool stands = false;       // K and the factor are there
    bool was_checked = false;  // the host's first positions were on the constraints
  } place;
  std::unique_ptr<PeriodicImages> images;  // null: there is no cell
  std::vector<Index> host_row;             // [inner row] the host's number of it
  // Scratch: [3n] each, then [d] each. `before`: in a cell, `r` before it moved.
  std::vector<double> r, before, v, f, w, eta;
  std::vector<double> rows, sum;
  const double* multipliers = nullptr;            // [d] of the call at hand
  bool has_moved_velocities = false;              // `v` is what the step makes of them; else it is not read yet
  std::vector<double> stress;                     // [9n], made where it is first wanted
  std::unique_ptr<SchurDeterminant> determinant;  // likewise
  bool was_called = false;                        // `place` holds the host's positions

  ConstrainedHost(System system, const SolverOptions& given);

  std::size_t num_points() const { return model.num_points(); }
  static bool wants_multipliers(const ConstraintForces& wanted) {
    return !wanted.multipliers.empty() || wanted.forces || wanted.stress;
  }

  // ---- the cell ----

  void set_images(std::unique_ptr<PeriodicImages> given);
  void check_cell();

  // ---- calls ----

  void find_positions(const PositionStep& step, PartReport* report);
  void write_positions(const PositionStep& step, PartReport* report);
  /// Stands there and reads the velocities; returns what is large among them.
  double find_speed(const VelocityStep& step, PartReport* report);
  /// `speed`: of the whole host.
  void find_velocities(const VelocityStep& step, double speed, PartReport* report);
  void write_velocities(const VelocityStep& step, PartReport* report);
  void find_accelerations(const HostState& at, PartReport* report);
  void write_accelerations(const HostState& at);
  void find_forces(const ConstPointArray& positions, const PointArray& forces, double time, PartReport* report);
  void write_forces(const PointArray& forces, PartReport* report);
  void find_nearest(const PointArray& positions, double time, PartReport* report);
  void write_nearest(const PointArray& positions, PartReport* report);
  void find_violation(const ConstPointArray& positions, double time, PartReport* report);
  LogDeterminant find_log_det(const ConstPointArray& positions, bool with_gradient, double time);
  void write_gradient(const PointArray& gradient);
  RankReport find_rank(const ConstPointArray& positions, double time);
  void add_to_supports(const ConstraintForces& wanted) const;
  void add_to_supports(const PointArray& gradient) const;

  // ---- the way in ----

  const PeriodicCell* present_cell() const { return images ? &images->cell() : nullptr; }
  bool find_place(const ConstPointArray& positions, double t, const PeriodicCell* cell, IncomingPoints* incoming);
  Outcome stand_at(const ConstPointArray& positions, double t, const PeriodicCell* cell, IncomingPoints* incoming);
  Outcome stand_at(const ConstPointArray& positions, double t) {
    LargestSquare largest;
    IncomingPoints incoming(transfer, &largest);
    return stand_at(positions, t, present_cell(), &incoming);
  }
  Outcome check_place(double h);
  void gather_moved(const ConstPointArray& positions);
  ProjectionReport step_positions(const PositionStep& step);

  // ---- the way out ----

  double scatter_moved(const PointArray& positions);
  void write_step_velocities(const PointArray& velocities);
  void write(double factor, const ConstraintForces& wanted);
  double support_work(double h);
  void measure_step(const PositionStep& step, PartReport* report);
  void note_worst(std::size_t row, double size, PartReport* report) const;
  void note_worst_position(PartReport* report);
};

}  // namespace tanor
