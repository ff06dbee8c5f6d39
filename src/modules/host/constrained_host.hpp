#pragma once

#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/forms.hpp"
#include "host/host_configuration.hpp"
#include "host/row_sums.hpp"
#include "host/schur_determinant.hpp"

namespace tanor::detail {

/// The findings of one call in a part of the host's islands.
struct PartReport : ConstraintReport {
  double worst = -1.0;  ///< violation of `worst_row`

  void take(ProjectionReport found) {
    outcome = std::move(found.outcome);
    iterations = found.iterations;
    violation = found.violation;
  }
};

/// Some islands of a host that are planned together, with all arrays in the inner order, and what is kept from call to
/// call. A call consists of `find_…`, and of `write_…` once all parts have succeeded, or else of `restore`, which
/// undoes what `find_…` has moved in place. Several parts may share a support; there `add_to_supports` adds to what the
/// host's arrays hold.
struct ConstrainedHost {
  Forms forms;
  Workspace& work = forms.work;
  const Model& model = forms.model;
  MultiplierForm& form = *forms.normal;
  Linearization& linearization = form.linearization();
  PointTransfer transfer{model.numbering, model.parallel};
  RowSums sums{work};
  std::vector<Index> host_row = model.numbering.user_row;  // [inner row] the host's number of the row
  HostConfiguration place{work, linearization, transfer};
  MovedPoints moved{transfer, 3 * num_points(), calls_functions(model.system)};  // positions
  MovedPoints velocities{transfer, 3 * num_points(), calls_functions(model.system)};
  std::vector<double> before;  // [3n] `moved` before it moved, in a cell only
  std::vector<double> eta;     // [3n] K lambda
  std::vector<double> stress;  // [9n], made on first use
  // Scratch: [3n], then [d] each.
  std::vector<double> w;
  std::vector<double> rows, sum;
  const double* multipliers = nullptr;            // [d] of the call at hand
  bool has_moved_velocities = false;              // in a step of positions; if false, velocities are not read yet
  std::unique_ptr<SchurDeterminant> determinant;  // made on first use

  ConstrainedHost(System system, const SolverOptions& options);

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
  /// Linearizes at the step's positions and reads the velocities. Returns the largest velocity, or the largest rate K'v
  /// + xi_t if that is larger and constraints depend on time.
  double find_speed(const VelocityStep& step, PartReport* report);
  /// `speed` is the largest `find_speed` of all parts.
  void find_velocities(const VelocityStep& step, double speed, PartReport* report);
  void write_velocities(const VelocityStep& step, PartReport* report);
  void find_accelerations(const HostState& at, PartReport* report);
  void write_accelerations(const HostState& at);
  void find_forces(const ConstPointArray& positions, const PointArray& forces, double time, PartReport* report);
  void write_forces(const PointArray& forces, const ConstraintForces& wanted, PartReport* report);
  /// Leaves the host's arrays as they were before `find_…`.
  void restore();
  void find_nearest(const PointArray& positions, double time, PartReport* report);
  void write_nearest(const PointArray& positions, PartReport* report);
  void find_violation(const ConstPointArray& positions, double time, PartReport* report);
  LogDeterminant find_log_det(const ConstPointArray& positions, bool with_gradient, double time);
  /// Writes the gradient that `find_log_det` found, and adds it to what the array holds at supports.
  void write_gradient(const PointArray& wanted) const;
  RankReport find_rank(const ConstPointArray& positions, double time);
  /// Adds to what the host's arrays hold at supports, which several parts may share.
  void add_to_supports(const ConstraintForces& wanted) const;

  // ---- parts of calls ----

  /// Returns true if constraints call functions of the host. These may throw in the middle of a step.
  static bool calls_functions(const System& system);
  /// Returns true if points may move in place. Where rows depend on others, a failing step decides the rank again, and
  /// memory may run out.
  bool may_move_in_place() const { return !linearization.dependences().is_found(); }
  Outcome check_place(double h);
  /// Copies the host's positions to `moved`, to the images that constraints mean in the present cell.
  void gather_positions(const ConstPointArray& positions);
  /// Takes the host's positions after a step from `place`, in place if that is allowed and there is no cell. Without a
  /// cell `incoming` copies them.
  void follow(const PointArray& positions, IncomingPoints* incoming);
  /// Moves the host's positions to `moved`. In a cell it adds the moves, so each point stays at the host's image.
  /// Returns the largest move if that is wanted, else 0.
  double write_moved(const PointArray& positions, bool measures);
  /// Writes what is wanted, except at supports, for `factor` times the multipliers, which belong to K at `place`.
  void write_reactions(double factor, const ConstraintForces& wanted);
  ProjectionReport step_positions(const PositionStep& step);
  void write_step_velocities(const PointArray& velocities);
  double support_work(double h, const double* v);
  void measure_step(const PositionStep& step, PartReport* report);
  void note_worst(std::size_t row, double size, PartReport* report) const;
  void note_worst_rate(PartReport* report) const;
  void note_worst_position(PartReport* report);
};

}  // namespace tanor::detail
