#include "schur/batch_solver.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"
#include "schur/batch_numbers.hpp"

namespace tanor::detail {

std::unique_ptr<BatchSolver> BatchSolver::make(const SchurProblem& problem, int threads, bool eagerly,
                                               std::vector<Index>* islands) {
  std::unique_ptr<BatchSolver> result(new BatchSolver);
  const std::vector<Index> before = *islands;
  result->equal_islands_ =
      take_equal_islands(problem.constraints, problem.numbering, problem.inverse_mass, eagerly, islands);
  if (result->equal_islands_.empty()) return nullptr;
  result->serve(problem, before, *islands);

  Summary& summary = result->summary_;
  result->workspaces_.resize(static_cast<std::size_t>(Parallel(threads).threads()));
  for (EqualIslands& each : result->equal_islands_) {
    const IslandSchedule& schedule = each.schedule;
    const std::size_t entries = each.num_islands * static_cast<std::size_t>(schedule.num_slots);
    summary.factor.parts += each.num_islands;
    summary.factor.factor_nonzeros += entries;
    summary.factor.pattern_nonzeros += entries - each.num_islands * schedule.num_fill_slots;
    summary.factor.flops += static_cast<double>(each.num_islands) * schedule.flops();
    const Batch batch = each.batch(0);
    for (Workspace& work : result->workspaces_) {
      const auto enlarge = [](auto* list, std::size_t size) { list->resize(std::max(list->size(), size)); };
      for (auto* points : {&work.r, &work.v, &work.w, &work.dw}) enlarge(points, batch.num_points + batch.num_supports);
      for (auto* rods : {&work.u, &work.directions}) enlarge(rods, batch.num_rods);
      for (auto* rods : {&work.b, &work.x, &work.sum, &work.lengths}) enlarge(rods, batch.num_rods);
    }
  }
  summary.solvers = {LinearSolver::Batches};
  summary.reason = std::to_string(summary.factor.parts) + " islands of rods have " +
                   std::to_string(result->equal_islands_.size()) +
                   (result->equal_islands_.size() == 1 ? " structure" : " structures");
  return result;
}

// ---- in and out ----

namespace {

using namespace batches;

void bring_batch(const Batch& batch, const PointSource* source) {
  for (std::size_t lane = 0; source != nullptr && lane < num_lanes; ++lane)
    source->bring(static_cast<std::size_t>(batch.first_point[lane]), batch.num_points);
}
/// The following functions prefetch what the next batch will read or write.
[[gnu::always_inline]] inline void call_for_points(const Batch& batch, const double* array) {
  call_for_sequences(array, batch.first_point + num_lanes, 3, 3 * batch.num_points);
}
[[gnu::always_inline]] inline void call_for_blocks(const Batch& batch, const double* array) {
  if (batch.of.blocks.follow) call_for_sequences(array, batch.blocks + num_lanes, 3, 3 * batch.num_rods);
}
[[gnu::always_inline]] inline void call_for_rows(const Batch& batch, const double* array) {
  if (batch.of.rows.follow) call_for_sequences(array, batch.rows + num_lanes, 1, batch.num_rods);
}

bool are_zero(const Pack<>* rows, std::size_t count) {
  Pack<> others{};
  for (std::size_t a = 0; a < count; ++a) others += rows[a] != 0.0 ? Pack<>{} + 1.0 : Pack<>{};
  double sum = 0.0;
  for (std::size_t lane = 0; lane < num_lanes; ++lane) sum += others[lane];
  return sum == 0.0;
}

}  // namespace

// ---- batch by batch ----

/// Calls visit(batch, work) for all batches. Each thread has a workspace, which is cleared before.
template <class Visit>
void BatchSolver::for_each_batch(const Parallel& parallel, const Visit& visit) {
  for (Workspace& work : workspaces_) {
    work.smallest = Pack<>{} + 1.0;
    work.found = {};
    work.projection = {};
  }
  for (EqualIslands& islands : equal_islands_) {
    const std::size_t batches = islands.num_batches;
    const std::size_t worthwhile =
        islands.num_islands * islands.topology.rods.size() / plan::rows_of_batches_worth_a_thread;
    const std::size_t shares = std::clamp<std::size_t>(worthwhile, 1, workspaces_.size());
    parallel.for_tasks(shares, [&](std::size_t k) {
      for (std::size_t number = batches * k / shares; number < batches * (k + 1) / shares; ++number)
        visit(islands.batch(number), workspaces_[k]);
    });
  }
}

Elimination BatchSolver::found() const {
  Elimination result;
  for (const Workspace& work : workspaces_) {
    const auto& [right_side, residual, own_residual] = work.found;
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      result.reciprocal_condition = std::min(result.reciprocal_condition, work.smallest[lane]);
    result.include({1.0, right_side.read(), residual.read(), own_residual.read()});
  }
  return result;
}

Projection BatchSolver::reached() const {
  Projection result;
  for (const Workspace& work : workspaces_) {
    result.violation = larger(result.violation, work.projection.violation);
    result.iterations = std::max(result.iterations, work.projection.iterations);
  }
  return result;
}

/// Returns `number` of the lengths that move, and 0 for the others; null if no length moves.
const Pack<>* BatchSolver::moving_lengths(const Batch& batch, double MovingScalar::*number, Workspace* work) {
  if (batch.moving_lengths == nullptr) return nullptr;
  Pack<>* const result = work->lengths.data();
  for (std::size_t k = 0; k < batch.num_rods * num_lanes; ++k) {
    const MovingScalar* const length = batch.moving_lengths[k];
    result[k / num_lanes][k % num_lanes] = length != nullptr ? length->*number : 0.0;
  }
  return result;
}

Elimination BatchSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                               double*, double* lambda, double* w) {
  const bool keeps = use == FactorUse::Keep;
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    const auto& [topology, schedule] = batch.structure();
    bring_batch(batch, motion.source);
    gather_following_points({motion.r, motion.v}, batch.first_point, batch.num_points, {work.r.data(), work.v.data()});
    read_supports(batch, motion.r, work.r.data());
    read_supports(batch, motion.v, work.v.data());
    const bool is_same_for_all = motion.uniform != nullptr && batch.num_supports == 0;
    Pack3<>* const w0 = is_same_for_all ? nullptr : work.w.data();
    if (w0 != nullptr) {
      motion.uniform != nullptr ? fill(w0, batch.num_points, *motion.uniform) : read_points(batch, motion.w0, w0);
      read_supports(batch, motion.w0, w0);
    }

    Largest right_side;
    evaluate_rods(topology, work.r.data(), work.v.data(), w0, batch.offsets,
                  moving_lengths(batch, &MovingScalar::second, &work), work.u.data(), work.b.data(), &right_side);
    call_for_points(batch, motion.r);
    call_for(batch.inverse_mass + batch.num_points + batch.num_supports, batch.num_points + batch.num_supports);
    call_for_points(batch, motion.v);
    keeps ? detail::solve_negative(schedule, batch.factor, work.b.data(), work.x.data())
          : eliminate_and_solve(topology, schedule, batch.inverse_mass, work.u.data(), work.b.data(), batch.factor,
                                work.x.data(), &work.smallest);
    if (!keeps) call_for_blocks(batch, blocks);
    apply(topology, batch.inverse_mass, work.u.data(), work.b.data(), work.x.data(), right_side, w0,
          w0 == nullptr ? *motion.uniform : Vec3{}, work.dw.data(), &work.found);
    call_for_points(batch, w);
    call_for_rows(batch, lambda);
    call_for(batch.factor + schedule.num_slots, static_cast<std::size_t>(schedule.num_slots));

    write_points(batch, work.dw.data(), w);
    if (!keeps) write_blocks(batch, work.u.data(), blocks);
    write_rows(batch, work.x.data(), lambda);
  });
  return found();
}

Elimination BatchSolver::factorize(const Parallel& parallel, const double* blocks) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    const auto& [topology, schedule] = batch.structure();
    read_blocks(batch, blocks, work.u.data());
    eliminate(topology, schedule, batch.inverse_mass, work.u.data(), batch.factor, &work.smallest);
  });
  return found();
}

void BatchSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    read_rows(batch, b, work.b.data());
    detail::solve_negative(batch.structure().schedule, batch.factor, work.b.data(), work.x.data());
    write_rows(batch, work.x.data(), x);
  });
}

void BatchSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    const auto& [topology, schedule] = batch.structure();
    read_rows(batch, rows, work.b.data());
    if (are_zero(work.b.data(), batch.num_rods)) return;  // its series is in lanes, see MultiplierSeries
    read_points(batch, points, work.r.data());
    read_blocks(batch, blocks, work.u.data());
    detail::solve_negative(schedule, batch.factor, work.b.data(), work.x.data());
    move(topology, batch.inverse_mass, work.u.data(), work.x.data(), work.r.data());
    write_points(batch, work.r.data(), points);
    write_rows(batch, work.x.data(), rows);
  });
}

// ---- projections ----

Elimination BatchSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                   double* blocks) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    const auto& [topology, schedule] = batch.structure();
    bring_batch(batch, source);
    read_points(batch, r, work.r.data());
    read_supports(batch, r, work.r.data());
    evaluate_directions(topology, work.r.data(), batch.offsets, work.u.data());
    eliminate(topology, schedule, batch.inverse_mass, work.u.data(), batch.factor, &work.smallest);
    write_blocks(batch, work.u.data(), blocks);
  });
  return found();
}

/// Calls evaluate(), which finds the violation of the rows, and move() along the solution, until the violation is at
/// most `target` or no longer becomes much less.
template <class Evaluate, class Move>
void BatchSolver::iterate(const Batch& batch, double target, Workspace* work, const Evaluate& evaluate,
                          const Move& move) {
  const auto violation = [&] {
    Largest largest;
    evaluate(&largest);
    return largest.read();
  };
  const Projection found = iterate_along_chord(target, violation, [&] {
    detail::solve_negative(batch.structure().schedule, batch.factor, work->b.data(), work->x.data());
    move();
  });
  work->projection.violation = larger(work->projection.violation, found.violation);
  work->projection.iterations = std::max(work->projection.iterations, found.iterations);
}

Projection BatchSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                          const PointSource* source, double* sum) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    const auto& [topology, schedule] = batch.structure();
    bring_batch(batch, source);
    read_points(batch, r, work.r.data());
    read_supports(batch, r, work.r.data());
    read_blocks(batch, blocks, work.u.data());
    call_for_points(batch, r);
    call_for_blocks(batch, blocks);
    const auto move_along = [&, &topology = topology](const Pack<>* rows) {
      move(topology, batch.inverse_mass, work.u.data(), rows, work.r.data());
    };
    if (sum != nullptr) {
      read_rows(batch, sum, work.sum.data());
      move_along(work.sum.data());
    }
    const Pack<>* lengths = batch.lengths;
    if (const Pack<>* const moving = moving_lengths(batch, &MovingScalar::value, &work)) {
      for (std::size_t a = 0; a < batch.num_rods; ++a) {
        const Pack<> constant = batch.lengths[a];
        work.lengths.data()[a] = moving[a] == 0.0 ? constant : moving[a];
      }
      lengths = work.lengths.data();
    }
    iterate(
        batch, target, &work,
        [&, &topology = topology](Largest* largest) {
          detail::evaluate_values(topology, work.r.data(), batch.offsets, lengths, work.b.data(), largest);
        },
        [&] {
          move_along(work.x.data());
          for (std::size_t a = 0; sum != nullptr && a < batch.num_rods; ++a) work.sum.data()[a] += work.x.data()[a];
        });
    write_points(batch, work.r.data(), r);
    if (sum != nullptr) write_rows(batch, work.sum.data(), sum);
  });
  return reached();
}

Projection BatchSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                           const double* r, double* v, double* sum) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    const auto& [topology, schedule] = batch.structure();
    read_points(batch, r, work.r.data());
    read_supports(batch, r, work.r.data());
    read_points(batch, v, work.v.data());
    read_supports(batch, v, work.v.data());
    read_blocks(batch, blocks, work.u.data());
    call_for_points(batch, r);
    call_for_points(batch, v);
    call_for_blocks(batch, blocks);
    if (sum != nullptr) read_rows(batch, sum, work.sum.data());
    evaluate_directions(topology, work.r.data(), batch.offsets, work.directions.data());
    const Pack<>* const first_derivatives = moving_lengths(batch, &MovingScalar::first, &work);
    iterate(
        batch, target, &work,
        [&, &topology = topology](Largest* largest) {
          detail::evaluate_rates(topology, work.directions.data(), work.v.data(), first_derivatives, work.b.data(),
                                 largest);
        },
        [&, &topology = topology] {
          move(topology, batch.inverse_mass, work.u.data(), work.x.data(), work.v.data());
          for (std::size_t a = 0; sum != nullptr && a < batch.num_rods; ++a) work.sum.data()[a] += work.x.data()[a];
        });
    write_points(batch, work.v.data(), v);
    if (sum != nullptr) write_rows(batch, work.sum.data(), sum);
  });
  return reached();
}

void BatchSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  for_each_batch(parallel, [&](const Batch& batch, Workspace& work) {
    read_points(batch, points, work.r.data());
    read_blocks(batch, blocks, work.u.data());
    read_rows(batch, rows, work.x.data());
    move(batch.structure().topology, batch.inverse_mass, work.u.data(), work.x.data(), work.r.data());
    write_points(batch, work.r.data(), points);
  });
}

}  // namespace tanor::detail
