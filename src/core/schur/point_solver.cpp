#include "schur/point_solver.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"

namespace tanor::detail {

// ---- set-up ----

/// Lists the members of points on guides, each at its first row.
std::vector<PointSolver::Member> PointSolver::read_members(const Constraints& constraints, std::size_t num_rows) {
  std::vector<Member> result(num_rows);
  const auto read = [&]<class Kernel>(Guide guide, const Family<Kernel>& family) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      const auto number = static_cast<Index>(k);
      result[static_cast<std::size_t>(family.rows[k])] = {guide,
                                                          number,
                                                          family.kernel.points[k][0],
                                                          Kernel::num_rows,
                                                          family.first_block + number * Kernel::num_blocks,
                                                          !family.kernel.depends_on_time(),
                                                          family.kernel.geometry[k]};
    }
  };
  read(Guide::Plane, constraints.family<PlaneKernel>());
  read(Guide::Sphere, constraints.family<SphereKernel>());
  read(Guide::Line, constraints.family<LineKernel>());
  read(Guide::Circle, constraints.family<CircleKernel>());
  return result;
}

/// Appends a point with all its rows from `first_row` on; it continues the last run if it can. Returns false if a row
/// belongs to no guide.
bool PointSolver::append_point(std::span<const Member> rows, Index first_row) {
  Run run{.first = rows[0].point, .end = rows[0].point + 1, .first_row = first_row};
  for (std::size_t a = 0; a < rows.size(); a += static_cast<std::size_t>(rows[a].num_rows)) {
    if (rows[a].guide == Guide::None) return false;
    run.has_one_guide[run.num_members] = true;
    run.members[run.num_members++] = rows[a];
    run.num_rows += rows[a].num_rows;
  }
  const auto continues = [&](Run& last) {
    if (last.end != run.first || last.num_rows != run.num_rows || last.num_members != run.num_members) return false;
    const Index steps = last.end - last.first;
    for (std::size_t k = 0; k < run.num_members; ++k) {
      if (last.members[k].guide != run.members[k].guide) return false;
      const Index way = run.members[k].number - last.members[k].number;
      if (steps == 1) last.stride[k] = way;
      if (way != steps * last.stride[k]) return false;
    }
    for (std::size_t k = 0; k < run.num_members; ++k)
      last.has_one_guide[k] = last.has_one_guide[k] && last.members[k].slot == run.members[k].slot;
    ++last.end;
    return true;
  };
  if (!runs_.empty() && continues(runs_.back())) return true;
  if (!runs_.empty()) run.first_group = runs_.back().first_group + runs_.back().num_groups();
  runs_.push_back(run);
  return true;
}

std::unique_ptr<PointSolver> PointSolver::make(const SchurProblem& problem, std::vector<Index>* islands) {
  const Constraints& all = problem.constraints;
  if (all.family<PlaneKernel>().size() + all.family<SphereKernel>().size() + all.family<LineKernel>().size() +
          all.family<CircleKernel>().size() ==
      0)
    return nullptr;
  const Numbering& numbering = problem.numbering;
  const std::vector<Index> before = *islands;
  const std::vector<Member> rows = read_members(problem.constraints, numbering.num_rows());
  std::unique_ptr<PointSolver> result(new PointSolver(problem.constraints));
  result->inverse_mass_ = problem.inverse_mass;
  bool has_factors = false;
  Summary& summary = result->summary_;
  summary.solvers = {LinearSolver::ClosedForm};
  summary.reason = "nothing joins points on guides of their own";
  std::erase_if(*islands, [&](Index island) {
    const Index first = numbering.island_start[static_cast<std::size_t>(island)];
    const auto count = static_cast<std::size_t>(numbering.island_start[static_cast<std::size_t>(island) + 1] - first);
    // An island of more than one point has a row that belongs to no guide.
    const std::span members = std::span(rows).subspan(static_cast<std::size_t>(first), count);
    if (count > most_rows || !result->append_point(members, first)) return false;
    has_factors = has_factors || count > 1;
    ++summary.factor.parts;
    return true;
  });
  if (result->runs_.empty()) return nullptr;
  if (has_factors) result->factors_.resize(result->runs_.back().first_group + result->runs_.back().num_groups());
  for (const Run& run : result->runs_) {
    const auto num_rows = static_cast<std::size_t>(run.num_rows);
    summary.factor.pattern_nonzeros += static_cast<std::size_t>(run.end - run.first) * num_rows * (num_rows + 1) / 2;
  }
  summary.factor.factor_nonzeros = summary.factor.pattern_nonzeros;
  summary.factor.flops = 2.0 * static_cast<double>(summary.factor.factor_nonzeros);
  result->serve(problem, before, *islands);
  return result;
}

// ---- every step ----

/// Some groups of one run, with their numbers.
struct PointSolver::Chunk {
  static constexpr std::size_t most_groups = 8;
  static constexpr std::size_t most_points = most_groups * num_lanes;

  const Run& run;
  std::size_t first_group, count;  // first among all groups, number of groups
  std::size_t first_point, num_points;
  Index indices[most_points];  // scratch: rows, blocks, members
  Pack3<> place[most_groups], normal[most_groups];
  Pack3<> gradients[most_rows * most_groups];
  PointFactor factors[most_groups];  // used if points have one row, since nobody needs them again
  Pack<> b[most_rows * most_groups], x[most_rows * most_groups];
  Pack<> smallest = Pack<>{} + 1.0;
  Largest right_side, residual;
  double copies[4][3 * most_points];  // for a last group that is not full

  Chunk(const Run& of, std::size_t group, std::size_t num_groups)
      : run(of),
        first_group(group),
        count(num_groups),
        first_point(static_cast<std::size_t>(run.first) + (group - run.first_group) * num_lanes),
        num_points(std::min(count * num_lanes, static_cast<std::size_t>(run.end) - first_point)) {}
  int num_rows() const { return static_cast<int>(run.num_rows); }
  bool is_full() const { return num_points == count * num_lanes; }

  /// Returns the numbers of the points, `width` each. They are copied if the last group is not full; its lanes then
  /// repeat the last point.
  const double* read(const double* from, std::size_t width, double* copy) const {
    const double* const own = from + width * first_point;
    if (is_full()) return own;
    std::copy(own, own + width * num_points, copy);
    for (std::size_t k = num_points; k < count * num_lanes; ++k)
      std::copy(own + width * (num_points - 1), own + width * num_points, copy + width * k);
    return copy;
  }
  const double* read_masses(const double* inverse_mass) { return read(inverse_mass, 1, copies[3]); }
  /// Returns where kernels write results, `width` for each of the system's numbers from `first` on. `put` completes it.
  double* room(double* to, std::size_t width, std::size_t first, double* copy) const {
    return is_full() ? to + width * first : copy;
  }
  void put(const double* copy, std::size_t width, std::size_t first, double* to) const {
    if (!is_full()) std::copy(copy, copy + width * num_points, to + width * first);
  }
  /// Returns the row of the first point, for points of one row.
  std::size_t first_row() const {
    return static_cast<std::size_t>(run.first_row) + first_point - static_cast<std::size_t>(run.first);
  }

  /// Lists first + stride (place in the run) for each point.
  const Index* list(Index first, Index stride) {
    const auto last = static_cast<Index>(num_points) - 1;
    first += stride * (static_cast<Index>(first_point) - run.first);
    for (Index k = 0; k < static_cast<Index>(count * num_lanes); ++k) indices[k] = first + stride * std::min(k, last);
    return indices;
  }
  const Index* rows(std::size_t row) { return list(run.first_row + static_cast<Index>(row), run.num_rows); }
  const Index* members(std::size_t member) { return list(run.members[member].number, run.stride[member]); }
  /// Lists block m of each point's member.
  const Index* blocks(std::size_t member, Index m) {
    const Member& first = run.members[member];
    return list(first.first_block + m, run.stride[member] * first.num_rows);
  }
  void scatter_blocks(std::size_t member, Index m, const Pack3<>* from, double* to) {
    const Member& first = run.members[member];
    if (!is_full() || run.stride[member] * first.num_rows != 1)
      return scatter_points(from, blocks(member, m), count, to);
    const auto block = static_cast<std::size_t>(first.first_block + m - run.first) + first_point;
    scatter_neighbours(from, count, to + 3 * block);
  }
  void gather_rows_of(const double* from, Pack<>* to) {
    for (std::size_t m = 0; m < static_cast<std::size_t>(run.num_rows); ++m)
      gather_rows(from, rows(m), count, to + m * count);
  }
  void scatter_rows_of(const Pack<>* from, double* to) {
    for (std::size_t m = 0; m < static_cast<std::size_t>(run.num_rows); ++m)
      scatter_rows(from + m * count, rows(m), count, to);
  }
};

/// Calls work(chunk) for all chunks, many at once.
template <class Work>
Elimination PointSolver::for_each_chunk(const Parallel& parallel, const Work& work) const {
  constexpr std::size_t most_shares = plan::most_ranges_of_points;
  std::array<Elimination, most_shares> found{};
  const std::size_t num_groups = runs_.back().first_group + runs_.back().num_groups();
  const auto threads = static_cast<std::size_t>(parallel.threads());
  const std::size_t shares =
      std::clamp<std::size_t>(num_groups / plan::groups_of_points_worth_a_thread, 1, std::min(threads, most_shares));
  parallel.for_tasks(shares, [&](std::size_t k) {
    std::size_t group = num_groups * k / shares;
    const std::size_t end = num_groups * (k + 1) / shares;
    const auto is_before = [&](const Run& run) { return run.first_group + run.num_groups() <= group; };
    for (auto run = std::partition_point(runs_.begin(), runs_.end(), is_before); group < end; ++run) {
      const std::size_t last = std::min(end, run->first_group + run->num_groups());
      while (group < last) {
        Chunk chunk(*run, group, std::min(Chunk::most_groups, last - group));
        work(chunk);
        group += chunk.count;
        for (std::size_t lane = 0; lane < num_lanes; ++lane)
          found[k].reciprocal_condition = std::min(found[k].reciprocal_condition, chunk.smallest[lane]);
        found[k].include({1.0, chunk.right_side.read(), chunk.residual.read()});
      }
    }
  });
  Elimination result{.own_residual = cannot_tell};
  for (std::size_t k = 0; k < shares; ++k) result.include(found[k]);
  return result;
}

PointFactor* PointSolver::factors_of(Chunk* chunk) {
  return chunk->run.num_rows == 1 ? chunk->factors : factors_.data() + chunk->first_group;
}

/// Evaluates guides that move, one point after the other.
template <class Kernel>
void PointSolver::evaluate_moving(const Family<Kernel>& family, const FreeMotion& motion, std::size_t row,
                                  Chunk* chunk) const {
  for (std::size_t k = 0; k < chunk->count * num_lanes; ++k) {
    const auto local = family.kernel(static_cast<std::size_t>(chunk->indices[k]), motion.r, motion.v);
    for (std::size_t m = 0; m < static_cast<std::size_t>(Kernel::num_rows); ++m) {
      const std::size_t group = (row + m) * chunk->count + k / num_lanes, lane = k % num_lanes;
      chunk->b[group][lane] = local.phi[m];
      set_lane(&chunk->gradients[group], lane, local.gradient[m]);
    }
  }
}

/// The guides that one member of each point of a chunk lies on.
struct PointSolver::Guides {
  const Chunk& chunk;
  bool is_one;           // true if one serves all points
  Index one_slot;        // its slot, if it is one
  const Index* numbers;  // [point] otherwise

  /// Writes vector(slot) of each point's guide to `to` [point].
  template <class Vector>
  void gather(const std::vector<Index>& slots, Pack3<>* to, const Vector& vector) const {
    if (is_one) return fill(to, chunk.count, vector(one_slot));
    for (std::size_t k = 0; k < chunk.count * num_lanes; ++k)
      set_lane(&to[k / num_lanes], k % num_lanes, vector(slots[static_cast<std::size_t>(numbers[k])]));
  }
  /// Does the same with a single entry if one guide serves all points.
  template <class Vector>
  OfGuides gather_places(const std::vector<Index>& slots, Pack3<>* to, const Vector& vector) const {
    if (!is_one) {
      gather(slots, to, vector);
      return {to, 1};
    }
    fill(to, 1, vector(one_slot));
    return {to, 0};
  }
};

/// Evaluates gradients and phi of one member of each point, whose first row is `row`.
void PointSolver::evaluate(const FreeMotion& motion, std::size_t member, std::size_t row, Chunk* chunk) const {
  const Run& run = chunk->run;
  const auto [guide, number, point, num_rows, first_block, is_still, one_slot] = run.members[member];
  const bool is_simple = is_still && run.has_one_guide[member];
  const Guides guides{*chunk, run.has_one_guide[member], one_slot, is_simple ? nullptr : chunk->members(member)};
  switch (guide) {
    case Guide::Plane:
    case Guide::Line:
      return evaluate_straight(guide, guides, is_still, motion, row, chunk);
    case Guide::Sphere:
    case Guide::Circle:
      return evaluate_round(guide, guides, is_still, motion, row, chunk);
    case Guide::None:
      return;
  }
}

/// Evaluates planes and lines. If they stand still, the normals are the gradients, and phi = 0.
void PointSolver::evaluate_straight(Guide guide, const Guides& guides, bool is_still, const FreeMotion& motion,
                                    std::size_t row, Chunk* chunk) const {
  Pack3<>* const gradients = chunk->gradients + row * chunk->count;
  Pack<>* const phi = chunk->b + row * chunk->count;
  if (guide == Guide::Plane) {
    const auto& planes = constraints_.family<PlaneKernel>();
    if (!is_still) return evaluate_moving(planes, motion, row, chunk);
    guides.gather(planes.kernel.geometry, gradients, [&](Index slot) { return planes.kernel.normal[slot].unit.value; });
    std::fill_n(phi, chunk->count, Pack<>{});
    return;
  }
  const auto& lines = constraints_.family<LineKernel>();
  if (!is_still) return evaluate_moving(lines, motion, row, chunk);
  const auto& normals = lines.kernel.normals;
  guides.gather(lines.kernel.geometry, gradients, [&](Index slot) { return normals[slot].first.value; });
  guides.gather(lines.kernel.geometry, gradients + chunk->count,
                [&](Index slot) { return normals[slot].second.value; });
  std::fill_n(phi, 2 * chunk->count, Pack<>{});
}

/// Evaluates spheres and circles. If they stand still, their kernels run in lanes.
void PointSolver::evaluate_round(Guide guide, const Guides& guides, bool is_still, const FreeMotion& motion,
                                 std::size_t row, Chunk* chunk) const {
  Pack3<>* const gradients = chunk->gradients + row * chunk->count;
  Pack<>* const phi = chunk->b + row * chunk->count;
  const double* const r = chunk->read(motion.r, 3, chunk->copies[0]);
  const double* const v = chunk->read(motion.v, 3, chunk->copies[1]);
  if (guide == Guide::Sphere) {
    const auto& spheres = constraints_.family<SphereKernel>();
    if (!is_still) return evaluate_moving(spheres, motion, row, chunk);
    const OfGuides centers = guides.gather_places(spheres.kernel.geometry, chunk->place,
                                                  [&](Index slot) { return spheres.kernel.center[slot].value; });
    return evaluate_spheres(chunk->count, r, v, centers, gradients, phi);
  }
  const auto& circles = constraints_.family<CircleKernel>();
  if (!is_still) return evaluate_moving(circles, motion, row, chunk);
  const OfGuides centers = guides.gather_places(circles.kernel.geometry, chunk->place,
                                                [&](Index slot) { return circles.kernel.center[slot].value; });
  const OfGuides normals = guides.gather_places(circles.kernel.geometry, chunk->normal,
                                                [&](Index slot) { return circles.kernel.normal[slot].value; });
  evaluate_circles(chunk->count, r, v, centers, normals, gradients, phi);
}

Elimination PointSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse, double* blocks, double*,
                               double* lambda, double* w) {
  bring_points(parallel, motion.source);
  return for_each_chunk(parallel, [&](Chunk& chunk) {
    const std::size_t count = chunk.count;
    std::size_t row = 0;
    for (std::size_t k = 0; k < chunk.run.num_members; ++k) {
      evaluate(motion, k, row, &chunk);
      for (Index m = 0; m < chunk.run.members[k].num_rows; ++m, ++row)
        chunk.scatter_blocks(k, m, chunk.gradients + row * count, blocks);
    }
    double* const w_copy = chunk.copies[2];
    const double* const w0 = motion.uniform == nullptr ? chunk.read(motion.w0, 3, w_copy) : nullptr;
    const double* const inverse_mass = chunk.read_masses(inverse_mass_.data());
    double* const w_of_chunk = chunk.room(w, 3, chunk.first_point, w_copy);
    if (chunk.run.num_rows == 1) {
      double* const lambda_copy = chunk.copies[0];
      solve_single_rows(count, chunk.gradients, chunk.b, inverse_mass, w0, motion.uniform,
                        chunk.room(lambda, 1, chunk.first_row(), lambda_copy), w_of_chunk, &chunk.right_side,
                        &chunk.residual);
      chunk.put(lambda_copy, 1, chunk.first_row(), lambda);
    } else {
      PointFactor* const factors = factors_of(&chunk);
      add_free(chunk.num_rows(), count, chunk.gradients, w0, motion.uniform, chunk.b, &chunk.right_side);
      factorize_points(chunk.num_rows(), count, chunk.gradients, factors, &chunk.smallest);
      solve_points(chunk.num_rows(), count, factors, chunk.b, chunk.x);
      detail::add_reactions(chunk.num_rows(), count, chunk.gradients, chunk.b, chunk.x, w0, motion.uniform, w_of_chunk,
                            &chunk.residual);
      scale_by_mass(chunk.num_rows(), count, inverse_mass, chunk.x);
      chunk.scatter_rows_of(chunk.x, lambda);
    }
    chunk.put(w_copy, 3, chunk.first_point, w);
  });
}

Elimination PointSolver::factorize(const Parallel& parallel, const double* blocks) {
  if (factors_.empty()) return {};
  return for_each_chunk(parallel, [&](Chunk& chunk) {
    std::size_t row = 0;
    for (std::size_t k = 0; k < chunk.run.num_members; ++k) {
      for (Index m = 0; m < chunk.run.members[k].num_rows; ++m, ++row)
        gather_blocks(blocks, chunk.blocks(k, m), chunk.count, chunk.gradients + row * chunk.count);
    }
    factorize_points(chunk.num_rows(), chunk.count, chunk.gradients, factors_of(&chunk), &chunk.smallest);
  });
}

void PointSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)for_each_chunk(parallel, [&](Chunk& chunk) {
    chunk.gather_rows_of(b, chunk.b);
    PointFactor* const factors = factors_of(&chunk);
    for (std::size_t k = 0; k < chunk.count && chunk.run.num_rows == 1; ++k) factors[k].inverse_d0 = Pack<>{} + 1.0;
    solve_points(chunk.num_rows(), chunk.count, factors, chunk.b, chunk.x);
    scale_by_mass(chunk.num_rows(), chunk.count, chunk.read_masses(inverse_mass_.data()), chunk.x);
    chunk.scatter_rows_of(chunk.x, x);
  });
}

}  // namespace tanor::detail
