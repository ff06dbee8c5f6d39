#include "host/constrained_host.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "host/host_input.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

SolverOptions without_reuse(SolverOptions options) {
  options.reuse = false;  // factors inside the steps of methods are not kept
  return options;
}

}  // namespace

ConstrainedHost::ConstrainedHost(System system, const SolverOptions& options)
    : forms(std::move(system), without_reuse(options)) {
  w.resize(3 * num_points());
  eta.resize(3 * num_points());
  for (std::vector<double>* array : {&rows, &sum}) array->resize(model.num_rows());
}

bool ConstrainedHost::calls_functions(const System& system) {
  const auto calls = [](const Constraint& group) { return std::holds_alternative<UserConstraints>(group); };
  return std::ranges::any_of(system.constraints, calls);
}

// ---- the cell ----

void ConstrainedHost::set_images(std::unique_ptr<PeriodicImages> given) {
  place.set_images(std::move(given));
  check_cell();
}

/// Nearest images are unique only for rods that are shorter than half of the cell.
void ConstrainedHost::check_cell() {
  if (!place.images->are_nearest()) return;
  const double height = place.images->lattice().smallest_height();
  const std::vector<double>& lengths = sums.lengths();
  for (const RodRow& rod : sums.rods()) {
    const auto row = static_cast<std::size_t>(rod.row);
    if (lengths[row] < 0.5 * height) continue;
    const auto [length, apart] = texts_apart(std::array{lengths[row], height});
    throw InputError("/cell", work.name_row(row) + " has the length " + length +
                                  ", no less than half of the cell, whose faces are " + apart +
                                  " apart; tell which images the rods join");
  }
}

/// A step from positions off the constraints would put its correction into the velocities.
Outcome ConstrainedHost::check_place(double h) {
  constexpr double allowed = 1e-8;
  if (place.was_checked) return {};
  double violation = linearization.evaluate_values(place.r.data(), rows.data());
  std::size_t row = sums.worst_position_row(rows);
  if (violation > allowed && work.constraints.depends_on_time()) {
    // Lengths that are set before each step are those at its end; xi - h xi_t is the value with the lengths before.
    std::fill(w.begin(), w.end(), 0.0);
    (void)linearization.evaluate_rates(place.r.data(), w.data(), sum.data());
    for (std::size_t a = 0; a < rows.size(); ++a) rows[a] = std::min(std::abs(rows[a]), std::abs(rows[a] - h * sum[a]));
    row = sums.worst_position_row(rows);
    violation = rows[row] / sums.lengths()[row];
  }
  place.was_checked = violation <= allowed;
  if (place.was_checked) return {};
  if (!std::isfinite(violation)) return model.not_finite(place.time);
  return {Status::NotConverged, "the positions where the step begins violate " + work.name_row(row) + " by " +
                                    text(violation) +
                                    " of its length; project_positions puts them right, before the first forces"};
}

/// Takes the host's positions and projects them onto the constraints. If rows depend on others, the step may not be
/// along K, and the velocities are moved with it; otherwise they are moved when they are written.
ProjectionReport ConstrainedHost::step_positions(const PositionStep& step) {
  IncomingPoints incoming(transfer);
  follow(step.positions, &incoming);
  double* const v = velocities.use_copy();
  has_moved_velocities = step.velocities && linearization.dependences().is_found();
  if (has_moved_velocities) transfer.gather(step.velocities, v);
  ProjectionReport found =
      form.steps().project_step(step.time, step.step, moved.data(), place.images ? nullptr : &incoming,
                                has_moved_velocities ? v : nullptr, step.tolerance);
  moved.note_moved();
  return found;
}

void ConstrainedHost::gather_positions(const ConstPointArray& positions) {
  double* const r = moved.use_copy();
  if (!place.images) return transfer.gather(positions, r);
  place.set_offsets(place.images->cell());
  before.resize(place.r.size());
  transfer.gather(positions, before.data());
  place.images->unwrap(model.parallel, place.images->lattice(), before.data(), r);
  before.assign(r, r + before.size());
}

void ConstrainedHost::follow(const PointArray& positions, IncomingPoints* incoming) {
  if (!place.images) return moved.take(positions, may_move_in_place(), incoming);
  place.set_offsets(place.images->cell());
  double* const r = moved.use_copy();
  transfer.gather(positions, r);
  place.images->follow(model.parallel, Lattice(place.cell), place.r.data(), r);
  before.assign(r, r + place.r.size());
}

double ConstrainedHost::write_moved(const PointArray& positions, bool measures) {
  if (!place.images) return moved.give_back(positions, model.num_moving(), measures);
  const double* const r = moved.data();
  model.parallel.for_ranges(before.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) before[k] = r[k] - before[k];
  });
  return transfer.add(before.data(), model.num_moving(), positions);
}

void ConstrainedHost::write_reactions(double factor, const ConstraintForces& wanted) {
  const double* const blocks = linearization.blocks().data();
  if (!wanted.multipliers.empty()) {
    model.parallel.for_ranges(host_row.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) wanted.multipliers[host_row[a]] = factor * multipliers[a];
    });
  }
  if (wanted.forces) {
    model.gather.reactions(model.parallel, blocks, multipliers, eta.data());
    model.parallel.for_ranges(eta.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) eta[k] *= factor;
    });
    transfer.write(eta.data(), model.num_moving(), wanted.forces);
  }
  if (wanted.stress) {
    stress.resize(9 * num_points());
    sums.share_virial(multipliers, factor, blocks, place.r.data(), stress.data());
    transfer.scatter_tensors(stress.data(), model.num_moving(), wanted.stress);
  }
}

void ConstrainedHost::add_to_supports(const ConstraintForces& wanted) const {
  if (wanted.forces) transfer.add_last(eta.data(), model.num_moving(), 3, wanted.forces);
  if (wanted.stress) transfer.add_last(stress.data(), model.num_moving(), 9, wanted.stress);
}

/// Adds M^-1 K mu/h to the host's velocities, in place if they are packed in the inner order.
void ConstrainedHost::write_step_velocities(const PointArray& host) {
  double* const v = velocities.data();
  if (!has_moved_velocities) {
    double* const there = transfer.straight(host);
    if (there == nullptr) transfer.gather(host, v);
    linearization.add_reactions(multipliers, there != nullptr ? there : v);
    if (there != nullptr) return;
  }
  transfer.write(v, model.num_moving(), host);
}

void ConstrainedHost::restore() {
  moved.restore();
  velocities.restore();
}

/// Returns -h/2 lambda'(K'v_s + xi_t) with the velocities v_s of the supports in `v`. That is the work of lengths that
/// depend on time, and of moving supports, on the points through the `multipliers`.
double ConstrainedHost::support_work(double h, const double* v) {
  const auto moving = static_cast<std::ptrdiff_t>(3 * model.num_moving());
  std::fill(w.begin(), w.begin() + moving, 0.0);
  std::copy(v + moving, v + w.size(), w.begin() + moving);
  const bool rest = std::all_of(w.begin() + moving, w.end(), [](double x) { return x == 0.0; });
  if ((rest && !work.constraints.depends_on_time()) || model.num_rows() == 0) return 0.0;
  (void)linearization.evaluate_rates(place.r.data(), w.data(), rows.data());
  return -0.5 * h * model.parallel.sum(rows.size(), [&](std::size_t a) { return multipliers[a] * rows[a]; });
}

void ConstrainedHost::note_worst(std::size_t row, double size, PartReport* report) const {
  report->worst_row = static_cast<std::size_t>(host_row[row]);
  report->worst = size;
}

/// Notes the largest of the rates in `rows`.
void ConstrainedHost::note_worst_rate(PartReport* report) const {
  const std::size_t row = RowSums::worst_row(rows);
  note_worst(row, std::abs(rows[row]), report);
}

void ConstrainedHost::note_worst_position(PartReport* report) {
  if (rows.empty()) return;
  (void)linearization.evaluate_values(moved.data(), rows.data());
  const std::size_t row = sums.worst_position_row(rows);
  note_worst(row, std::abs(rows[row]) / sums.lengths()[row], report);
}

/// Measures a step from `place` to `moved`: all that its report says beside the positions.
void ConstrainedHost::measure_step(const PositionStep& step, PartReport* report) {
  note_worst_position(report);
  work.set_time(step.time - step.step);
  const double factor = 2.0 / step.step;
  const double* const blocks = linearization.blocks().data();
  report->virial = sums.virial(multipliers, factor, blocks, place.r.data());
  report->largest_turn = sums.largest_turn(blocks, place.r.data(), moved.data(), place.offset_changes());
  double* const v = velocities.data();
  if (step.velocities) {
    transfer.gather_last(step.velocities, model.num_moving(), v);
  } else {
    for (std::size_t k = 3 * model.num_moving(); k < place.r.size(); ++k)
      v[k] = (moved.data()[k] - place.r[k]) / step.step;
  }
  place.set_offsets(place.cell);
  report->work = factor * support_work(step.step, v);
}

}  // namespace tanor::detail
