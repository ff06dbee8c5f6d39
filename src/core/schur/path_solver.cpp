#include "schur/path_solver.hpp"

#include <algorithm>
#include <cmath>

#include "plan/thresholds.hpp"

namespace tanor::detail {

using paths::Motion;

std::unique_ptr<PathSolver> PathSolver::make(const SchurProblem& problem, int threads, std::vector<Index>* islands) {
  if (islands->empty()) return nullptr;
  const std::vector<Index> before = *islands;
  PathRows rows(problem, islands);
  if (rows.paths.empty()) return nullptr;
  std::unique_ptr<PathSolver> result(new PathSolver(std::move(rows), threads));
  result->serve(problem, before, *islands);
  return result;
}

PathSolver::PathSolver(PathRows rows, int threads)
    : rows_(std::move(rows)),
      factor_(rows_),
      found_(rows_.paths.size()),
      workspaces_(static_cast<std::size_t>(Parallel(threads).threads()), PathWorkspace(rows_.most_rods)) {
  summarize();
}

void PathSolver::summarize() {
  constexpr double flops_a_row = 5.0, flops_a_spike = 4.0;
  const auto count = [](std::size_t number, const std::string& what) {
    return number == 1 ? "one " + what + " of rods" : std::to_string(number) + " " + what + "s of rods";
  };
  const std::size_t num_rings = rows_.num_rings, num_open = rows_.paths.size() - num_rings;
  summary_ = {.solvers = {LinearSolver::Paths},
              .reason = (num_open > 0 ? count(num_open, "path") : "") + (num_open * num_rings > 0 ? ", " : "") +
                        (num_rings > 0 ? count(num_rings, "ring") : ""),
              .factor = {.parts = rows_.paths.size()}};
  for (const PathRows::Cut& cut : rows_.paths) {
    const std::size_t rows = cut.path.num_rows(), couplings = cut.path.is_ring ? rows : rows - 1;
    summary_.factor.pattern_nonzeros += rows + couplings;
    summary_.factor.factor_nonzeros += 2 * rows - 1 + (cut.path.is_ring ? cut.end_separator - cut.first_separator : 0);
    summary_.factor.flops += (flops_a_row + flops_a_spike) * static_cast<double>(rows);
  }
}

// ---- a path ----

/// One path, and the threads that work on it: all of them, or one with a workspace of its own.
class PathSolver::Visit {
 public:
  Visit(PathSolver* all, std::size_t number, const Parallel& parallel, std::size_t workspace)
      : rows_(all->rows_),
        factor_(all->factor_),
        cut_(rows_.paths[number]),
        found(all->found_[number]),
        parallel_(parallel),
        workspaces_(std::span(all->workspaces_).subspan(workspace)) {}

  bool is_ring() const { return cut_.path.is_ring; }
  std::span<Separator> separators() const { return factor_.of(cut_); }

  /// Calls work(block) for all pieces. Returns what was found there.
  template <class Work>
  paths::Found for_pieces(const Work& work) const {
    const std::size_t count = cut_.end_pieces - cut_.first_pieces;
    const std::size_t shares =
        std::clamp<std::size_t>(static_cast<std::size_t>(parallel_.threads()), 1, workspaces_.size());
    parallel_.for_tasks(shares, [&](std::size_t share) {
      PathWorkspace& own = workspaces_[share];
      own.found = {};
      for (std::size_t k = count * share / shares; k < count * (share + 1) / shares; ++k) {
        PathBlock block(rows_, &factor_, cut_, rows_.pieces[cut_.first_pieces + k], &own);
        work(block);
      }
    });
    paths::Found result = workspaces_[0].found;
    for (std::size_t share = 1; share < shares; ++share) result.include(workspaces_[share].found);
    return result;
  }

  // ---- points that come from elsewhere ----

  /// Brings all points if threads share the path; else each block brings its own, and the rods alone have the others.
  void begin_bringing(const PointSource* source) const {
    workspaces_[0].next_point = cut_.path.first_point();
    if (parallel_.threads() > 1) bring_up_to(cut_.path.end_point(), source);
  }
  void bring_for(const PathBlock& block, const PointSource* source) const {
    if (parallel_.threads() == 1) bring_up_to(block.last_point() + 1, source);
  }
  void end_bringing(const PointSource* source) const { bring_up_to(cut_.path.end_point(), source); }

  // ---- rods alone ----

  /// Calls work(row, separator) for each.
  template <class Work>
  void for_alone(const Work& work) const {
    for (std::size_t k = cut_.first_alone; k < cut_.end_alone; ++k)
      work(rows_.alone[k].row, factor_.separators[rows_.alone[k].separator]);
  }
  /// Does the same for all separators.
  template <class Work>
  void for_separators(const Work& work) const {
    for (std::size_t k = cut_.first_pieces; k < cut_.end_pieces; ++k) {
      const PathPieces& of = rows_.pieces[k];
      for (std::size_t lane = 0; lane < num_lanes; ++lane)
        work(of.first_row + (lane + 1) * of.length - 1, factor_.separators[of.first_separator + lane]);
    }
    for_alone(work);
  }
  static void set_right_side(double b, Separator* own) {
    own->b = b;
    own->y = -b;
    own->taken_y = 0.0;
  }
  void set_direction(std::size_t row, Vec3 u, Separator* own) const {
    own->first = own->u = u;
    own->inverse_mass_before = rows_.inverse_mass[cut_.path.left_point(row)];
    own->pivot = own->diagonal =
        dot(u, u) * (own->inverse_mass_before + rows_.inverse_mass[cut_.path.right_point(row)]);
    own->spread = 1.0;
    own->taken = 0.0;
  }
  Vec3 distance(std::size_t row, const double* r) const { return rows_.distance(cut_.path, row, r); }
  /// Returns the difference of v, or w0, over a rod.
  Vec3 difference(std::size_t row, const double* points) const {
    return load(points, cut_.path.right_point(row)) - load(points, cut_.path.left_point(row));
  }
  /// Evaluates b = phi + K'w0, and u if `renews` is true. Returns b.
  double evaluate(std::size_t row, const FreeMotion& motion, bool renews, Separator* own) const {
    const Distance rho(distance(row, motion.r), difference(row, motion.v));
    const auto w0 = [&](std::size_t point, bool is_support) {
      return motion.uniform != nullptr && !is_support ? *motion.uniform : load(motion.w0, point);
    };
    const Vec3 left = w0(cut_.path.left_point(row), cut_.path.begins_at_support(row)),
               right = w0(cut_.path.right_point(row), cut_.path.ends_at_support(row));
    const double b = rho.second + dot(rho.unit, right - left) - rows_.length_change(row, &MovingScalar::second);
    if (renews) set_direction(row, rho.unit, own);
    set_right_side(b, own);
    return b;
  }

  // ---- whole passes ----

  /// Computes y of a right side [d], and x of the separators.
  void substitute_forward(const double* b) const {
    (void)for_pieces([&](PathBlock& block) {
      block.read_right_side(b);
      block.substitute_forward();
    });
    for_alone([&](std::size_t row, Separator& own) { set_right_side(b[row], &own); });
    solve_separators(separators(), is_ring());
  }
  /// Computes points += M^-1 K x, after take(block) has found x of the pieces.
  template <class Take>
  void move(const double* blocks, double* points, const Take& take) const {
    (void)for_pieces([&](PathBlock& block) {
      block.read_directions(blocks);
      take(block);
      block.accelerate(blocks, points, false);
      block.write_accelerations(nullptr, points);
    });
    (void)accelerate(nullptr, points);
  }
  /// Takes u of the separators from blocks that may be newer than the factor.
  void take_directions(const double* blocks) const {
    for_separators([&](std::size_t row, Separator& own) { own.u = rows_.direction(blocks, row); });
  }
  /// Computes points += M^-1 K rows. The blocks may be newer than the factor.
  void add_reactions(const double* blocks, const double* rows, double* points) const {
    take_directions(blocks);
    for_separators([&](std::size_t row, Separator& own) { own.x = rows[row]; });
    move(blocks, points, [&](PathBlock& block) { block.read_multipliers(rows); });
  }
  /// Computes w := w0 + dw, or adds dw to w if w0 is null, at the points of rods alone and at the end of the path, once
  /// those of pieces are done. Returns the largest |K'dw + b| of the separators.
  double accelerate(const Vec3* w0, double* w) const {
    const auto write = [&](std::size_t point, Vec3 dw) {
      store(w, point, (w0 != nullptr ? *w0 : load(w, point)) + dw);
    };
    for_alone([&](std::size_t row, Separator& own) {
      own.first_dw = own.last_dw = {};
      if (cut_.path.begins_at_support(row)) return;
      const Separator& before = factor_.before(cut_, static_cast<std::size_t>(&own - factor_.separators.data()));
      own.first_dw = own.last_dw = own.inverse_mass_before * (before.force() - own.force());
      write(cut_.path.left_point(row), own.last_dw);
    });
    const std::span<const Separator> all = separators();
    Vec3 end_dw = all.front().first_dw;
    if (!is_ring()) {
      const std::size_t row = cut_.path.end - 1, point = cut_.path.right_point(row);
      end_dw = rows_.inverse_mass[point] * all.back().force();
      if (!cut_.path.ends_at_support(row)) write(point, end_dw);
    }
    double residual = 0.0;
    for (std::size_t q = 0; q < all.size(); ++q) {
      const Vec3 behind = q + 1 < all.size() ? all[q + 1].first_dw : end_dw;
      residual = larger(residual, std::abs(dot(all[q].u, behind - all[q].last_dw) + all[q].b));
    }
    return residual;
  }

 private:
  void bring_up_to(std::size_t end, const PointSource* source) const {
    std::size_t& next = workspaces_[0].next_point;
    if (source == nullptr || next >= end) return;
    detail::bring(parallel_, source, next, end);
    next = end;
  }

  const PathRows& rows_;
  PathFactor& factor_;
  const PathRows::Cut& cut_;

 public:
  Found& found;

 private:
  const Parallel& parallel_;
  std::span<PathWorkspace> workspaces_;
};

/// Calls work(visit) for each path. All threads work on a path that is more than one thread's share, one after the
/// other; each of the others belongs to one thread.
template <class Work>
void PathSolver::for_each_path(const Parallel& parallel, const Work& work) {
  std::size_t total = 0;
  for (const PathRows::Cut& cut : rows_.paths) total += cut.path.num_rows();
  const std::size_t shares = std::clamp<std::size_t>(
      total / plan::rows_worth_a_thread, 1, std::min(workspaces_.size(), static_cast<std::size_t>(parallel.threads())));
  const auto is_shared = [&](const PathRows::Cut& cut) { return shares > 1 && cut.path.num_rows() * shares > total; };
  for (std::size_t p = 0; p < rows_.paths.size(); ++p) {
    if (is_shared(rows_.paths[p])) work(Visit(this, p, parallel, 0));
  }
  const Parallel alone(1);
  parallel.for_tasks(shares, [&](std::size_t share) {
    std::size_t before = 0;
    for (std::size_t p = 0; p < rows_.paths.size(); before += rows_.paths[p++].path.num_rows()) {
      if (before * shares / total == share && !is_shared(rows_.paths[p])) work(Visit(this, p, alone, share));
    }
  });
}

namespace {

/// Returns the largest number of all lanes.
double largest_of(const Pack<>& lanes) {
  double result = lanes[0];
  for (std::size_t lane = 1; lane < num_lanes; ++lane) result = std::max(result, lanes[lane]);
  return result;
}

}  // namespace

Elimination PathSolver::found() const {
  Elimination result;
  for (const Found& own : found_)
    result.include(
        {1.0 / own.largest_inverse, own.right_side, own.residual, own_residual(own.residual, own.right_side)});
  return result;
}

Projection PathSolver::reached() const {
  Projection result;
  for (const Found& own : found_) {
    result.violation = larger(result.violation, own.projection.violation);
    result.iterations = std::max(result.iterations, own.projection.iterations);
  }
  return result;
}

// ---- the calls ----

Elimination PathSolver::solve(const Parallel& parallel, const FreeMotion& motion, FactorUse use, double* blocks,
                              double*, double* lambda, double* w) {
  const bool renews = use == FactorUse::Renew;
  for_each_path(parallel, [&](const Visit& visit) {
    visit.begin_bringing(motion.source);
    const paths::Found up = visit.for_pieces([&](PathBlock& block) {
      visit.bring_for(block, motion.source);
      const Motion own = block.read_motion(motion, blocks);
      if (renews) {
        block.evaluate_and_eliminate(own);
        block.write_directions(blocks);
      } else {
        block.evaluate(own);
        block.substitute_forward();
      }
    });
    visit.end_bringing(motion.source);
    double right_side = up.row.read();
    visit.for_alone([&](std::size_t row, Separator& own) {
      right_side = larger(right_side, std::abs(visit.evaluate(row, motion, renews, &own)));
      if (renews) rows_.write_direction(own.u, row, blocks);
    });
    visit.found.right_side = right_side;
    if (!renews) visit.take_directions(blocks);
    if (renews)
      visit.found.largest_inverse =
          larger(largest_of(up.largest_inverse), factorize_separators(visit.separators(), visit.is_ring()));
    solve_separators(visit.separators(), visit.is_ring());
    const paths::Found down = visit.for_pieces([&](PathBlock& block) {
      block.read_directions(blocks);
      block.substitute_backward();
      block.accelerate(blocks, w, true);
      block.write_multipliers(lambda);
      block.write_accelerations(motion.uniform, w);
    });
    visit.for_alone([&](std::size_t row, const Separator& own) { lambda[row] = own.x; });
    visit.found.residual = larger(down.residual.read(), visit.accelerate(motion.uniform, w));
  });
  return found();
}

template <class Take>
Elimination PathSolver::eliminate(const Parallel& parallel, const Take& take) {
  for_each_path(parallel, [&](const Visit& visit) {
    const paths::Found up = take(visit);
    visit.found.largest_inverse =
        larger(largest_of(up.largest_inverse), factorize_separators(visit.separators(), visit.is_ring()));
    visit.found.right_side = visit.found.residual = 0.0;
  });
  return found();
}

Elimination PathSolver::factorize(const Parallel& parallel, const double* blocks) {
  return eliminate(parallel, [&](const Visit& visit) {
    visit.for_alone(
        [&](std::size_t row, Separator& own) { visit.set_direction(row, rows_.direction(blocks, row), &own); });
    return visit.for_pieces([&](PathBlock& block) {
      block.read_directions(blocks);
      block.eliminate();
    });
  });
}

Elimination PathSolver::linearise(const Parallel& parallel, const double* r, const PointSource* source,
                                  double* blocks) {
  return eliminate(parallel, [&](const Visit& visit) {
    visit.begin_bringing(source);
    const paths::Found result = visit.for_pieces([&](PathBlock& block) {
      visit.bring_for(block, source);
      block.find_directions(block.read_motion({r, nullptr, nullptr}, blocks));
      block.write_directions(blocks);
      block.eliminate();
    });
    visit.end_bringing(source);
    visit.for_alone([&](std::size_t row, Separator& own) {
      const Vec3 a = visit.distance(row, r);
      visit.set_direction(row, (1.0 / norm(a)) * a, &own);
      rows_.write_direction(own.u, row, blocks);
    });
    return result;
  });
}

void PathSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  for_each_path(parallel, [&](const Visit& visit) {
    visit.substitute_forward(b);
    (void)visit.for_pieces([&](PathBlock& block) {
      block.substitute_backward();
      block.write_multipliers(x);
    });
    visit.for_alone([&](std::size_t row, const Separator& own) { x[row] = own.x; });
  });
}

void PathSolver::correct(const Parallel& parallel, const double* blocks, double* rows, double* points) {
  for_each_path(parallel, [&](const Visit& visit) {
    visit.substitute_forward(rows);
    visit.move(blocks, points, [&](PathBlock& block) {
      block.substitute_backward();
      block.write_multipliers(rows);
    });
    visit.for_alone([&](std::size_t row, const Separator& own) { rows[row] = own.x; });
  });
}

void PathSolver::add_reactions(const Parallel& parallel, const double* blocks, const double* rows, double* points) {
  for_each_path(parallel, [&](const Visit& visit) { visit.add_reactions(blocks, rows, points); });
}

// ---- projections ----

/// Iterates with evaluate(block) and alone(row), which find violations, and points += M^-1 K S^-1 (-violations).
template <class Evaluate, class EvaluateAlone>
Projection PathSolver::project(const Visit& visit, const double* blocks, double target, const Evaluate& evaluate,
                               const EvaluateAlone& alone, double* points, double* sum) {
  return iterate_along_chord(
      target,
      [&] {
        const paths::Found found = visit.for_pieces([&](PathBlock& block) {
          evaluate(block);
          block.substitute_forward();
        });
        double violation = found.row.read();
        visit.for_alone([&](std::size_t row, Separator& own) {
          const auto [value, scale] = alone(row);
          Visit::set_right_side(value, &own);
          violation = larger(violation, std::abs(value) / scale);
        });
        return violation;
      },
      [&] {
        solve_separators(visit.separators(), visit.is_ring());
        visit.move(blocks, points, [&](PathBlock& block) {
          block.substitute_backward();
          if (sum != nullptr) block.add_multipliers(sum);
        });
        visit.for_alone([&](std::size_t row, const Separator& own) {
          if (sum != nullptr) sum[row] += own.x;
        });
      });
}

Projection PathSolver::project_positions(const Parallel& parallel, const double* blocks, double target, double* r,
                                         const PointSource* source, double* sum) {
  rows_.take_lengths();
  for_each_path(parallel, [&](const Visit& visit) {
    visit.begin_bringing(source);
    visit.end_bringing(source);
    if (sum != nullptr) visit.add_reactions(blocks, sum, r);
    const auto value = [&](std::size_t row) {
      return std::pair(norm(visit.distance(row, r)) - rows_.length[row], rows_.length[row]);
    };
    visit.found.projection = project(
        visit, blocks, target, [&](PathBlock& block) { block.evaluate_values(r); }, value, r, sum);
  });
  return reached();
}

Projection PathSolver::project_velocities(const Parallel& parallel, const double* blocks, double target,
                                          const double* r, double* v, double* sum) {
  for_each_path(parallel, [&](const Visit& visit) {
    const auto rate = [&](std::size_t row) {
      const double first = Distance(visit.distance(row, r), visit.difference(row, v)).first;
      return std::pair(first - rows_.length_change(row, &MovingScalar::first), 1.0);
    };
    visit.found.projection = project(
        visit, blocks, target, [&](PathBlock& block) { block.evaluate_rates(r, v); }, rate, v, sum);
  });
  return reached();
}

}  // namespace tanor::detail
