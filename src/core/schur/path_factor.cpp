#include "schur/path_factor.hpp"

#include <algorithm>

#include "plan/thresholds.hpp"

/// \file The two passes over the halves of one path, some rods at a time, so that the numbers of a chunk stay in the
/// first cache from its evaluation to its last operation. The row that closes a ring is in path_rings.cpp.
namespace tanor::detail {

using paths::chunk_size, paths::Towards;

PathFactor::PathFactor(const PathRows& rows) : rows_(rows) {
  for (std::vector<double>* array : {&inverse_pivot_, &factor_}) array->resize(rows.num_rows());
  right_factor_.resize(rows.paths.size());
  if (rows.num_rings > 0) spike_.resize(rows.num_rows());
}

void PathFactor::list_upcoming(const RodPath& path, const PathEquations& equations, std::size_t first,
                               std::size_t count, paths::Upcoming* upcoming) const {
  if (count == 0 || rows_.num_rows() < plan::rows_beyond_cache) return;
  constexpr std::size_t number = sizeof(double), vector = 3 * number;
  const std::size_t point = path.right_point(first);
  upcoming->add(&rows_.inverse_mass[point], number * (count - 1));
  if (equations.motion != nullptr) upcoming->add(equations.motion->r + 3 * point, vector * (count - 1));
  if (equations.b != nullptr) {
    upcoming->add(equations.motion->v + 3 * point, vector * (count - 1));
    upcoming->add(equations.b + first, number * count);
    upcoming->add(equations.y + first, number * count);
  }
  if (rows_.blocks_follow_rows())
    upcoming->add(equations.given_blocks + 3 * (rows_.first_block + first), vector * count);
  upcoming->add(&inverse_pivot_[first], number * count);
  upcoming->add(&factor_[first], number * count);
  if (path.is_ring) upcoming->add(&spike_[first], number * count);
}

void PathFactor::list_upcoming(const RodPath& path, const PathReactions& reactions, std::size_t first,
                               std::size_t count, paths::Upcoming* upcoming) const {
  if (count == 0 || rows_.num_rows() < plan::rows_beyond_cache) return;
  constexpr std::size_t number = sizeof(double), vector = 3 * number;
  const std::size_t point = path.right_point(first);
  upcoming->add(reactions.lambda + first, number * count);
  upcoming->add(&inverse_pivot_[first], number * count);
  upcoming->add(&factor_[first], number * count);
  if (path.is_ring) upcoming->add(&spike_[first], number * count);
  if (rows_.blocks_follow_rows()) upcoming->add(reactions.blocks + 3 * (rows_.first_block + first), vector * count);
  if (reactions.b != nullptr) upcoming->add(reactions.b + first, number * count);
  upcoming->add(&rows_.inverse_mass[point], number * (count - 1));
  upcoming->add(reactions.w + 3 * point, vector * (count - 1));
}

// ---- the factor ----

void PathFactor::eliminate_from_ends(std::size_t p, const PathEquations& equations, paths::Sides sides,
                                     paths::PathWork* work) {
  const RodPath& path = rows_.paths[p];
  const std::size_t middle = path.middle();
  paths::Half left(Towards::Right, path.first, includes(sides, paths::Sides::Left) ? middle - path.first : 0);
  paths::Half right(Towards::Left, path.end, includes(sides, paths::Sides::Right) ? path.end - middle - 1 : 0);
  const bool brings = equations.source != nullptr;
  if (brings) equations.bring_middle(path, sides);
  paths::Upcoming upcoming;
  while (left.rows_left + right.rows_left > 0) {
    for (paths::Half* half : {&left, &right}) {
      half->advance();
      if (half->chunk.count == 0) continue;
      if (brings) equations.bring_rows(path, *half);
      equations.take_rows(path, half);
    }
    upcoming.clear();
    for (const paths::Half* half : {&left, &right})
      list_upcoming(path, equations, half->next_first(), half->next_count(), &upcoming);
    paths::find_pivots(&left.chunk, &left.determinants, &right.chunk, &right.determinants, &upcoming);
    for (paths::Half* half : {&left, &right}) {
      if (half->chunk.count == 0) continue;
      paths::finish_pivots(half->towards, &half->chunk, &inverse_pivot_[half->first], &factor_[half->first],
                           &half->pivots);
      half->remember_last_row();
    }
    if (equations.b != nullptr) {
      const auto substitution = [&](const paths::Half& half) {
        return paths::Substitution{equations.b + half.first, factor_.data() + half.first, equations.y + half.first,
                                   half.chunk.count, half.end.y};
      };
      paths::Substitution of_left = substitution(left), of_right = substitution(right);
      paths::substitute_forward(&of_left, &of_right);
      left.end.y = of_left.last;
      right.end.y = of_right.last;
    }
    if (path.is_ring) spread_spikes(path, equations, &left, &right);
  }
  for (paths::Half* half : {&left, &right})
    half->end.findings = {half->pivots.smallest, half->pivots.largest, half->largest};
  if (includes(sides, paths::Sides::Left)) work->left_end = left.end;
  if (includes(sides, paths::Sides::Right)) work->right_end = right.end;
}

/// Computes the pivot d = S_aa - S_ab^2/d_b - S_ac^2/d_c of the middle row a with its neighbours b and c.
void PathFactor::eliminate_middle(std::size_t p, const PathEquations& equations, paths::PathWork* work) {
  const paths::Eliminated &left = work->left_end, &right = work->right_end;
  const RodPath& path = rows_.paths[p];
  const std::size_t row = path.middle();
  const Vec3 g = equations.evaluate_row(path, row);
  const double left_mass = path.begins_at_support(row) ? 0.0 : rows_.inverse_mass[path.left_point(row)];
  const double right_mass = path.ends_at_support(row) ? 0.0 : rows_.inverse_mass[path.right_point(row)];
  const double diagonal = (left_mass + right_mass) * dot(g, g);
  const double to_left = -left_mass * dot(g, left.g), to_right = -right_mass * dot(g, right.g);
  factor_[row] = to_left * left.inverse_pivot;
  right_factor_[p] = to_right * right.inverse_pivot;
  inverse_pivot_[row] = 1.0 / (diagonal - to_left * factor_[row] - to_right * right_factor_[p]);
  const double ratio = diagonal * inverse_pivot_[row];
  paths::Findings findings{.smallest_ratio = ratio, .largest_ratio = ratio};
  if (equations.b != nullptr) {
    equations.y[row] = equations.b[row] - factor_[row] * left.y - right_factor_[p] * right.y;
    findings.right_side = std::abs(equations.b[row]);
  }
  findings.include(left.findings);
  findings.include(right.findings);
  work->findings = findings;
  if (path.is_ring) eliminate_closing_row(p, equations, work);
}

// ---- back again ----

/// Goes from the middle to both ends. Each step finds lambda of the next rods, w of the points between them and the
/// rods before, and the residual K'dw + b. Row `row` of a path joins the points of dw_left and dw_right.
void PathFactor::substitute_and_accelerate(std::size_t p, const PathReactions& reactions, double* lambda,
                                           paths::Sides sides, paths::PathWork* work) const {
  const RodPath& path = rows_.paths[p];
  const std::size_t middle = path.middle();
  const bool goes_left = includes(sides, paths::Sides::Left), goes_right = includes(sides, paths::Sides::Right);
  const double *const d = inverse_pivot_.data(), *const f = factor_.data();
  paths::BackSubstitution to_left{{}, {}, {}, 0, f[middle], reactions.lambda[middle]};
  paths::BackSubstitution to_right{{}, {}, {}, 0, right_factor_[p], reactions.lambda[middle]};
  paths::Accelerated of_left, of_right;
  Vec3 dw_left{}, dw_right{};                    // dw of the outermost points so far
  std::size_t begin = middle, end = middle + 1;  // rows [begin, end) are done
  const std::size_t first = goes_left ? path.first : middle, last = goes_right ? path.end : middle + 1;
  paths::Upcoming upcoming;
  while (begin > first || end < last) {
    const std::size_t before = begin;
    to_left.count = std::min(begin - first, chunk_size);
    to_right.count = std::min(last - end, chunk_size);
    begin -= to_left.count;
    const auto place = [&](paths::BackSubstitution* to, std::size_t row) {
      to->inverse_pivots = d + row;
      to->factors = f + row;
      to->lambda = lambda + row;
    };
    place(&to_left, begin);
    place(&to_right, end);
    if (path.is_ring) {
      paths::add(reactions.lambda[path.closing_row()], spike_.data() + begin, to_left.count, to_left.lambda);
      paths::add(reactions.lambda[path.closing_row()], spike_.data() + end, to_right.count, to_right.lambda);
    }
    const std::size_t after = end + to_right.count, more_left = std::min(begin - first, chunk_size);
    upcoming.clear();
    list_upcoming(path, reactions, begin - more_left, more_left, &upcoming);
    list_upcoming(path, reactions, after, std::min(last - after, chunk_size), &upcoming);
    paths::substitute_backward(&to_left, &to_right, &upcoming);
    if (to_left.count > 0) {
      const paths::Ends points = reactions.accelerate(path, begin, to_left.count, &of_left.residual);
      if (before == middle) {
        of_left.dw = points.last;
      } else {
        of_left.residual = larger(of_left.residual, reactions.residual_of(before, points.last, dw_left));
      }
      dw_left = points.first;
    }
    if (to_right.count > 0) {
      const paths::Ends points = reactions.accelerate(path, end - 1, to_right.count, &of_right.residual);
      if (end == middle + 1) {
        of_right.dw = points.first;
      } else {
        of_right.residual = larger(of_right.residual, reactions.residual_of(end - 1, dw_right, points.first));
      }
      dw_right = points.last;
    }
    end += to_right.count;
  }
  if (goes_left) work->left = reactions.accelerate_outermost(path, paths::Sides::Left, first, dw_left, of_left);
  if (goes_right) work->right = reactions.accelerate_outermost(path, paths::Sides::Right, last - 1, dw_right, of_right);
}

// ---- one more right side ----

void PathFactor::substitute_forward(std::size_t p, paths::Sides sides, const double* b, double* y,
                                    paths::PathWork* work) const {
  const RodPath& path = rows_.paths[p];
  const double* const f = factor_.data();
  const std::size_t first = path.first, after = path.middle() + 1;
  const std::size_t num_left = includes(sides, paths::Sides::Left) ? path.middle() - first : 0;
  const std::size_t num_right = includes(sides, paths::Sides::Right) ? path.end - after : 0;
  paths::Substitution left{b + first, f + first, y + first, num_left, 0.0};
  paths::Substitution right{b + after, f + after, y + after, num_right, 0.0};
  paths::substitute_forward(&left, &right);
  if (!path.is_ring) return;
  const auto sum = [&](std::size_t begin, std::size_t count) {
    return paths::sum_of_products(spike_.data() + begin, y + begin, inverse_pivot_.data() + begin, count);
  };
  if (includes(sides, paths::Sides::Left)) work->left_end.closing_y = sum(first, num_left);
  if (includes(sides, paths::Sides::Right)) work->right_end.closing_y = sum(after, num_right);
}

void PathFactor::substitute_middle(std::size_t p, const double* b, double* y, const paths::PathWork& work) const {
  const std::size_t middle = rows_.paths[p].middle();
  double y_middle = b[middle];
  if (middle > rows_.paths[p].first) y_middle -= factor_[middle] * y[middle - 1];
  if (middle + 1 < rows_.paths[p].end) y_middle -= right_factor_[p] * y[middle + 1];
  y[middle] = y_middle;
  if (rows_.paths[p].is_ring) substitute_closing_row(rows_.paths[p], b, y, work);
  begin_backward(p, y);
}

/// The multiplier of the closing row is found first. The path is left with y := y + spike times this multiplier.
void PathFactor::begin_backward(std::size_t p, double* y) const {
  const RodPath& path = rows_.paths[p];
  const std::size_t middle = path.middle();
  if (path.is_ring) {
    double& lambda = y[path.closing_row()];
    lambda *= -inverse_pivot_[path.closing_row()];
    y[middle] += lambda * spike_[middle];
  }
  y[middle] *= -inverse_pivot_[middle];
}

void PathFactor::substitute_backward(std::size_t p, paths::Sides sides, double* y) const {
  const double *const d = inverse_pivot_.data(), *const f = factor_.data();
  const std::size_t first = rows_.paths[p].first, middle = rows_.paths[p].middle(), after = middle + 1;
  const std::size_t num_left = includes(sides, paths::Sides::Left) ? middle - first : 0;
  const std::size_t num_right = includes(sides, paths::Sides::Right) ? rows_.paths[p].end - after : 0;
  if (rows_.paths[p].is_ring) {
    const double lambda = y[rows_.paths[p].closing_row()];
    paths::add(lambda, spike_.data() + first, num_left, y + first);
    paths::add(lambda, spike_.data() + after, num_right, y + after);
  }
  paths::BackSubstitution left{d + first, f + first, y + first, num_left, f[middle], y[middle]};
  paths::BackSubstitution right{d + after, f + after, y + after, num_right, right_factor_[p], y[middle]};
  paths::Upcoming nothing;
  paths::substitute_backward(&left, &right, &nothing);
}

}  // namespace tanor::detail
