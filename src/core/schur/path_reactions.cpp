#include "schur/path_reactions.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tanor::detail {

paths::Ends PathReactions::accelerate(const RodPath& path, std::size_t first, std::size_t count,
                                      double* residual) const {
  std::array<double, 3 * (paths::chunk_size + 1)> scattered;  // NOLINT: filled before use
  const double* own_blocks = blocks + 3 * (rows.first_block + first);
  if (!rows.blocks_follow_rows()) {
    for (std::size_t k = 0; k <= count; ++k) store(scattered.data(), k, load(blocks, rows.block_numbers[first + k]));
    own_blocks = scattered.data();
  }
  const std::size_t point = path.right_point(first);
  return paths::accelerate({.blocks = own_blocks,
                            .lambda = lambda + first,
                            .b = b != nullptr ? b + first : nullptr,
                            .inverse_mass = rows.inverse_mass.data() + point,
                            .sign = &rows.sign[first],
                            .count = count,
                            .uniform = uniform,
                            .w = w + 3 * point},
                           residual);
}

Vec3 PathReactions::accelerate_end(const RodPath& path, std::size_t row, std::size_t point, double sense) const {
  const auto tension = [&](std::size_t of) { return lambda[of] * rows.direction(blocks, of); };
  const Vec3 force = path.is_ring ? tension(row) - tension(path.closing_row()) : tension(row);
  const Vec3 dw = (sense * rows.inverse_mass[point]) * force;
  store(w, point, (uniform != nullptr ? *uniform : load(w, point)) + dw);
  return dw;
}

paths::Accelerated PathReactions::accelerate_outermost(const RodPath& path, paths::Sides half, std::size_t row,
                                                       Vec3 dw_next, paths::Accelerated found) const {
  const bool is_left = half == paths::Sides::Left;
  const std::size_t point = is_left ? path.left_point(row) : path.right_point(row);
  const bool is_held = is_left ? path.begins_at_support(row) : path.ends_at_support(row);
  found.end_dw = is_held ? Vec3{} : accelerate_end(path, row, point, is_left ? -1.0 : 1.0);
  if (row == path.middle()) {
    found.dw = found.end_dw;
  } else {
    const double rest = is_left ? residual_of(row, found.end_dw, dw_next) : residual_of(row, dw_next, found.end_dw);
    found.residual = larger(found.residual, rest);
  }
  return found;
}

void PathReactions::accelerate_all(const Parallel& parallel, const RodPath& path) const {
  // A chunk begins at the same row for any number of threads, so that the bits are the same.
  const std::size_t num_between = path.end - 1 - path.first;  // points between two rows
  const auto accelerate_chunks = [&](std::size_t begin, std::size_t end) {
    double nothing = 0.0;
    for (std::size_t k = begin * paths::chunk_size; k < std::min(end * paths::chunk_size, num_between);
         k += paths::chunk_size)
      (void)accelerate(path, path.first + k, std::min(paths::chunk_size, num_between - k), &nothing);
  };
  parallel.for_ranges((num_between + paths::chunk_size - 1) / paths::chunk_size, accelerate_chunks,
                      plan::rows_of_batches_worth_a_thread / paths::chunk_size);
  if (path.left_support < 0) (void)accelerate_end(path, path.first, path.left_point(path.first), -1.0);
  if (path.right_support < 0) (void)accelerate_end(path, path.end - 1, path.right_point(path.end - 1), 1.0);
}

double PathReactions::residual_of(std::size_t row, Vec3 dw_left, Vec3 dw_right) const {
  if (b == nullptr) return 0.0;
  return std::abs(dot(rows.direction(blocks, row), dw_right - dw_left) + b[row]);
}

void PathReactions::include_residual(const RodPath& path, paths::PathWork* work) const {
  double& residual = work->findings.residual;
  residual = larger(larger(work->left.residual, work->right.residual),
                    residual_of(path.middle(), work->left.dw, work->right.dw));
  if (path.is_ring) residual = larger(residual, residual_of(path.closing_row(), work->right.end_dw, work->left.end_dw));
  work->findings.own_residual = own_residual(residual, work->findings.right_side);
}

}  // namespace tanor::detail
