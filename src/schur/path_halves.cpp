#include <algorithm>
#include <cmath>

#include "plan/thresholds.hpp"

#include "schur/path_half.hpp"

/// \file The two passes of PathSolver over the halves of one path, some rods at a time: what a chunk needs lies in the
/// first cache from its evaluation to its last number.
namespace tanor {

using paths::chunk_size, paths::Towards;

/// What the elimination of rows [first, first + count) will read and write.
void PathSolver::announce(const Path& path, const Numbers& numbers, std::size_t first, std::size_t count,
                          paths::Upcoming* upcoming) const {
  if (count == 0 || sign_.size() < plan::rows_beyond_cache) return;
  constexpr std::size_t number = sizeof(double), vector = 3 * number;
  const std::size_t point = path.right_point(first);
  upcoming->add(&inverse_mass_[point], number * (count - 1));
  if (numbers.motion != nullptr) upcoming->add(numbers.motion->r + 3 * point, vector * (count - 1));
  if (numbers.b != nullptr) {
    upcoming->add(numbers.motion->v + 3 * point, vector * (count - 1));
    upcoming->add(numbers.b + first, number * count);
    upcoming->add(numbers.y + first, number * count);
  }
  if (block_.empty()) upcoming->add(numbers.given_blocks + 3 * (first_block_ + first), vector * count);
  upcoming->add(&inverse_pivot_[first], number * count);
  upcoming->add(&factor_[first], number * count);
  if (path.is_ring) upcoming->add(&spike_[first], number * count);
}

/// Likewise of the way back.
void PathSolver::announce(const Path& path, const Substituted& numbers, std::size_t first, std::size_t count,
                          paths::Upcoming* upcoming) const {
  if (count == 0 || sign_.size() < plan::rows_beyond_cache) return;
  constexpr std::size_t number = sizeof(double), vector = 3 * number;
  const std::size_t point = path.right_point(first);
  upcoming->add(numbers.lambda + first, number * count);
  upcoming->add(&inverse_pivot_[first], number * count);
  upcoming->add(&factor_[first], number * count);
  if (path.is_ring) upcoming->add(&spike_[first], number * count);
  if (block_.empty()) upcoming->add(numbers.blocks + 3 * (first_block_ + first), vector * count);
  if (numbers.b != nullptr) upcoming->add(numbers.b + first, number * count);
  upcoming->add(&inverse_mass_[point], number * (count - 1));
  upcoming->add(numbers.w + 3 * point, vector * (count - 1));
}

void PathSolver::eliminate_halves(const Path& path, const Numbers& numbers, Halves halves, Work* work) {
  const std::size_t middle = path.middle();
  Half left(Towards::Right, path.first, includes(halves, Halves::Left) ? middle - path.first : 0);
  Half right(Towards::Left, path.end, includes(halves, Halves::Right) ? path.end - middle - 1 : 0);
  const PointSource* const source = numbers.source;
  if (source != nullptr) bring_middle(path, *source, halves);
  paths::Upcoming upcoming;
  while (left.rows_left + right.rows_left > 0) {
    for (Half* half : {&left, &right}) {
      half->advance();
      if (half->chunk.count == 0) continue;
      if (source != nullptr) bring_rows(path, *source, *half);
      take_rows(path, numbers, half);
    }
    upcoming.clear();
    for (const Half* half : {&left, &right}) announce(path, numbers, half->next_first(), half->next_count(), &upcoming);
    paths::find_pivots(&left.chunk, &left.determinants, &right.chunk, &right.determinants, &upcoming);
    for (Half* half : {&left, &right}) {
      if (half->chunk.count == 0) continue;
      paths::finish_pivots(half->towards, &half->chunk, &inverse_pivot_[half->first], &factor_[half->first],
                           &half->pivots);
      half->remember_last_row();
    }
    if (numbers.b != nullptr) {
      const auto substitution = [&](const Half& half) {
        return paths::Substitution{numbers.b + half.first, factor_.data() + half.first, numbers.y + half.first,
                                   half.chunk.count, half.end.y};
      };
      paths::Substitution of_left = substitution(left), of_right = substitution(right);
      paths::substitute_inwards(&of_left, &of_right);
      left.end.y = of_left.last;
      right.end.y = of_right.last;
    }
    if (path.is_ring) spread_spikes(path, numbers, &left, &right);
  }
  for (Half* half : {&left, &right}) half->end.range = {half->pivots.smallest, half->pivots.largest, half->largest};
  if (includes(halves, Halves::Left)) work->left_end = left.end;
  if (includes(halves, Halves::Right)) work->right_end = right.end;
}

/// The points of a chunk that those before it have not brought.
void PathSolver::bring_rows(const Path& path, const PointSource& source, const Half& half) {
  const std::size_t first = half.first, last = first + half.chunk.count - 1;
  const bool with_left = half.is_rightwards() ? first == path.first && !path.begins_at_support(first) : true;
  const bool with_right = half.is_rightwards() ? true : last + 1 == path.end && !path.ends_at_support(last);
  const std::size_t begin = with_left ? path.left_point(first) : path.right_point(first);
  const std::size_t end = (with_right ? path.right_point(last) : path.left_point(last)) + 1;
  source.bring(begin, end - begin);
}

/// The ends of a path that is its middle row on that side: no half brings them.
void PathSolver::bring_middle(const Path& path, const PointSource& source, Halves halves) {
  const std::size_t middle = path.middle();
  if (includes(halves, Halves::Left) && middle == path.first && !path.begins_at_support(middle))
    source.bring(path.left_point(middle), 1);
  if (includes(halves, Halves::Right) && middle + 1 == path.end && !path.ends_at_support(middle))
    source.bring(path.right_point(middle), 1);
}

/// Directions, b and S of the next rows.
void PathSolver::take_rows(const Path& path, const Numbers& numbers, Half* half) const {
  paths::Chunk& chunk = half->chunk;
  const std::size_t first = half->first, count = chunk.count, end = first + count;
  const bool from_support = path.begins_at_support(first), to_support = path.ends_at_support(end - 1);
  const std::size_t points_begin = from_support ? 1 : 0, points_end = to_support ? count : count + 1;
  const double* const masses = inverse_mass_.data() + path.left_point(first + points_begin);
  chunk.inverse_mass[0] = chunk.inverse_mass[count] = 0.0;
  std::copy_n(masses, points_end - points_begin, chunk.inverse_mass + points_begin);

  std::array<double, 3 * chunk_size> scattered;  // NOLINT: filled before use
  if (numbers.motion == nullptr) {
    const double* blocks = numbers.given_blocks + 3 * (first_block_ + first);
    if (!block_.empty()) {
      for (std::size_t k = 0; k < count; ++k) store(scattered.data(), k, load(numbers.given_blocks, block_[first + k]));
      blocks = scattered.data();
    }
    paths::load_directions(blocks, &sign_[first], &chunk);
  } else {
    // Rods between moving points side by side, those to supports one by one.
    const std::size_t begin = first + (from_support ? 1 : 0), rods_end = end - (to_support ? 1 : 0);
    const FreeMotion& motion = *numbers.motion;
    double* const blocks = block_.empty() ? numbers.blocks + 3 * (first_block_ + begin) : scattered.data();
    if (begin < rods_end) {
      const paths::Rods rods = rods_between(path, begin, rods_end, motion);
      const std::size_t slot = 1 + begin - first;
      if (numbers.b == nullptr) {
        paths::evaluate_directions(rods, slot, &chunk, blocks);
      } else {
        paths::evaluate(rods, slot, &chunk, blocks, numbers.b + begin);
        subtract_moving(begin, rods_end, &MovingScalar::second, numbers.b + begin);
      }
    }
    for (std::size_t k = begin; k < rods_end && !block_.empty(); ++k)
      store(numbers.blocks, block_[k], load(scattered.data(), k - begin));
    if (from_support) chunk.set_direction(1, evaluate_row(path, first, numbers));
    if (to_support && begin <= end - 1) chunk.set_direction(count, evaluate_row(path, end - 1, numbers));
    if (numbers.b != nullptr)
      half->largest = larger(half->largest, paths::largest_magnitude(numbers.b + first, count, half->largest));
  }
  paths::assemble(half->towards, &chunk);
}

/// d = S_aa - S_ab^2/d_b - S_ac^2/d_c with its neighbours b and c.
void PathSolver::eliminate_middle(std::size_t p, const Numbers& numbers, Work* work) {
  const Eliminated &left = work->left_end, &right = work->right_end;
  const Path& path = paths_[p];
  const std::size_t row = path.middle();
  const Vec3 g = evaluate_row(path, row, numbers);
  const double left_mass = path.begins_at_support(row) ? 0.0 : inverse_mass_[path.left_point(row)];
  const double right_mass = path.ends_at_support(row) ? 0.0 : inverse_mass_[path.right_point(row)];
  const double diagonal = (left_mass + right_mass) * dot(g, g);
  const double to_left = -left_mass * dot(g, left.g), to_right = -right_mass * dot(g, right.g);
  factor_[row] = to_left * left.inverse_pivot;
  right_factor_[p] = to_right * right.inverse_pivot;
  inverse_pivot_[row] = 1.0 / (diagonal - to_left * factor_[row] - to_right * right_factor_[p]);
  const double ratio = diagonal * inverse_pivot_[row];
  Range range{.smallest_ratio = ratio, .largest_ratio = ratio};
  if (numbers.b != nullptr) {
    numbers.y[row] = numbers.b[row] - factor_[row] * left.y - right_factor_[p] * right.y;
    range.right_side = std::abs(numbers.b[row]);
  }
  range.include(left.range);
  range.include(right.range);
  work->range = range;
  if (path.is_ring) eliminate_closing_row(p, numbers, work);
}

/// From the middle outwards: the next rods' lambda, w of the points between them and the rods before, and what K'dw + b
/// leaves over. Row `row` of a path joins the points that dw_left and dw_right belong to.
void PathSolver::substitute_halves(std::size_t p, const Substituted& numbers, double* lambda, Halves halves,
                                   Work* work) const {
  const Path& path = paths_[p];
  const std::size_t middle = path.middle();
  const bool goes_left = includes(halves, Halves::Left), goes_right = includes(halves, Halves::Right);
  const double *const d = inverse_pivot_.data(), *const f = factor_.data();
  const auto rest = [&](std::size_t row, Vec3 dw_left, Vec3 dw_right) {
    return rest_of(numbers, row, dw_left, dw_right);
  };
  paths::BackSubstitution to_left{{}, {}, {}, 0, f[middle], numbers.lambda[middle]};
  paths::BackSubstitution to_right{{}, {}, {}, 0, right_factor_[p], numbers.lambda[middle]};
  Accelerated of_left, of_right;
  Vec3 dw_left{}, dw_right{};                    // of the outermost points so far
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
      paths::add(numbers.lambda[path.closing_row()], spike_.data() + begin, to_left.count, to_left.lambda);
      paths::add(numbers.lambda[path.closing_row()], spike_.data() + end, to_right.count, to_right.lambda);
    }
    const std::size_t after = end + to_right.count, more_left = std::min(begin - first, chunk_size);
    upcoming.clear();
    announce(path, numbers, begin - more_left, more_left, &upcoming);
    announce(path, numbers, after, std::min(last - after, chunk_size), &upcoming);
    paths::substitute_outwards(&to_left, &to_right, &upcoming);
    if (to_left.count > 0) {
      const paths::Ends points = accelerate(path, numbers, begin, to_left.count, &of_left.residual);
      if (before == middle) {
        of_left.dw = points.last;
      } else {
        of_left.residual = larger(of_left.residual, rest(before, points.last, dw_left));
      }
      dw_left = points.first;
    }
    if (to_right.count > 0) {
      const paths::Ends points = accelerate(path, numbers, end - 1, to_right.count, &of_right.residual);
      if (end == middle + 1) {
        of_right.dw = points.first;
      } else {
        of_right.residual = larger(of_right.residual, rest(end - 1, dw_right, points.first));
      }
      dw_right = points.last;
    }
    end += to_right.count;
  }
  if (goes_left) work->left = accelerate_outermost(path, numbers, Halves::Left, first, dw_left, of_left);
  if (goes_right) work->right = accelerate_outermost(path, numbers, Halves::Right, last - 1, dw_right, of_right);
}

/// The outermost point of one of the halves; `dw_next` is that of the point beside it.
PathSolver::Accelerated PathSolver::accelerate_outermost(const Path& path, const Substituted& numbers, Halves half,
                                                         std::size_t row, Vec3 dw_next, Accelerated found) const {
  const bool is_left = half == Halves::Left;
  const std::size_t point = is_left ? path.left_point(row) : path.right_point(row);
  const bool is_held = is_left ? path.begins_at_support(row) : path.ends_at_support(row);
  found.end_dw = is_held ? Vec3{} : accelerate_end(path, numbers, row, point, is_left ? -1.0 : 1.0);
  if (row == path.middle()) {
    found.dw = found.end_dw;
  } else {
    const double rest =
        is_left ? rest_of(numbers, row, found.end_dw, dw_next) : rest_of(numbers, row, dw_next, found.end_dw);
    found.residual = larger(found.residual, rest);
  }
  return found;
}

/// The points between `count` + 1 rows.
paths::Ends PathSolver::accelerate(const Path& path, const Substituted& numbers, std::size_t first, std::size_t count,
                                   double* residual) const {
  std::array<double, 3 * (chunk_size + 1)> scattered;  // NOLINT: filled before use
  const double* blocks = numbers.blocks + 3 * (first_block_ + first);
  if (!block_.empty()) {
    for (std::size_t k = 0; k <= count; ++k) store(scattered.data(), k, load(numbers.blocks, block_[first + k]));
    blocks = scattered.data();
  }
  const std::size_t point = path.right_point(first);
  return paths::accelerate({.blocks = blocks,
                            .lambda = numbers.lambda + first,
                            .b = numbers.b != nullptr ? numbers.b + first : nullptr,
                            .inverse_mass = inverse_mass_.data() + point,
                            .sign = &sign_[first],
                            .count = count,
                            .uniform = numbers.uniform,
                            .w = numbers.w + 3 * point},
                           residual);
}

/// A free end: dw = K lambda/m of its only rod, or of that and the one that closes the ring.
Vec3 PathSolver::accelerate_end(const Path& path, const Substituted& numbers, std::size_t row, std::size_t point,
                                double sense) const {
  const auto tension = [&](std::size_t of) { return numbers.lambda[of] * direction(numbers.blocks, of); };
  const Vec3 force = path.is_ring ? tension(row) - tension(path.closing_row()) : tension(row);
  const Vec3 dw = (sense * inverse_mass_[point]) * force;
  store(numbers.w, point, (numbers.uniform != nullptr ? *numbers.uniform : load(numbers.w, point)) + dw);
  return dw;
}

/// |K'dw + b| of one row.
double PathSolver::rest_of(const Substituted& numbers, std::size_t row, Vec3 dw_left, Vec3 dw_right) const {
  if (numbers.b == nullptr) return 0.0;
  return std::abs(dot(direction(numbers.blocks, row), dw_right - dw_left) + numbers.b[row]);
}

}  // namespace tanor
