#pragma once

#include <memory>
#include <vector>

#include <tanor/constrainer.hpp>

#include "dynamics/forms.hpp"
#include "host/periodic_images.hpp"
#include "host/point_transfer.hpp"
#include "host/row_sums.hpp"
#include "host/schur_determinant.hpp"

namespace tanor {

/// What stands behind a Constrainer: everything in the inner order, and what is known from call to call.
struct ConstrainedHost {
  Forms forms;
  Workspace& work = forms.work;
  const Model& model = forms.model;
  MultiplierForm& form = *forms.normal;
  Linearization& linearization = form.linearization();
  const PointTransfer transfer{model.numbering, model.parallel};
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
  // Scratch: [3n] each, then [d] each. `before`: in a cell, `r` before it moved.
  std::vector<double> r, before, v, f, w, eta;
  std::vector<double> rows, sum;
  const double* multipliers = nullptr;            // [d] of the call at hand
  std::vector<double> stress;                     // [9n], made where it is first wanted
  std::unique_ptr<SchurDeterminant> determinant;  // likewise

  ConstrainedHost(System system, const SolverOptions& given);

  std::size_t num_points() const { return model.num_points(); }
  /// The host's name for an inner row.
  std::size_t user_row(std::size_t row) const { return static_cast<std::size_t>(model.numbering.user_row[row]); }

  void check(const ConstraintForces& wanted) const;
  static bool wants_multipliers(const ConstraintForces& wanted) {
    return !wanted.multipliers.empty() || wanted.forces || wanted.stress;
  }

  /// The host's numbers in the inner order: where they are, or in `scratch`.
  const double* read(const ConstPointArray& array, std::vector<double>* scratch) const {
    if (const double* const there = transfer.straight(array)) return there;
    (void)transfer.gather(array, scratch->data());
    return scratch->data();
  }

  // ---- the cell ----

  void set_images(std::unique_ptr<PeriodicImages> given);
  void check_cell();
  System move_offsets();

  // ---- the way in ----

  const PeriodicCell* present_cell() const { return images ? &images->cell() : nullptr; }
  bool gather_place(const ConstPointArray& positions, double t, const PeriodicCell* cell);
  Outcome stand_at(const ConstPointArray& positions, double t, const PeriodicCell* cell);
  Outcome stand_at(const ConstPointArray& positions, double t) { return stand_at(positions, t, present_cell()); }
  Outcome check_place();
  void gather_moved(const ConstPointArray& positions);
  ProjectionReport step_positions(const PositionStep& step);

  // ---- the way out ----

  double scatter_moved(const PointArray& positions);
  void write(double factor, const ConstraintForces& wanted);
  double support_work(double h);
  void measure_step(const PositionStep& step, ConstraintReport* report);
  void note_worst_position(ConstraintReport* report);
};

}  // namespace tanor
