#include "schur/path_equations.hpp"

#include <algorithm>
#include <array>

namespace tanor::detail {

Vec3 PathEquations::direction(const RodPath& path, std::size_t row) const {
  if (motion == nullptr) return rows.direction(given_blocks, row);
  const Vec3 a = rows.distance(path, row, motion->r);
  return (1.0 / norm(a)) * a;
}

Vec3 PathEquations::evaluate_row(const RodPath& path, std::size_t row) const {
  const Vec3 g = direction(path, row);
  if (motion == nullptr) return g;
  if (b != nullptr) b[row] = rows.right_side(path, row, *motion);
  store(blocks, rows.block(row), rows.sign[row] * g);
  return g;
}

void PathEquations::take_rows(const RodPath& path, paths::Half* half) const {
  paths::Chunk& chunk = half->chunk;
  const std::size_t first = half->first, count = chunk.count, end = first + count;
  const bool from_support = path.begins_at_support(first), to_support = path.ends_at_support(end - 1);
  const std::size_t points_begin = from_support ? 1 : 0, points_end = to_support ? count : count + 1;
  const double* const masses = rows.inverse_mass.data() + path.left_point(first + points_begin);
  chunk.inverse_mass[0] = chunk.inverse_mass[count] = 0.0;
  std::copy_n(masses, points_end - points_begin, chunk.inverse_mass + points_begin);

  std::array<double, 3 * paths::chunk_size> scattered;  // NOLINT: filled before use
  if (motion == nullptr) {
    const double* from = given_blocks + 3 * (rows.first_block + first);
    if (!rows.blocks_follow_rows()) {
      for (std::size_t k = 0; k < count; ++k)
        store(scattered.data(), k, load(given_blocks, rows.block_numbers[first + k]));
      from = scattered.data();
    }
    paths::load_directions(from, &rows.sign[first], &chunk);
  } else {
    // Rods between moving points are evaluated side by side, those to supports one by one.
    const std::size_t begin = first + (from_support ? 1 : 0), rods_end = end - (to_support ? 1 : 0);
    const FreeMotion& at = *motion;
    double* const own_blocks = rows.blocks_follow_rows() ? blocks + 3 * (rows.first_block + begin) : scattered.data();
    if (begin < rods_end) {
      const paths::Rods rods = rows.rods_between(path, begin, rods_end, at);
      const std::size_t slot = 1 + begin - first;
      if (b == nullptr) {
        paths::evaluate_directions(rods, slot, &chunk, own_blocks);
      } else {
        paths::evaluate(rods, slot, &chunk, own_blocks, b + begin);
        rows.subtract_moving(begin, rods_end, &MovingScalar::second, b + begin);
      }
    }
    for (std::size_t k = begin; k < rods_end && !rows.blocks_follow_rows(); ++k)
      store(blocks, rows.block_numbers[k], load(scattered.data(), k - begin));
    if (from_support) chunk.set_direction(1, evaluate_row(path, first));
    if (to_support && begin <= end - 1) chunk.set_direction(count, evaluate_row(path, end - 1));
    if (b != nullptr) half->largest = larger(half->largest, paths::largest_magnitude(b + first, count, half->largest));
  }
  paths::assemble(half->towards, &chunk);
}

void PathEquations::bring_rows(const RodPath& path, const paths::Half& half) const {
  const std::size_t first = half.first, last = first + half.chunk.count - 1;
  const bool with_left = half.is_rightwards() ? first == path.first && !path.begins_at_support(first) : true;
  const bool with_right = half.is_rightwards() ? true : last + 1 == path.end && !path.ends_at_support(last);
  const std::size_t begin = with_left ? path.left_point(first) : path.right_point(first);
  const std::size_t end = (with_right ? path.right_point(last) : path.left_point(last)) + 1;
  source->bring(begin, end - begin);
}

void PathEquations::bring_middle(const RodPath& path, paths::Sides sides) const {
  const std::size_t middle = path.middle();
  if (includes(sides, paths::Sides::Left) && middle == path.first && !path.begins_at_support(middle))
    source->bring(path.left_point(middle), 1);
  if (includes(sides, paths::Sides::Right) && middle + 1 == path.end && !path.ends_at_support(middle))
    source->bring(path.right_point(middle), 1);
}

}  // namespace tanor::detail
