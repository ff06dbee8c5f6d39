#include "schur/point_solver.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"
#include "schur/lane_transfers.hpp"

namespace tanor::detail {

namespace {

/// Calls visit(family) for each kind of guide.
template <class Visit>
void for_each_guide(const Constraints& constraints, const Visit& visit) {
  visit(constraints.family<PlaneKernel>());
  visit(constraints.family<SphereKernel>());
  visit(constraints.family<LineKernel>());
  visit(constraints.family<CircleKernel>());
}

}  // namespace

// ---- set-up ----

/// Takes the points that nothing joins, and makes chunks of them.
void PointSolver::take(const Numbering& numbering, std::vector<Index>* islands) {
  struct Row {
    Index point = -1, kind, guide;
  };
  std::vector<Row> rows(numbering.num_rows());
  for_each_guide(constraints_, [&]<class Kernel>(const Family<Kernel>& family) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      for (Index m = 0; m < Kernel::num_rows; ++m) {
        const auto row = static_cast<std::size_t>(family.rows[k] + m);
        rows[row] = {family.kernel.points[k][0], family.first_block, family.kernel.geometry[k]};
        block_[row] = family.first_block + static_cast<Index>(k) * Kernel::num_blocks + m;
      }
    }
  });
  std::erase_if(*islands, [&](Index island) {
    const Index* const start = numbering.island_start.data() + island;
    const auto first = static_cast<std::size_t>(start[0]), count = static_cast<std::size_t>(start[1]) - first;
    const std::span<const Row> own = std::span(rows).subspan(first, count);
    // An island of more than one point has a row that belongs to no guide.
    if (count > most_rows || std::ranges::any_of(own, [](const Row& row) { return row.point < 0; })) return false;
    const auto point = static_cast<std::size_t>(own[0].point);
    const auto continues = [&](const Chunk& last) {
      return last.num_points < most_points && last.num_rows == count && last.first_point + last.num_points == point &&
             last.first_row + last.num_points * count == first &&
             std::ranges::equal(own, std::span(rows).subspan(last.first_row, count), {}, &Row::kind, &Row::kind);
    };
    if (chunks_.empty() || !continues(chunks_.back())) chunks_.push_back({point, first, count});
    Chunk& chunk = chunks_.back();
    for (std::size_t m = 0; m < count; ++m) {
      const std::size_t front = chunk.first_row + m, block = static_cast<std::size_t>(block_[front]);
      chunk.has_one_guide[m] = chunk.has_one_guide[m] && own[m].guide == rows[front].guide;
      chunk.are_neighbours[m] =
          chunk.are_neighbours[m] && static_cast<std::size_t>(block_[first + m]) == block + chunk.num_points;
    }
    ++chunk.num_points;
    return true;
  });
}

std::unique_ptr<PointSolver> PointSolver::make(const SchurProblem& problem, std::vector<Index>* islands) {
  bool has_guides = false;
  for_each_guide(problem.constraints, [&](const auto& family) { has_guides = has_guides || family.size() > 0; });
  if (!has_guides) return nullptr;
  const std::vector<Index> before = *islands;
  std::unique_ptr<PointSolver> result(new PointSolver(problem));
  result->take(problem.numbering, islands);
  if (result->chunks_.empty()) return nullptr;
  FactorSummary factor{.parts = before.size() - islands->size()};
  std::size_t num_factors = 0;
  for (Chunk& chunk : result->chunks_) {
    chunk.first_factor = num_factors;
    if (chunk.num_rows > 1) num_factors += chunk.num_groups();
    factor.pattern_nonzeros += chunk.num_points * chunk.num_rows * (chunk.num_rows + 1) / 2;
  }
  result->factors_.resize(num_factors);
  factor.factor_nonzeros = factor.pattern_nonzeros;
  factor.flops = 2.0 * static_cast<double>(factor.factor_nonzeros);
  result->summary_ = {
      .solvers = {LinearSolver::ClosedForm}, .reason = "nothing joins points on guides of their own", .factor = factor};
  result->serve(problem, before, *islands);
  return result;
}

// ---- every step ----

/// A chunk in lanes. Lanes behind the last point repeat it.
class PointSolver::Work {
 public:
  const Chunk* chunk = nullptr;
  PointFactor* factors = nullptr;
  Pack3<> gradients[most_rows * most_groups];
  Pack<> b[most_rows * most_groups], lambda[most_rows * most_groups];
  lanes::Findings found;

  explicit Work(const PointSolver& solver) : solver_(solver) {}

  PointGroups masses() { return {chunk->num_groups(), read(solver_.inverse_mass_.data(), 1, copies_[3])}; }
  /// Returns the points; `write_accelerations` completes w.
  PointGroups read_points(const FreeMotion& motion, double* w) {
    PointGroups result = masses();
    result.r = read(motion.r, 3, copies_[0]);
    result.v = read(motion.v, 3, copies_[1]);
    result.uniform = motion.uniform;
    if (motion.uniform == nullptr) result.w0 = read(motion.w0, 3, copies_[2]);
    result.w = chunk->is_full() ? w + 3 * chunk->first_point : copies_[2];
    return result;
  }
  void write_accelerations(double* w) const {
    if (!chunk->is_full()) std::copy_n(copies_[2], 3 * chunk->num_points, w + 3 * chunk->first_point);
  }
  void read_rows(const double* from) {
    for_each_lane(0, chunk->num_rows,
                  [&](std::size_t row, std::size_t k, std::size_t lane) { b[k][lane] = from[row]; });
  }
  void write_rows(double* to) const {
    if (chunk->num_rows == 1)
      return void(std::copy_n(reinterpret_cast<const double*>(lambda), chunk->num_points, to + chunk->first_row));
    for_each_lane(0, chunk->num_rows,
                  [&](std::size_t row, std::size_t k, std::size_t lane) { to[row] = lambda[k][lane]; });
  }
  void read_blocks(const double* from) {
    for_each_lane(0, chunk->num_rows, [&](std::size_t row, std::size_t k, std::size_t lane) {
      set_lane(&gradients[k], lane, load(from, solver_.block_[row]));
    });
  }
  void write_blocks(double* to) const {
    const Pack3<>* own = gradients;
    for (std::size_t m = 0; m < chunk->num_rows; ++m, own += chunk->num_groups()) {
      if (chunk->is_full() && chunk->are_neighbours[m]) {
        scatter_neighbours(own, chunk->num_groups(), to + 3 * solver_.block_[chunk->first_row + m]);
        continue;
      }
      for_each_lane(m, 1, [&](std::size_t row, std::size_t k, std::size_t lane) {
        store(to, solver_.block_[row], lane_of(own[k], lane));
      });
    }
  }
  /// Evaluates gradients and phi.
  void evaluate(const FreeMotion& motion, const PointGroups& points) {
    for (std::size_t m = 0; m < chunk->num_rows;) {
      const Index block = solver_.block_[chunk->first_row + m];
      for_each_guide(solver_.constraints_, [&]<class Kernel>(const Family<Kernel>& family) {
        const Index begin = family.first_block;
        if (block < begin || block >= begin + Kernel::num_blocks * static_cast<Index>(family.size())) return;
        evaluate(family, motion, points, m);
        m += Kernel::num_rows;
      });
    }
  }

 private:
  /// Returns consecutive numbers of the points, `width` each.
  const double* read(const double* from, std::size_t width, double* copy) const {
    const double* const own = from + width * chunk->first_point;
    if (chunk->is_full()) return own;
    const std::size_t count = chunk->num_points;
    std::copy_n(own, width * count, copy);
    for (std::size_t k = count; k < chunk->num_groups() * num_lanes; ++k)
      std::copy_n(own + width * (count - 1), width, copy + width * k);
    return copy;
  }
  /// Calls visit(row, group, lane) for the rows [first, first + count) of each point; groups are counted on from row to
  /// row.
  template <class Visit>
  void for_each_lane(std::size_t first, std::size_t count, const Visit& visit) const {
    for (std::size_t m = 0; m < count; ++m) {
      for (std::size_t k = 0; k < chunk->num_groups() * num_lanes; ++k) {
        const std::size_t point = std::min(k, chunk->num_points - 1);
        visit(chunk->first_row + first + m + point * chunk->num_rows, m * chunk->num_groups() + k / num_lanes,
              k % num_lanes);
      }
    }
  }
  /// Evaluates one kind of guide, from row m of each point on. Spheres and circles that stand still run in lanes; the
  /// gradients of other guides that do are constant.
  template <class Kernel>
  void evaluate(const Family<Kernel>& family, const FreeMotion& motion, const PointGroups& points, std::size_t m) {
    const Kernel& kernel = family.kernel;
    Pack3<>* const own = gradients + m * points.count;
    Pack<>* const phi = b + m * points.count;
    const auto number_at = [&](std::size_t row) {
      return static_cast<std::size_t>(solver_.block_[row] - family.first_block) / Kernel::num_blocks;
    };
    // Writes vector(number) of each point's member, or only the first `count` groups if one guide serves all.
    const auto gather = [&](Pack3<>* to, std::size_t count, const auto& vector) -> OfGuides {
      if (chunk->has_one_guide[m]) {
        fill(to, count, vector(number_at(chunk->first_row + m)));
        return {to, 0};
      }
      for_each_lane(m, 1, [&](std::size_t row, std::size_t k, std::size_t lane) {
        set_lane(&to[k], lane, vector(number_at(row)));
      });
      return {to, 1};
    };
    const auto gather_table = [&](const auto& table, Pack3<>* to) {
      return gather(to, 1, [&](std::size_t number) { return table[kernel.geometry[number]].value; });
    };
    if (kernel.depends_on_time()) {
      for_each_lane(m, 1, [&](std::size_t row, std::size_t k, std::size_t lane) {
        const auto local = kernel(number_at(row), motion.r, motion.v);
        for (std::size_t a = 0; a < Kernel::num_rows; ++a) {
          phi[k + a * points.count][lane] = local.phi[a];
          set_lane(&own[k + a * points.count], lane, local.gradient[a]);
        }
      });
    } else if constexpr (std::is_same_v<Kernel, SphereKernel>) {
      evaluate_spheres(points, gather_table(kernel.center, places_[0]), own, phi);
    } else if constexpr (std::is_same_v<Kernel, CircleKernel>) {
      evaluate_circles(points, gather_table(kernel.center, places_[0]), gather_table(kernel.normal, places_[1]), own,
                       phi);
    } else {
      for (std::size_t a = 0; a < Kernel::num_rows; ++a)
        gather(own + a * points.count, points.count,
               [&](std::size_t number) { return kernel(number, motion.r, motion.v).gradient[a]; });
      std::fill_n(phi, Kernel::num_rows * points.count, Pack<>{});
    }
  }

  const PointSolver& solver_;
  Pack3<> places_[2][most_groups];
  double copies_[4][3 * most_points];  // for a last group that is not full
};

/// Calls visit(work) for all chunks, many at once.
template <class Visit>
Elimination PointSolver::for_each_chunk(const Parallel& parallel, const Visit& visit) {
  const auto visit_range = [&](std::size_t begin, std::size_t end) {
    Work work(*this);
    for (std::size_t k = begin; k < end; ++k) {
      work.chunk = &chunks_[k];
      work.factors = factors_.data() + chunks_[k].first_factor;
      visit(&work);
    }
    return work.found.read();
  };
  const auto join = [](Elimination a, const Elimination& b) {
    a.include(b);
    return a;
  };
  return parallel.join_over_ranges(chunks_.size(), Elimination{.own_residual = cannot_tell}, visit_range, join,
                                   plan::rows_of_lanes_worth_a_thread / most_points);
}

Elimination PointSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse, double* blocks, double*,
                               double* lambda, double* w) {
  bring_points(parallel, motion.source);
  return for_each_chunk(parallel, [&](Work* work) {
    const PointGroups points = work->read_points(motion, w);
    work->evaluate(motion, points);
    work->write_blocks(blocks);
    solve_points(work->chunk->num_rows, points, work->gradients, work->b, work->factors, work->lambda, &work->found);
    work->write_rows(lambda);
    work->write_accelerations(w);
  });
}

Elimination PointSolver::factorize(const Parallel& parallel, const double* blocks) {
  if (factors_.empty()) return {};
  return for_each_chunk(parallel, [&](Work* work) {
    work->read_blocks(blocks);
    solve_points(work->chunk->num_rows, work->masses(), work->gradients, nullptr, work->factors, nullptr, &work->found);
  });
}

void PointSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)for_each_chunk(parallel, [&](Work* work) {
    work->read_rows(b);
    substitute_points(work->chunk->num_rows, work->masses(), work->factors, work->b, work->lambda);
    work->write_rows(x);
  });
}

}  // namespace tanor::detail
