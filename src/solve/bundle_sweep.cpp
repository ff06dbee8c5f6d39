#include "solve/bundle_sweep.hpp"

#include <algorithm>
#include <limits>

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
      for (auto* points : {&desk.r, &desk.v, &desk.w, &desk.dw}) enlarge(points, batch.num_places);
      for (auto* rods : {&desk.u, &desk.directions}) enlarge(rods, batch.num_rods);
      for (auto* rods : {&desk.b, &desk.x, &desk.sum, &desk.lengths}) enlarge(rods, batch.num_rods);
    }
  }
  summary.name = "bundles";
  summary.reason = std::to_string(summary.parts) + " islands of rods have " + std::to_string(result->bundles_.size()) +
                   (result->bundles_.size() == 1 ? " structure" : " structures");
  return result;
}

/// work(batch, desk), with the desks cleared before: a thread a desk.
template <class Work>
void BundleSweep::for_each_batch(const Parallel& parallel, const Work& work) {
  for (Desk& desk : desks_) {
    desk.smallest = Eight{} + 1.0;
    desk.right_side = desk.residual = {};
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
    result.largest_right_side = larger(result.largest_right_side, desk.right_side.read());
    result.residual = larger(result.residual, desk.residual.read());
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

Elimination BundleSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double*,
                               double* lambda, double* w) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    gather_points(motion.r, batch.points, batch.num_places, desk.r.data());
    gather_points(motion.v, batch.points, batch.num_places, desk.v.data());
    const std::size_t num_known = motion.uniform != nullptr ? batch.num_points : 0;
    if (num_known > 0) fill(desk.w.data(), num_known, *motion.uniform);
    gather_points(motion.w0, batch.points + num_known * num_lanes, batch.num_places - num_known,
                  desk.w.data() + num_known);

    evaluate_rods(topology, desk.r.data(), desk.v.data(), desk.w.data(), batch.offsets,
                  moving_lengths(batch, &MovingScalar::second, &desk), desk.u.data(), desk.b.data(), &desk.right_side);
    eliminate(topology, schedule, batch.inverse_mass, desk.u.data(), batch.factor, &desk.smallest);
    tanor::solve_negative(schedule, batch.factor, desk.b.data(), desk.x.data());
    apply(topology, batch.inverse_mass, desk.u.data(), desk.b.data(), desk.x.data(), desk.dw.data(), &desk.residual);
    add(desk.dw.data(), batch.num_points, desk.w.data());

    scatter_points(desk.w.data(), batch.points, batch.num_points, w);
    scatter_blocks(desk.u.data(), batch.blocks, batch.num_rods, blocks);
    scatter_rows(desk.x.data(), batch.rows, batch.num_rods, lambda);
  });
  return found();
}

Elimination BundleSweep::factorize(const Parallel& parallel, const double* blocks) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    gather_blocks(blocks, batch.blocks, batch.num_rods, desk.u.data());
    eliminate(topology, schedule, batch.inverse_mass, desk.u.data(), batch.factor, &desk.smallest);
  });
  return found();
}

void BundleSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    gather_rows(b, batch.rows, batch.num_rods, desk.b.data());
    tanor::solve_negative(batch.structure().schedule, batch.factor, desk.b.data(), desk.x.data());
    scatter_rows(desk.x.data(), batch.rows, batch.num_rods, x);
  });
}

bool BundleSweep::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    gather_points(points, batch.points, batch.num_points, desk.r.data());
    gather_blocks(blocks, batch.blocks, batch.num_rods, desk.u.data());
    gather_rows(rows, batch.rows, batch.num_rods, desk.b.data());
    tanor::solve_negative(schedule, batch.factor, desk.b.data(), desk.x.data());
    move(topology, batch.inverse_mass, desk.u.data(), desk.x.data(), desk.r.data());
    scatter_points(desk.r.data(), batch.points, batch.num_points, points);
    scatter_rows(desk.x.data(), batch.rows, batch.num_rods, rows);
  });
  return true;
}

// ---- projections ----

Elimination BundleSweep::linearise(const Parallel& parallel, const double* r, double* blocks) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    gather_points(r, batch.points, batch.num_places, desk.r.data());
    evaluate_directions(topology, desk.r.data(), batch.offsets, desk.u.data());
    eliminate(topology, schedule, batch.inverse_mass, desk.u.data(), batch.factor, &desk.smallest);
    scatter_blocks(desk.u.data(), batch.blocks, batch.num_rods, blocks);
  });
  return found();
}

/// evaluate(what violates the rows) and move(along the answer), until nothing does or it no longer becomes less.
template <class Evaluate, class Move>
void BundleSweep::iterate(const Batch& batch, double target, Desk* desk, const Evaluate& evaluate, const Move& move) {
  constexpr int most_iterations = 20;
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0;; ++k) {
    Largest largest;
    evaluate(&largest);
    const double violation = largest.read();
    if (violation <= target || !(violation < 0.3 * before) || k == most_iterations) {
      desk->projection.violation = larger(desk->projection.violation, violation);
      desk->projection.iterations = std::max(desk->projection.iterations, k);
      return;
    }
    before = violation;
    tanor::solve_negative(batch.structure().schedule, batch.factor, desk->b.data(), desk->x.data());
    move();
  }
}

Projection BundleSweep::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                          double* sum) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    gather_points(r, batch.points, batch.num_places, desk.r.data());
    gather_blocks(blocks, batch.blocks, batch.num_rods, desk.u.data());
    const auto move_along = [&](const Eight* rows) {
      move(topology, batch.inverse_mass, desk.u.data(), rows, desk.r.data());
    };
    if (sum != nullptr) {
      gather_rows(sum, batch.rows, batch.num_rods, desk.sum.data());
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
        [&](Largest* largest) {
          evaluate_values(topology, desk.r.data(), batch.offsets, lengths, desk.b.data(), largest);
        },
        [&] {
          move_along(desk.x.data());
          for (std::size_t a = 0; sum != nullptr && a < batch.num_rods; ++a) desk.sum.data()[a] += desk.x.data()[a];
        });
    scatter_points(desk.r.data(), batch.points, batch.num_points, r);
    if (sum != nullptr) scatter_rows(desk.sum.data(), batch.rows, batch.num_rods, sum);
  });
  return reached();
}

Projection BundleSweep::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                           const double* r, double* v) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    const auto& [topology, schedule] = batch.structure();
    gather_points(r, batch.points, batch.num_places, desk.r.data());
    gather_points(v, batch.points, batch.num_places, desk.v.data());
    gather_blocks(blocks, batch.blocks, batch.num_rods, desk.u.data());
    evaluate_directions(topology, desk.r.data(), batch.offsets, desk.directions.data());
    const Eight* const first_derivatives = moving_lengths(batch, &MovingScalar::first, &desk);
    iterate(
        batch, target, &desk,
        [&](Largest* largest) {
          evaluate_rates(topology, desk.directions.data(), desk.v.data(), first_derivatives, desk.b.data(), largest);
        },
        [&] { move(topology, batch.inverse_mass, desk.u.data(), desk.x.data(), desk.v.data()); });
    scatter_points(desk.v.data(), batch.points, batch.num_points, v);
  });
  return reached();
}

void BundleSweep::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  for_each_batch(parallel, [&](const Batch& batch, Desk& desk) {
    gather_points(points, batch.points, batch.num_points, desk.r.data());
    gather_blocks(blocks, batch.blocks, batch.num_rods, desk.u.data());
    gather_rows(rows, batch.rows, batch.num_rods, desk.x.data());
    move(batch.structure().topology, batch.inverse_mass, desk.u.data(), desk.x.data(), desk.r.data());
    scatter_points(desk.r.data(), batch.points, batch.num_points, points);
  });
}

}  // namespace tanor
