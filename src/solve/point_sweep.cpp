#include "solve/point_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor {

// ---- set-up ----

/// [first row of each]
std::vector<PointSweep::Member> PointSweep::read_members(const Constraints& constraints, std::size_t num_rows) {
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

/// One more point, with all its rows from `first_row` on; it continues the last run if it can.
bool PointSweep::append_point(std::span<const Member> rows, Index first_row) {
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

std::unique_ptr<PointSweep> PointSweep::make(const Constraints& constraints, const Numbering& numbering,
                                             std::span<const double> inverse_mass, std::vector<Index>* islands) {
  const std::vector<Member> rows = read_members(constraints, numbering.num_rows());
  std::unique_ptr<PointSweep> result(new PointSweep(constraints));
  result->inverse_mass_ = inverse_mass;
  bool has_factors = false;
  Summary& summary = result->summary_;
  summary = {.name = "closed form", .reason = "nothing joins points on guides of their own"};
  std::erase_if(*islands, [&](Index island) {
    const Index first = numbering.island_start[static_cast<std::size_t>(island)];
    const auto count = static_cast<std::size_t>(numbering.island_start[static_cast<std::size_t>(island) + 1] - first);
    // An island of more than one point has a row that is none of ours.
    const std::span members = std::span(rows).subspan(static_cast<std::size_t>(first), count);
    if (count > most_rows || !result->append_point(members, first)) return false;
    has_factors = has_factors || count > 1;
    ++summary.parts;
    return true;
  });
  if (result->runs_.empty()) return nullptr;
  if (has_factors) result->factors_.resize(result->runs_.back().first_group + result->runs_.back().num_groups());
  for (const Run& run : result->runs_) {
    const auto num_rows = static_cast<std::size_t>(run.num_rows);
    summary.pattern_nonzeros += static_cast<std::size_t>(run.end - run.first) * num_rows * (num_rows + 1) / 2;
  }
  summary.factor_nonzeros = summary.pattern_nonzeros;
  summary.flops = 2.0 * static_cast<double>(summary.factor_nonzeros);
  return result;
}

// ---- every step ----

/// Some groups of one run, on their way.
struct PointSweep::Chunk {
  static constexpr std::size_t most_groups = 8;
  static constexpr std::size_t most_points = most_groups * num_lanes;

  const Run& run;
  std::size_t first_group, count;  // in all, groups
  Index points[most_points];       // the last one repeated
  Index indices[most_points];      // scratch: rows, blocks, members
  Eight3 r[most_groups], v[most_groups], w[most_groups], place[most_groups], normal[most_groups];
  Eight3 gradients[most_rows * most_groups];
  PointFactor factors[most_groups];  // where points have one row: nobody needs them again
  Eight b[most_rows * most_groups], x[most_rows * most_groups], inverse_mass[most_groups];
  Eight smallest = Eight{} + 1.0;
  Largest right_side, residual;

  Chunk(const Run& of, std::size_t group, std::size_t num_groups) : run(of), first_group(group), count(num_groups) {
    const auto begin = run.first + static_cast<Index>((group - run.first_group) * num_lanes);
    for (std::size_t k = 0; k < num_points(); ++k) points[k] = std::min(begin + static_cast<Index>(k), run.end - 1);
  }
  std::size_t num_points() const { return count * num_lanes; }
  int num_rows() const { return static_cast<int>(run.num_rows); }

  /// first + stride (place in the run), of each point
  const Index* list(Index first, Index stride) {
    for (std::size_t k = 0; k < num_points(); ++k) indices[k] = first + stride * (points[k] - run.first);
    return indices;
  }
  const Index* rows(std::size_t row) { return list(run.first_row + static_cast<Index>(row), run.num_rows); }
  const Index* members(std::size_t member) { return list(run.members[member].number, run.stride[member]); }
  /// Block m of each point's member
  const Index* blocks(std::size_t member, Index m) {
    const Member& first = run.members[member];
    return list(first.first_block + m, run.stride[member] * first.num_rows);
  }
  /// No lane repeats a point.
  bool is_full() const { return points[num_points() - 1] - points[0] == static_cast<Index>(num_points()) - 1; }
  void gather(const double* from, Eight3* to) const {
    if (!is_full()) return gather_points(from, points, count, to);
    gather_neighbours(from + 3 * static_cast<std::size_t>(points[0]), count, to);
  }
  void scatter(const Eight3* from, double* to) const {
    if (!is_full()) return scatter_points(from, points, count, to);
    scatter_neighbours(from, count, to + 3 * static_cast<std::size_t>(points[0]));
  }
  /// Block m of each point's member
  void scatter_blocks(std::size_t member, Index m, const Eight3* from, double* to) {
    const Index* const list = blocks(member, m);
    const bool follow_points = list[num_points() - 1] - list[0] == static_cast<Index>(num_points()) - 1;
    if (!is_full() || !follow_points) return scatter_points(from, list, count, to);
    scatter_neighbours(from, count, to + 3 * static_cast<std::size_t>(list[0]));
  }
  void gather_masses(const double* from) {
    if (!is_full()) return gather_rows(from, points, count, inverse_mass);
    std::copy(from + points[0], from + points[0] + num_points(), reinterpret_cast<double*>(inverse_mass));
  }
  void gather_rows_of(const double* from, Eight* to) {
    for (std::size_t m = 0; m < static_cast<std::size_t>(run.num_rows); ++m)
      gather_rows(from, rows(m), count, to + m * count);
  }
  void scatter_rows_of(const Eight* from, double* to) {
    if (run.num_rows == 1 && is_full()) {
      const auto* const numbers = reinterpret_cast<const double*>(from);
      std::copy(numbers, numbers + num_points(), to + *rows(0));
      return;
    }
    for (std::size_t m = 0; m < static_cast<std::size_t>(run.num_rows); ++m)
      scatter_rows(from + m * count, rows(m), count, to);
  }
};

/// work(chunk), many at once.
template <class Work>
Elimination PointSweep::for_each_chunk(const Parallel& parallel, const Work& work) const {
  constexpr std::size_t most_shares = 64, least_groups = 256;  // fewer are not worth a thread
  std::array<Elimination, most_shares> found{};
  const std::size_t num_groups = runs_.back().first_group + runs_.back().num_groups();
  const auto threads = static_cast<std::size_t>(parallel.threads());
  const std::size_t shares = std::clamp<std::size_t>(num_groups / least_groups, 1, std::min(threads, most_shares));
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
        found[k].largest_right_side = larger(found[k].largest_right_side, chunk.right_side.read());
        found[k].residual = larger(found[k].residual, chunk.residual.read());
      }
    }
  });
  Elimination result;
  for (std::size_t k = 0; k < shares; ++k) {
    result.reciprocal_condition = std::min(result.reciprocal_condition, found[k].reciprocal_condition);
    result.largest_right_side = larger(result.largest_right_side, found[k].largest_right_side);
    result.residual = larger(result.residual, found[k].residual);
  }
  return result;
}

PointFactor* PointSweep::factors_of(Chunk* chunk) {
  return chunk->run.num_rows == 1 ? chunk->factors : factors_.data() + chunk->first_group;
}

/// One point after the other.
template <class Kernel>
void PointSweep::evaluate_moving(const Family<Kernel>& family, const FreeMotion& motion, std::size_t row,
                                 Chunk* chunk) const {
  for (std::size_t k = 0; k < chunk->num_points(); ++k) {
    const auto local = family.kernel(static_cast<std::size_t>(chunk->indices[k]), motion.r, motion.v);
    for (std::size_t m = 0; m < static_cast<std::size_t>(Kernel::num_rows); ++m) {
      const std::size_t group = (row + m) * chunk->count + k / num_lanes, lane = k % num_lanes;
      chunk->b[group][lane] = local.phi[m];
      set_lane(&chunk->gradients[group], lane, local.gradient[m]);
    }
  }
}

/// Gradients and phi of one member of each point, whose first row is `row`.
void PointSweep::evaluate(const FreeMotion& motion, std::size_t member, std::size_t row, Chunk* chunk) const {
  const Run& run = chunk->run;
  const bool is_simple = run.members[member].is_still && run.has_one_guide[member];
  const Index* const numbers = is_simple ? nullptr : chunk->members(member);
  const auto [guide, number, point, num_rows, first_block, is_still, one_slot] = run.members[member];
  Eight3* const gradients = chunk->gradients + row * chunk->count;
  Eight* const phi = chunk->b + row * chunk->count;
  /// vector(slot) of each point's guide
  const auto gather = [&](const std::vector<Index>& slots, Eight3* to, const auto& vector) {
    if (run.has_one_guide[member]) return fill(to, chunk->count, vector(one_slot));
    for (std::size_t k = 0; k < chunk->num_points(); ++k)
      set_lane(&to[k / num_lanes], k % num_lanes, vector(slots[static_cast<std::size_t>(numbers[k])]));
  };
  const auto straight = [&] { std::fill_n(phi, static_cast<std::size_t>(num_rows) * chunk->count, Eight{}); };
  switch (guide) {
    case Guide::Plane: {
      const auto& planes = constraints_.family<PlaneKernel>();
      if (!is_still) return evaluate_moving(planes, motion, row, chunk);
      gather(planes.kernel.geometry, gradients, [&](Index slot) { return planes.kernel.normal[slot].unit.value; });
      return straight();
    }
    case Guide::Line: {
      const auto& lines = constraints_.family<LineKernel>();
      if (!is_still) return evaluate_moving(lines, motion, row, chunk);
      const auto& normals = lines.kernel.normals;
      gather(lines.kernel.geometry, gradients, [&](Index slot) { return normals[slot].first.value; });
      gather(lines.kernel.geometry, gradients + chunk->count, [&](Index slot) { return normals[slot].second.value; });
      return straight();
    }
    case Guide::Sphere: {
      const auto& spheres = constraints_.family<SphereKernel>();
      if (!is_still) return evaluate_moving(spheres, motion, row, chunk);
      gather(spheres.kernel.geometry, chunk->place, [&](Index slot) { return spheres.kernel.center[slot].value; });
      return evaluate_spheres(chunk->count, chunk->r, chunk->v, chunk->place, gradients, phi);
    }
    case Guide::Circle: {
      const auto& circles = constraints_.family<CircleKernel>();
      if (!is_still) return evaluate_moving(circles, motion, row, chunk);
      gather(circles.kernel.geometry, chunk->place, [&](Index slot) { return circles.kernel.center[slot].value; });
      gather(circles.kernel.geometry, chunk->normal, [&](Index slot) { return circles.kernel.normal[slot].value; });
      return evaluate_circles(chunk->count, chunk->r, chunk->v, chunk->place, chunk->normal, gradients, phi);
    }
    case Guide::None:
      return;
  }
}

Elimination PointSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double*,
                              double* lambda, double* w) {
  return for_each_chunk(parallel, [&](Chunk& chunk) {
    const std::size_t count = chunk.count;
    chunk.gather(motion.r, chunk.r);
    chunk.gather(motion.v, chunk.v);
    chunk.gather_masses(inverse_mass_.data());
    if (motion.uniform != nullptr) {
      fill(chunk.w, count, *motion.uniform);
    } else {
      chunk.gather(motion.w0, chunk.w);
    }
    std::size_t row = 0;
    for (std::size_t k = 0; k < chunk.run.num_members; ++k) {
      evaluate(motion, k, row, &chunk);
      for (Index m = 0; m < chunk.run.members[k].num_rows; ++m, ++row)
        chunk.scatter_blocks(k, m, chunk.gradients + row * count, blocks);
    }
    if (chunk.run.num_rows == 1) {
      solve_single_rows(count, chunk.gradients, chunk.b, chunk.inverse_mass, chunk.x, chunk.w, &chunk.right_side,
                        &chunk.residual);
    } else {
      PointFactor* const factors = factors_of(&chunk);
      add_free(chunk.num_rows(), count, chunk.gradients, chunk.w, chunk.b, &chunk.right_side);
      factorize_points(chunk.num_rows(), count, chunk.gradients, factors, &chunk.smallest);
      solve_points(chunk.num_rows(), count, factors, chunk.b, chunk.x);
      tanor::add_reactions(chunk.num_rows(), count, chunk.gradients, chunk.b, chunk.x, chunk.w, &chunk.residual);
      scale_by_mass(chunk.num_rows(), count, chunk.inverse_mass, chunk.x);
    }
    chunk.scatter(chunk.w, w);
    chunk.scatter_rows_of(chunk.x, lambda);
  });
}

Elimination PointSweep::factorize(const Parallel& parallel, const double* blocks) {
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

void PointSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)for_each_chunk(parallel, [&](Chunk& chunk) {
    chunk.gather_rows_of(b, chunk.b);
    chunk.gather_masses(inverse_mass_.data());
    PointFactor* const factors = factors_of(&chunk);
    for (std::size_t k = 0; k < chunk.count && chunk.run.num_rows == 1; ++k) factors[k].inverse_d0 = Eight{} + 1.0;
    solve_points(chunk.num_rows(), chunk.count, factors, chunk.b, chunk.x);
    scale_by_mass(chunk.num_rows(), chunk.count, chunk.inverse_mass, chunk.x);
    chunk.scatter_rows_of(chunk.x, x);
  });
}

}  // namespace tanor
