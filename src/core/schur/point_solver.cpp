#include "schur/point_solver.hpp"

#include <algorithm>

#include "base/distance.hpp"
#include "plan/thresholds.hpp"
#include "schur/findings.hpp"
#include "schur/lane_transfers.hpp"

namespace tanor::detail {

// ---- arithmetic of eight points at once; arrays are [group of eight], or [row][group] for the rows of points ----

namespace {

/// So many groups of consecutive points, with plain arrays of their numbers.
struct PointGroups {
  std::size_t count;
  const double *inverse_mass, *r = nullptr, *v = nullptr, *w0 = nullptr;
  const Vec3* uniform = nullptr;  ///< if not null, w0 of all points
  double* w = nullptr;            ///< may be w0
};

/// Evaluates gradients and phi of points on spheres: u = a/|a|, phi = (v.v - (u.v)^2)/|a| with a = r - center. On
/// circles, with `normals`, the first row is that of the plane of the normal, and the other the same in that plane.
void evaluate_distances(const PointGroups& points, const Pack3<>* centers, const Pack3<>* normals, Pack3<>* gradients,
                        Pack<>* phi) {
  for_each_part([ =, count = points.count, r = points.r, v = points.v ]<class Lanes>(const Lanes& part)
                    __attribute__((always_inline)) {
                      for (std::size_t k = 0; k < count; ++k) {
                        auto u = part.load_points(r + 3 * num_lanes * k) - part.of(centers[k]),
                             velocity = part.load_points(v + 3 * num_lanes * k);
                        if (normals != nullptr) {
                          const auto n = part.of(normals[k]);
                          u = u - dot(n, u) * n;
                          velocity = velocity - dot(n, velocity) * n;
                          part.write(n, &gradients[k]);
                          part.of(phi[k]) = typename Lanes::Lane{};
                        }
                        const std::size_t own = normals != nullptr ? count + k : k;
                        typename Lanes::Lane inverse;
                        normalise(&u.x, &u.y, &u.z, &inverse);
                        part.of(phi[own]) = second_derivative_of_distance(u, velocity, inverse);
                        part.write(u, &gradients[own]);
                      }
                    });
}

/// G'G = L D L' of some points, with L below the diagonal and 1/D on it.
template <class Lanes, std::size_t rows>
struct Leaf {
  using Lane = typename Lanes::Lane;
  Lane at[rows][rows];

  [[gnu::always_inline]] void factorize(const typename Lanes::Vector* g, Lane* largest) {
    // 1/(g.g) = 2 - g.g, since g.g = 1 but for rounding.
    if constexpr (rows == 1) return void(at[0][0] = 2.0 - dot(g[0], g[0]));
    for (std::size_t i = 0; i < rows; ++i) {
      Lane c[rows];
      const Lane diagonal = dot(g[i], g[i]);
      Lane pivot = diagonal;
      for (std::size_t j = 0; j < i; ++j) {
        c[j] = dot(g[i], g[j]);
        for (std::size_t k = 0; k < j; ++k) c[j] -= c[k] * at[j][k];
        at[i][j] = c[j] * at[j][j];
        pivot -= c[j] * at[i][j];
      }
      at[i][i] = 1.0 / pivot;
      if (i > 0) lanes::include(diagonal * at[i][i], largest);
    }
  }
  /// Computes x := -(G'G)^-1 b.
  [[gnu::always_inline]] void solve(const Lane* b, Lane* x) const {
    for (std::size_t i = 0; i < rows; ++i) {
      x[i] = -b[i];
      for (std::size_t k = 0; k < i; ++k) x[i] -= at[i][k] * x[k];
    }
    for (std::size_t i = 0; i < rows; ++i) x[i] *= at[i][i];
    for (std::size_t i = rows; i-- > 1;) {
      for (std::size_t k = 0; k < i; ++k) x[k] -= at[i][k] * x[i];
    }
  }
};

/// Returns w0 of a group.
template <class Lanes>
[[gnu::always_inline]] inline auto load_free(const Lanes& part, const PointGroups& points, std::size_t group) {
  using Lane = typename Lanes::Lane;
  if (points.uniform == nullptr) return part.load_points(points.w0 + 3 * num_lanes * group);
  const auto [x, y, z] = *points.uniform;
  return typename Lanes::Vector{Lane{} + x, Lane{} + y, Lane{} + z};
}

/// Factorizes G'G. Then, unless `lambda` is null, computes lambda := -m (G'G)^-1 b with b = phi, or, if w is wanted,
/// with b = phi + K'w0 and also w := w0 + G lambda/m.
template <std::size_t rows>
void solve_points(const PointGroups& points_of, const Pack3<>* gradients, const Pack<>* phi, Pack<>* lambda,
                  lanes::Findings* found) {
  for_each_part([ =, points_at = &points_of ]<class Lanes>(const Lanes& part) __attribute__((always_inline)) {
    using Lane = typename Lanes::Lane;
    const PointGroups points = *points_at;
    Lane largest = part.of(found->largest_inverse);
    Seen<Lanes::width> seen_b, seen_left;
    for (std::size_t k = 0; k < points.count; ++k) {
      typename Lanes::Vector g[rows];
      for (std::size_t m = 0; m < rows; ++m) g[m] = part.of(gradients[m * points.count + k]);
      Leaf<Lanes, rows> leaf;
      leaf.factorize(g, &largest);
      if (lambda == nullptr) continue;
      Lane b[rows], x[rows];
      for (std::size_t m = 0; m < rows; ++m) b[m] = part.of(phi[m * points.count + k]);
      // The quotient is nearly always m itself.
      const Lane mass = 1.0 / part.load(points.inverse_mass + num_lanes * k);
      if (points.w == nullptr) {
        leaf.solve(b, x);
      } else {
        const auto free = load_free(part, points, k);
        for (std::size_t m = 0; m < rows; ++m) {
          b[m] += dot(g[m], free);
          seen_b.see(magnitude(b[m]));
        }
        leaf.solve(b, x);
        auto dw = x[0] * g[0];
        for (std::size_t m = 1; m < rows; ++m) dw = dw + x[m] * g[m];
        part.store_points(free + dw, points.w + 3 * num_lanes * k);
        for (std::size_t m = 0; m < rows; ++m) seen_left.see(magnitude(b[m] + dot(g[m], dw)));
      }
      for (std::size_t m = 0; m < rows; ++m) part.of(lambda[m * points.count + k]) = x[m] * mass;
    }
    part.of(found->largest_inverse) = largest;
    seen_b.write(part, &found->right_side);
    seen_left.write(part, &found->residual);
  });
}

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
std::unique_ptr<PointSolver> PointSolver::make(const SchurProblem& problem, std::vector<Index>* islands) {
  struct Row {
    Index point = -1, kind, guide;
  };
  std::vector<Row> rows(problem.numbering.num_rows());
  std::vector<Index> block_of(rows.size(), -1);
  for_each_guide(problem.constraints, [&]<class Kernel>(const Family<Kernel>& family) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      for (Index m = 0; m < Kernel::num_rows; ++m) {
        const auto row = static_cast<std::size_t>(family.rows[k] + m);
        rows[row] = {family.kernel.points[k][0], family.first_block, family.kernel.geometry[k]};
        block_of[row] = family.first_block + static_cast<Index>(k) * Kernel::num_blocks + m;
      }
    }
  });
  std::vector<Chunk> chunks;
  std::vector<Index> served;
  std::erase_if(*islands, [&](Index island) {
    const Index* const start = problem.numbering.island_start.data() + island;
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
    if (chunks.empty() || !continues(chunks.back())) chunks.push_back({point, first, count});
    Chunk& chunk = chunks.back();
    for (std::size_t m = 0; m < count; ++m) {
      const std::size_t front = chunk.first_row + m, block = static_cast<std::size_t>(block_of[front]);
      chunk.has_one_guide[m] = chunk.has_one_guide[m] && own[m].guide == rows[front].guide;
      chunk.are_neighbours[m] =
          chunk.are_neighbours[m] && static_cast<std::size_t>(block_of[first + m]) == block + chunk.num_points;
    }
    ++chunk.num_points;
    served.push_back(island);
    return true;
  });
  if (chunks.empty()) return nullptr;
  std::unique_ptr<PointSolver> result(new PointSolver({problem, served}, std::move(block_of), std::move(chunks)));
  FactorSummary factor{.parts = served.size()};
  std::size_t num_gradients = 0;
  for (Chunk& chunk : result->chunks_) {
    chunk.first_gradient = num_gradients;
    if (chunk.num_rows > 1) num_gradients += chunk.num_rows * chunk.num_groups();
    factor.pattern_nonzeros += chunk.num_points * chunk.num_rows * (chunk.num_rows + 1) / 2;
  }
  result->gradients_.resize(num_gradients);
  factor.factor_nonzeros = factor.pattern_nonzeros;
  factor.flops = 2.0 * static_cast<double>(factor.factor_nonzeros);
  result->summary_ = {
      .solvers = {LinearSolver::ClosedForm}, .reason = "nothing joins points on guides of their own", .factor = factor};
  return result;
}

// ---- every step ----

/// A chunk in lanes. Lanes behind the last point repeat it.
class PointSolver::Work {
 public:
  Pack<> b[most_rows * most_groups];
  lanes::Findings found;

  explicit Work(PointSolver* solver) : solver_(*solver) {}

  void begin(const Chunk& chunk) {
    chunk_ = &chunk;
    gradients_ = chunk.num_rows > 1 ? solver_.gradients_.data() + chunk.first_gradient : of_single_rows_;
  }
  bool has_several_rows() const { return chunk_->num_rows > 1; }
  PointGroups masses() { return {chunk_->num_groups(), read(solver_.group_.inverse_mass.data(), 1, copies_[3])}; }
  /// Returns the points; `write_accelerations` completes w.
  PointGroups read_points(const FreeMotion& motion, double* w) {
    PointGroups result = masses();
    result.r = read(motion.r, 3, copies_[0]);
    result.v = read(motion.v, 3, copies_[1]);
    result.uniform = motion.uniform;
    if (motion.uniform == nullptr) result.w0 = read(motion.w0, 3, copies_[2]);
    result.w = chunk_->is_full() ? w + 3 * chunk_->first_point : copies_[2];
    return result;
  }
  void write_accelerations(double* w) const {
    if (!chunk_->is_full()) std::copy_n(copies_[2], 3 * chunk_->num_points, w + 3 * chunk_->first_point);
  }
  void read_rows(const double* from) {
    for_each_lane(0, chunk_->num_rows,
                  [&](std::size_t row, std::size_t k, std::size_t lane) { b[k][lane] = from[row]; });
  }
  void write_rows(double* to) const {
    if (!has_several_rows())
      return void(std::copy_n(reinterpret_cast<const double*>(lambda_), chunk_->num_points, to + chunk_->first_row));
    for_each_lane(0, chunk_->num_rows,
                  [&](std::size_t row, std::size_t k, std::size_t lane) { to[row] = lambda_[k][lane]; });
  }
  void read_blocks(const double* from) {
    for_each_lane(0, chunk_->num_rows, [&](std::size_t row, std::size_t k, std::size_t lane) {
      set_lane(&gradients_[k], lane, load(from, solver_.block_[row]));
    });
  }
  void write_blocks(double* to) const {
    const Pack3<>* own = gradients_;
    for (std::size_t m = 0; m < chunk_->num_rows; ++m, own += chunk_->num_groups()) {
      if (chunk_->is_full() && chunk_->are_neighbours[m]) {
        scatter_neighbours(own, chunk_->num_groups(), to + 3 * solver_.block_[chunk_->first_row + m]);
        continue;
      }
      for_each_lane(m, 1, [&](std::size_t row, std::size_t k, std::size_t lane) {
        store(to, solver_.block_[row], lane_of(own[k], lane));
      });
    }
  }
  /// Evaluates gradients, and phi in the place of b.
  void evaluate(const FreeMotion& motion, const PointGroups& points) {
    for (std::size_t m = 0; m < chunk_->num_rows;) {
      const Index block = solver_.block_[chunk_->first_row + m];
      for_each_guide(solver_.group_.constraints, [&]<class Kernel>(const Family<Kernel>& family) {
        const Index begin = family.first_block;
        if (block < begin || block >= begin + Kernel::num_blocks * static_cast<Index>(family.size())) return;
        evaluate(family, motion, points, m);
        m += Kernel::num_rows;
      });
    }
  }
  /// Takes any unit vectors for the gradients of points of one row, which need no factor.
  void take_units() {
    if (!has_several_rows()) fill(gradients_, chunk_->num_groups(), {1.0, 0.0, 0.0});
  }
  /// Solves for lambda, or only factorizes.
  void solve(const PointGroups& points, bool factorizes_only = false) {
    constexpr decltype(&solve_points<1>) of_rows[]{solve_points<1>, solve_points<2>, solve_points<3>};
    of_rows[chunk_->num_rows - 1](points, gradients_, b, factorizes_only ? nullptr : lambda_, &found);
  }

 private:
  /// Returns consecutive numbers of the points, `width` each.
  const double* read(const double* from, std::size_t width, double* copy) const {
    const double* const own = from + width * chunk_->first_point;
    if (chunk_->is_full()) return own;
    const std::size_t count = chunk_->num_points;
    std::copy_n(own, width * count, copy);
    for (std::size_t k = count; k < chunk_->num_groups() * num_lanes; ++k)
      std::copy_n(own + width * (count - 1), width, copy + width * k);
    return copy;
  }
  /// Calls visit(row, group, lane) for the rows [first, first + count) of each point; groups count on from row to row.
  template <class Visit>
  void for_each_lane(std::size_t first, std::size_t count, const Visit& visit) const {
    for (std::size_t m = 0; m < count; ++m) {
      for (std::size_t k = 0; k < chunk_->num_groups() * num_lanes; ++k) {
        const std::size_t point = std::min(k, chunk_->num_points - 1);
        visit(chunk_->first_row + first + m + point * chunk_->num_rows, m * chunk_->num_groups() + k / num_lanes,
              k % num_lanes);
      }
    }
  }
  /// Evaluates one kind of guide, from row m of each point on. If it stands still, spheres and circles run in lanes,
  /// and gradients of others are constant.
  template <class Kernel>
  void evaluate(const Family<Kernel>& family, const FreeMotion& motion, const PointGroups& points, std::size_t m) {
    const Kernel& kernel = family.kernel;
    Pack3<>* const own = gradients_ + m * points.count;
    Pack<>* const phi = b + m * points.count;
    const auto number_at = [&](std::size_t row) {
      return static_cast<std::size_t>(solver_.block_[row] - family.first_block) / Kernel::num_blocks;
    };
    // Writes vector(number) of each point's member.
    const auto gather = [&](Pack3<>* to, const auto& vector) {
      if (chunk_->has_one_guide[m]) return fill(to, points.count, vector(number_at(chunk_->first_row + m)));
      for_each_lane(m, 1, [&](std::size_t row, std::size_t k, std::size_t lane) {
        set_lane(&to[k], lane, vector(number_at(row)));
      });
    };
    if (kernel.depends_on_time()) {
      for_each_lane(m, 1, [&](std::size_t row, std::size_t k, std::size_t lane) {
        const auto local = kernel(number_at(row), motion.r, motion.v);
        for (std::size_t a = 0; a < Kernel::num_rows; ++a) {
          phi[k + a * points.count][lane] = local.phi[a];
          set_lane(&own[k + a * points.count], lane, local.gradient[a]);
        }
      });
    } else if constexpr (requires { kernel.center; }) {
      constexpr bool is_circle = requires {
        kernel.normal;
      };
      gather(places_[0], [&](std::size_t number) { return kernel.center[kernel.geometry[number]].value; });
      if constexpr (is_circle)
        gather(places_[1], [&](std::size_t number) { return kernel.normal[kernel.geometry[number]].value; });
      evaluate_distances(points, places_[0], is_circle ? places_[1] : nullptr, own, phi);
    } else {
      for (std::size_t a = 0; a < Kernel::num_rows; ++a)
        gather(own + a * points.count,
               [&](std::size_t number) { return kernel(number, motion.r, motion.v).gradient[a]; });
      std::fill_n(phi, Kernel::num_rows * points.count, Pack<>{});
    }
  }

  PointSolver& solver_;
  const Chunk* chunk_ = nullptr;
  Pack3<>* gradients_ = nullptr;  // [row][group]
  Pack3<> of_single_rows_[most_groups], places_[2][most_groups];
  Pack<> lambda_[most_rows * most_groups];
  double copies_[4][3 * most_points];  // for a last group that is not full
};

/// Calls visit(work) for all chunks, many at once.
template <class Visit>
Elimination PointSolver::for_each_chunk(const Parallel& parallel, const Visit& visit) {
  const auto visit_range = [&](std::size_t begin, std::size_t end) {
    Work work(this);
    for (std::size_t k = begin; k < end; ++k) {
      work.begin(chunks_[k]);
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
    work->solve(points);
    work->write_rows(lambda);
    work->write_accelerations(w);
  });
}

Elimination PointSolver::factorize(const Parallel& parallel, const double* blocks) {
  if (gradients_.empty()) return {};
  return for_each_chunk(parallel, [&](Work* work) {
    if (!work->has_several_rows()) return;
    work->read_blocks(blocks);
    work->solve(work->masses(), true);
  });
}

void PointSolver::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)for_each_chunk(parallel, [&](Work* work) {
    work->take_units();
    work->read_rows(b);
    work->solve(work->masses());
    work->write_rows(x);
  });
}

}  // namespace tanor::detail
