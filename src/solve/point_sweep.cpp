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
      result[static_cast<std::size_t>(family.rows[k])] = {guide, number, family.kernel.points[k][0], Kernel::num_rows,
                                                          family.first_block + number * Kernel::num_blocks};
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
    const Member& member = rows[a];
    if (member.guide == Guide::None) return false;
    run.members[static_cast<std::size_t>(run.num_members++)] = member;
    run.num_rows += member.num_rows;
  }
  const auto continues = [&](Run& last) {
    if (last.end != run.first || last.num_rows != run.num_rows || last.num_members != run.num_members) return false;
    const Index steps = last.end - last.first;
    for (std::size_t k = 0; k < static_cast<std::size_t>(run.num_members); ++k) {
      if (last.members[k].guide != run.members[k].guide) return false;
      const Index way = run.members[k].number - last.members[k].number;
      if (steps == 1) last.stride[k] = way;
      if (way != steps * last.stride[k]) return false;
    }
    ++last.end;
    return true;
  };
  if (runs_.empty() || !continues(runs_.back())) runs_.push_back(run);
  return true;
}

std::unique_ptr<PointSweep> PointSweep::make(const Constraints& constraints, const Numbering& numbering,
                                             std::span<const double> inverse_mass) {
  const std::vector<Member> members = read_members(constraints, numbering.num_rows());
  std::unique_ptr<PointSweep> result(new PointSweep(constraints));
  result->inverse_mass_ = inverse_mass;
  bool needs_factors = false;
  const std::vector<Index>& start = numbering.island_start;
  for (std::size_t k = 0; k + 1 < start.size(); ++k) {
    const auto first = static_cast<std::size_t>(start[k]), count = static_cast<std::size_t>(start[k + 1]) - first;
    // an island of more than one point is none of ours, and has a row that is none of ours
    if (count > most_rows || members[first].guide == Guide::None) return nullptr;
    if (!result->append_point(std::span(members).subspan(first, count), start[k])) return nullptr;
    needs_factors = needs_factors || count > 1;
  }
  if (needs_factors) result->factors_.resize(numbering.num_islands());
  Summary& summary = result->summary_;
  summary = {.name = "closed form", .reason = "no constraint joins two points", .parts = numbering.num_islands()};
  for (const Run& run : result->runs_) {
    const auto rows = static_cast<std::size_t>(run.num_rows), points = static_cast<std::size_t>(run.end - run.first);
    summary.pattern_nonzeros += points * rows * (rows + 1) / 2;
  }
  summary.factor_nonzeros = summary.pattern_nonzeros;
  summary.flops = 2.0 * static_cast<double>(summary.factor_nonzeros);
  return result;
}

// ---- every step ----

/// visitor(the family of a guide)
template <class Visitor>
void PointSweep::visit(Guide guide, const Visitor& visitor) const {
  switch (guide) {
    case Guide::Plane:
      return visitor(constraints_.family<PlaneKernel>());
    case Guide::Sphere:
      return visitor(constraints_.family<SphereKernel>());
    case Guide::Line:
      return visitor(constraints_.family<LineKernel>());
    case Guide::Circle:
      return visitor(constraints_.family<CircleKernel>());
    case Guide::None:
      return;
  }
}

namespace {

constexpr std::size_t grain = 2048;  // points: fewer are not worth a thread

/// x := -(G'G)^-1 b
template <int R, class Factor>
void solve_negative(const Factor& factor, const double* b, double* x) {
  double y1 = 0.0, y2 = 0.0;
  x[0] = -b[0];
  if constexpr (R > 1) y1 = -b[1] - factor.l10 * x[0];
  if constexpr (R > 2) {
    y2 = -b[2] - factor.l20 * x[0] - factor.l21 * y1;
    x[2] = y2 * factor.inverse_d2;
  }
  if constexpr (R > 1) {
    x[1] = y1 * factor.inverse_d1;
    if constexpr (R > 2) x[1] -= factor.l21 * x[2];
    x[0] -= factor.l10 * x[1];
  }
  if constexpr (R > 2) x[0] -= factor.l20 * x[2];
}

/// Returns the smallest pivot, the reciprocal condition; 0 where there is no factor.
template <int R, class Factor>
double factorize(const Vec3* g, Factor* factor) {
  if constexpr (R == 1) return 1.0;
  factor->l10 = dot(g[1], g[0]);
  const double d1 = 1.0 - factor->l10 * factor->l10;
  factor->inverse_d1 = 1.0 / d1;
  double smallest = d1;
  if constexpr (R > 2) {
    factor->l20 = dot(g[2], g[0]);
    const double c = dot(g[2], g[1]) - factor->l20 * factor->l10;
    factor->l21 = c * factor->inverse_d1;
    const double d2 = 1.0 - factor->l20 * factor->l20 - c * factor->l21;
    factor->inverse_d2 = 1.0 / d2;
    smallest = d2 < d1 ? d2 : d1;
  }
  return smallest > 0.0 ? smallest : 0.0;
}

}  // namespace

/// work(run, begin, end, found) for parts of the runs, many at once.
template <class Work>
Elimination PointSweep::for_each_part(const Parallel& parallel, const Work& work) {
  constexpr std::size_t most_shares = 64;
  std::array<Elimination, most_shares> found{};
  const std::size_t num_points = static_cast<std::size_t>(runs_.back().end - runs_.front().first);
  const auto threads = static_cast<std::size_t>(parallel.threads());
  const std::size_t shares = std::clamp<std::size_t>(num_points / grain, 1, std::min(threads, most_shares));
  parallel.for_tasks(shares, [&](std::size_t k) {
    const auto begin = runs_.front().first + static_cast<Index>(num_points * k / shares);
    const auto end = runs_.front().first + static_cast<Index>(num_points * (k + 1) / shares);
    auto run = std::partition_point(runs_.begin(), runs_.end(), [&](const Run& each) { return each.end <= begin; });
    for (; run != runs_.end() && run->first < end; ++run) {
      const Index first = std::max(begin, run->first), last = std::min(end, run->end);
      if (run->num_rows == 1) work.template operator()<1>(*run, first, last, &found[k]);
      if (run->num_rows == 2) work.template operator()<2>(*run, first, last, &found[k]);
      if (run->num_rows == 3) work.template operator()<3>(*run, first, last, &found[k]);
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

template <int R>
void PointSweep::solve(const Run& run, Index begin, Index end, const FreeMotion& motion, double* blocks, double* b,
                       double* lambda, double* w, Elimination* found) {
  double largest = 0.0, residual = 0.0, smallest = 1.0, zero = 0.0;
  for (Index i = begin; i < end; ++i) {
    const Index step = i - run.first;
    const auto row = static_cast<std::size_t>(run.first_row + step * R);
    const Vec3 w0 = motion.uniform != nullptr ? *motion.uniform : load(motion.w0, i);
    double phi[R] = {}, x[R];
    Vec3 g[R];
    int count = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(run.num_members); ++k) {
      const Member& member = run.members[k];
      const Index number = member.number + step * run.stride[k];
      const auto evaluate = [&]<class Kernel>(const Family<Kernel>& family) {
        const auto local = family.kernel(static_cast<std::size_t>(number), motion.r, motion.v);
        for (int m = 0; m < Kernel::num_rows && count < R; ++m, ++count) {
          phi[count] = local.phi[m];
          g[count] = local.gradient[m];
          store(blocks, family.first_block + number * Kernel::num_blocks + m, local.gradient[m]);
        }
      };
      visit(member.guide, evaluate);
    }
    Factor factor;
    if constexpr (R > 1) {
      const double pivot = tanor::factorize<R>(g, &factor);
      smallest = pivot < smallest ? pivot : smallest;
      factors_[static_cast<std::size_t>(i)] = factor;
    }
    // b = phi + K'w0
    for (int m = 0; m < R; ++m) {
      phi[m] += dot(g[m], w0);
      b[row + m] = phi[m];
      largest = std::max(largest, std::abs(phi[m]));
      zero += 0.0 * phi[m];
    }
    tanor::solve_negative<R>(factor, phi, x);
    Vec3 dw{};
    const double mass = 1.0 / inverse_mass_[static_cast<std::size_t>(i)];
    for (int m = 0; m < R; ++m) {
      dw = dw + x[m] * g[m];
      lambda[row + m] = mass * x[m];
    }
    for (int m = 0; m < R; ++m) residual = std::max(residual, std::abs(phi[m] + dot(g[m], dw)));
    store(w, i, w0 + dw);
  }
  found->largest_right_side = larger(found->largest_right_side, largest + zero);
  found->residual = larger(found->residual, residual + zero);
  found->reciprocal_condition = std::min(found->reciprocal_condition, smallest);
}

Elimination PointSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b,
                              double* lambda, double* w) {
  return for_each_part(parallel, [&]<int R>(const Run& run, Index begin, Index end, Elimination* found) {
    solve<R>(run, begin, end, motion, blocks, b, lambda, w, found);
  });
}

Elimination PointSweep::factorize(const Parallel& parallel, const double* blocks) {
  return for_each_part(parallel, [&]<int R>(const Run& run, Index begin, Index end, Elimination* found) {
    for (Index i = begin; i < end && R > 1; ++i) {
      Vec3 g[R];
      int count = 0;
      for (std::size_t k = 0; k < static_cast<std::size_t>(run.num_members); ++k) {
        const Member& member = run.members[k];
        const Index block = member.first_block + (i - run.first) * run.stride[k] * member.num_rows;
        for (int m = 0; m < member.num_rows; ++m) g[count++] = load(blocks, block + m);
      }
      const double pivot = tanor::factorize<R>(g, &factors_[static_cast<std::size_t>(i)]);
      found->reciprocal_condition = std::min(found->reciprocal_condition, pivot);
    }
  });
}

void PointSweep::solve_negative(const Parallel& parallel, const double* b, double* x) {
  (void)for_each_part(parallel, [&]<int R>(const Run& run, Index begin, Index end, Elimination*) {
    for (Index i = begin; i < end; ++i) {
      const auto row = static_cast<std::size_t>(run.first_row + (i - run.first) * R),
                 point = static_cast<std::size_t>(i);
      double y[R];
      tanor::solve_negative<R>(R > 1 ? factors_[point] : Factor{}, b + row, y);
      const double mass = 1.0 / inverse_mass_[point];
      for (int m = 0; m < R; ++m) x[row + m] = mass * y[m];
    }
  });
}

}  // namespace tanor
