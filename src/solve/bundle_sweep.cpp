#include "solve/bundle_sweep.hpp"

#include <algorithm>

namespace tanor {

std::unique_ptr<BundleSweep> BundleSweep::make(const Constraints& constraints, const Numbering& numbering,
                                               std::span<const double> inverse_mass, int threads, bool eagerly,
                                               std::vector<Index>* islands) {
  std::unique_ptr<BundleSweep> result(new BundleSweep);
  result->bundles_ = take_bundles(constraints, numbering, inverse_mass, eagerly, islands);
  if (result->bundles_.empty()) return nullptr;

  Summary& summary = result->summary_;
  result->desks_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  for (Bundle& bundle : result->bundles_) {
    const IslandSchedule& schedule = bundle.schedule;
    const std::size_t entries = bundle.num_islands * static_cast<std::size_t>(schedule.num_slots);
    summary.parts += bundle.num_islands;
    summary.factor_nonzeros += entries;
    summary.pattern_nonzeros += entries - bundle.num_islands * schedule.num_fill_slots;
    summary.flops += static_cast<double>(bundle.num_islands) * schedule.flops();
    const Batch batch = bundle.batch(0);
    for (Desk& desk : result->desks_) {
      const auto enlarge = [](auto* list, std::size_t size) { list->resize(std::max(list->size(), size)); };
      for (auto* points : {&desk.r, &desk.v, &desk.w, &desk.dw}) enlarge(points, batch.num_points + batch.num_supports);
      for (auto* rods : {&desk.u, &desk.directions}) enlarge(rods, batch.num_rods);
      for (auto* rods : {&desk.b, &desk.x, &desk.sum, &desk.lengths}) enlarge(rods, batch.num_rods);
    }
  }
  summary.name = "bundles";
  summary.reason = std::to_string(summary.parts) + " islands of rods have " + std::to_string(result->bundles_.size()) +
                   (result->bundles_.size() == 1 ? " structure" : " structures");
  return result;
}

// ---- in and out ----

namespace {

using Batch = Bundle::Batch;

Eight* numbers_of(Eight3* points) {
  return &points->x;
}
const Eight* numbers_of(const Eight3* points) {
  return &points->x;
}

void read_points(const Batch& batch, const double* from, Eight3* to) {
  gather_sequences(from, batch.first_point, 3, 3 * batch.num_points, 1.0, numbers_of(to));
}
void read_supports(const Batch& batch, const double* from, Eight3* to) {
  gather_points(from, batch.supports, batch.num_supports, to + batch.num_points);
}
void write_points(const Batch& batch, const Eight3* from, double* to) {
  scatter_sequences(numbers_of(from), batch.first_point, 3, 3 * batch.num_points, 1.0, to);
}
void read_blocks(const Batch& batch, const double* from, Eight3* u) {
  if (batch.of.block_sign == 0.0) return gather_blocks(from, batch.blocks, batch.num_rods, u);
  gather_sequences(from, batch.blocks, 3, 3 * batch.num_rods, batch.of.block_sign, numbers_of(u));
}
void write_blocks(const Batch& batch, const Eight3* u, double* to) {
  if (batch.of.block_sign == 0.0) return scatter_blocks(u, batch.blocks, batch.num_rods, to);
  scatter_sequences(numbers_of(u), batch.blocks, 3, 3 * batch.num_rods, batch.of.block_sign, to);
}
void read_rows(const Batch& batch, const double* from, Eight* to) {
  if (!batch.of.rows_follow) return gather_rows(from, batch.rows, batch.num_rods, to);
  gather_sequences(from, batch.rows, 1, batch.num_rods, 1.0, to);
}
void write_rows(const Batch& batch, const Eight* from, double* to) {
  if (!batch.of.rows_follow) return scatter_rows(from, batch.rows, batch.num_rods, to);
  scatter_sequences(from, batch.rows, 1, batch.num_rods, 1.0, to);
}

/// Those of the next batch.
void call_for_points(const Batch& batch, const double* array) {
  call_for_sequences(array, batch.first_point + num_lanes, 3, 3 * batch.num_points);
}
void call_for_blocks(const Batch& batch, const double* array) {
  if (batch.of.block_sign != 0.0) call_for_sequences(array, batch.blocks + num_lanes, 3, 3 * batch.num_rods);
}
void call_for_rows(const Batch& batch, const double* array) {
  if (batch.of.rows_follow) call_for_sequences(array, batch.rows + num_lanes, 1, batch.num_rods);
}

/// Of a batch, an island a lane.
void include_residuals(const Largest& right_side, const Largest& residual, Elimination* found) {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    const double b = right_side.value[lane] + right_side.zero[lane], left = residual.value[lane] + residual.zero[lane];
    found->largest_right_side = larger(found->largest_right_side, b);
    found->residual = larger(found->residual, left);
    found->own_residual = larger(found->own_residual, own_residual(left, b));
  }
}

}  // namespace

// ---- batch by batch ----

/// work(batch, desk), with the desks cleared before: a thread a desk.
template <class Work>
void BundleSweep::for_each_batch(const Parallel& parallel, const Work& work) {
  for (Desk& desk : desks_) {
    desk.smallest = Eight{} + 1.0;
    desk.found = {};
    desk.projection = {};
  }
  for (Bundle& bundle : bundles_) {
    constexpr std::size_t least_rows = 2048;  // fewer are not worth a thread
    const std::size_t batches = bundle.num_batches;
    const std::size_t worthwhile = bundle.num_islands * bundle.topology.rods.size() / least_rows;
    const std::size_t shares = std::clamp<std::size_t>(worthwhile, 1, desks_.size());
    parallel.for_tasks(shares, [&](std::size_t k) {
      for (std::size_t number = batches * k / shares; number < batches * (k + 1) / shares; ++number)
        work(bundle.batch(number), desks_[k]);
    });
  }
}

Elimination BundleSweep::found() const {
  Elimination result;
  for (const Desk& desk : desks_) {
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      result.reciprocal_condition = std::min(result.reciprocal_condition, desk.smallest[lane]);
    result.largest_right_side = larger(result.largest_right_side, desk.found.largest_right_side);
    result.residual = larger(result.residual, desk.found.residual);
    result.own_residual = larger(result.own_residual, desk.found.own_residual);
  }
  return result;
}

Projection BundleSweep::reached() const {
  Projection result;
  for (const Desk& desk : desks_) {
    result.violation = larger(result.violation, desk.projection.violation);
    result.iterations = std::max(result.iterations, desk.projection.iterations);
  }
  return result;
}

/// Of the lengths that move, the others have 0; null where none does.
const Eight* BundleSweep::moving_lengths(const Batch& batch, double MovingScalar::*number, Desk* desk) {
  if (batch.moving_lengths == nullptr) return nullptr;
  Eight* const result = desk->lengths.data();
  for (std::size_t k = 0; k < batch.num_rods * num_lanes; ++k) {
    const MovingScalar* const length = batch.moving_lengths[k];
    result[k / num_lanes][k % num_lanes] = length != nullptr ? length->*number : 0.0;
  }
  return result;
}

/// With K and the factor of these places, or, where it `keeps` them, with those at hand.
Elimination BundleSweep::solve(const Parallel& parallel, const FreeMotion& motion, bool keeps, double* blocks,
                               double* lambda, double* w) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    for (const auto& [from, to] : {std::pair(motion.r, desk.r.data()), std::pair(motion.v, desk.v.data())}) {
      read_points(batch, from, to);
      read_supports(batch, from, to);
    }
    const bool is_same_for_all = motion.uniform != nullptr && batch.num_supports == 0;
    Eight3* const w0 = is_same_for_all ? nullptr : desk.w.data();
    if (w0 != nullptr) {
      motion.uniform != nullptr ? fill(w0, batch.num_points, *motion.uniform) : read_points(batch, motion.w0, w0);
      read_supports(batch, motion.w0, w0);
    }

    desk.right_side = desk.residual = {};
    evaluate_rods(topology, desk.r.data(), desk.v.data(), w0, batch.offsets,
                  moving_lengths(batch, &MovingScalar::second, &desk), desk.u.data(), desk.b.data(), &desk.right_side);
    call_for_points(batch, motion.r);
    call_for(batch.inverse_mass + batch.num_points + batch.num_supports, batch.num_points + batch.num_supports);
    if (!keeps) eliminate(topology, schedule, batch.inverse_mass, desk.u.data(), batch.factor, &desk.smallest);
    call_for_points(batch, motion.v);
    tanor::solve_negative(schedule, batch.factor, desk.b.data(), desk.x.data());
    if (!keeps) call_for_blocks(batch, blocks);
    apply(topology, batch.inverse_mass, desk.u.data(), desk.b.data(), desk.x.data(), desk.dw.data(), &desk.residual);
    include_residuals(desk.right_side, desk.residual, &desk.found);
    call_for_points(batch, w);
    call_for_rows(batch, lambda);
    call_for(batch.factor + schedule.num_slots, static_cast<std::size_t>(schedule.num_slots));
    is_same_for_all ? add(*motion.uniform, batch.num_points, desk.dw.data())
                    : add(w0, batch.num_points, desk.dw.data());

    write_points(batch, desk.dw.data(), w);
    if (!keeps) write_blocks(batch, desk.u.data(), blocks);
    write_rows(batch, desk.x.data(), lambda);
  });
  return found();
}

Elimination BundleSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double*,
                               double* lambda, double* w) {
  return solve(parallel, motion, false, blocks, lambda, w);
}

Elimination BundleSweep::solve_again(const Parallel& parallel, const FreeMotion& motion, double* blocks, double*,
                                     double* lambda, double* w) {
  return solve(parallel, motion, true, blocks, lambda, w);
}

Elimination BundleSweep::factorize(const Parallel& parallel, const double* blocks) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    read_blocks(batch, blocks, desk.u.data());
    eliminate(topology, schedule, batch.inverse_mass, desk.u.data(), batch.factor, &desk.smallest);
  });
  return found();
}

void BundleSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    read_rows(batch, b, desk.b.data());
    tanor::solve_negative(batch.structure().schedule, batch.factor, desk.b.data(), desk.x.data());
    write_rows(batch, desk.x.data(), x);
  });
}

bool BundleSweep::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    read_points(batch, points, desk.r.data());
    read_blocks(batch, blocks, desk.u.data());
    read_rows(batch, rows, desk.b.data());
    tanor::solve_negative(schedule, batch.factor, desk.b.data(), desk.x.data());
    move(topology, batch.inverse_mass, desk.u.data(), desk.x.data(), desk.r.data());
    write_points(batch, desk.r.data(), points);
    write_rows(batch, desk.x.data(), rows);
  });
  return true;
}

// ---- projections ----

Elimination BundleSweep::linearise(const Parallel& parallel, const double* r, double* blocks) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    read_points(batch, r, desk.r.data());
    read_supports(batch, r, desk.r.data());
    evaluate_directions(topology, desk.r.data(), batch.offsets, desk.u.data());
    eliminate(topology, schedule, batch.inverse_mass, desk.u.data(), batch.factor, &desk.smallest);
    write_blocks(batch, desk.u.data(), blocks);
  });
  return found();
}

/// evaluate(what violates the rows) and move(along the answer), until nothing does or it no longer becomes less.
template <class Evaluate, class Move>
void BundleSweep::iterate(const Batch& batch, double target, Desk* desk, const Evaluate& evaluate, const Move& move) {
  const auto violation = [&] {
    Largest largest;
    evaluate(&largest);
    return largest.read();
  };
  const Projection found = iterate_along_chord(target, violation, [&] {
    tanor::solve_negative(batch.structure().schedule, batch.factor, desk->b.data(), desk->x.data());
    move();
  });
  desk->projection.violation = larger(desk->projection.violation, found.violation);
  desk->projection.iterations = std::max(desk->projection.iterations, found.iterations);
}

Projection BundleSweep::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                          double* sum) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    read_points(batch, r, desk.r.data());
    read_supports(batch, r, desk.r.data());
    read_blocks(batch, blocks, desk.u.data());
    call_for_points(batch, r);
    call_for_blocks(batch, blocks);
    const auto move_along = [&, &topology = topology](const Eight* rows) {
      move(topology, batch.inverse_mass, desk.u.data(), rows, desk.r.data());
    };
    if (sum != nullptr) {
      read_rows(batch, sum, desk.sum.data());
      move_along(desk.sum.data());
    }
    const Eight* lengths = batch.lengths;
    if (const Eight* const moving = moving_lengths(batch, &MovingScalar::value, &desk)) {
      for (std::size_t a = 0; a < batch.num_rods; ++a) {
        const Eight constant = batch.lengths[a];
        desk.lengths.data()[a] = moving[a] == 0.0 ? constant : moving[a];
      }
      lengths = desk.lengths.data();
    }
    iterate(
        batch, target, &desk,
        [&, &topology = topology](Largest* largest) {
          evaluate_values(topology, desk.r.data(), batch.offsets, lengths, desk.b.data(), largest);
        },
        [&] {
          move_along(desk.x.data());
          for (std::size_t a = 0; sum != nullptr && a < batch.num_rods; ++a) desk.sum.data()[a] += desk.x.data()[a];
        });
    write_points(batch, desk.r.data(), r);
    if (sum != nullptr) write_rows(batch, desk.sum.data(), sum);
  });
  return reached();
}

Projection BundleSweep::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                           const double* r, double* v) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    read_points(batch, r, desk.r.data());
    read_supports(batch, r, desk.r.data());
    read_points(batch, v, desk.v.data());
    read_supports(batch, v, desk.v.data());
    read_blocks(batch, blocks, desk.u.data());
    call_for_points(batch, r);
    call_for_points(batch, v);
    call_for_blocks(batch, blocks);
    evaluate_directions(topology, desk.r.data(), batch.offsets, desk.directions.data());
    const Eight* const first_derivatives = moving_lengths(batch, &MovingScalar::first, &desk);
    iterate(
        batch, target, &desk,
        [&, &topology = topology](Largest* largest) {
          evaluate_rates(topology, desk.directions.data(), desk.v.data(), first_derivatives, desk.b.data(), largest);
        },
        [&, &topology = topology] { move(topology, batch.inverse_mass, desk.u.data(), desk.x.data(), desk.v.data()); });
    write_points(batch, desk.v.data(), v);
  });
  return reached();
}

void BundleSweep::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    read_points(batch, points, desk.r.data());
    read_blocks(batch, blocks, desk.u.data());
    read_rows(batch, rows, desk.x.data());
    move(batch.structure().topology, batch.inverse_mass, desk.u.data(), desk.x.data(), desk.r.data());
    write_points(batch, desk.r.data(), points);
  });
}

}  // namespace tanor
