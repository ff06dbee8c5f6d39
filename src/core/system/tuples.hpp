#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

/// The results of a user's kernel for some members that follow one another.
struct TupleValues {
  std::size_t first, count;
  std::size_t size;          ///< 3p
  const double* xi;          ///< [count]
  const double *rate, *phi;  ///< [count]; null without velocities
  const double* gradient;    ///< [count][3p]
};

/// Evaluates members [first, last) of a user's constraint in chunks: gathers, calls the kernel, and hands its results
/// to use(TupleValues). `points` are [member][p]; `v` may be null. Allocates nothing.
template <bool WithGradients = true, class Use>
void for_each_chunk(const ConstraintKernel& kernel, std::span<const Index> points, std::size_t first, std::size_t last,
                    double t, const double* r, const double* v, const Use& use) {
  // The chunk is large enough that the call costs nothing, and small enough for the first cache.
  constexpr std::size_t usual_chunk = 64, room = 3 * ConstraintKernel::most_points * 2;
  const std::size_t p = static_cast<std::size_t>(kernel.num_points), size = 3 * p;
  const std::size_t chunk = std::min(usual_chunk, room / size);
  std::array<double, room> r_chunk, v_chunk, gradient;  // NOLINT: filled before use
  std::array<double, usual_chunk> xi, rate, phi;        // NOLINT
  for (std::size_t begin = first; begin < last; begin += chunk) {
    const std::size_t count = std::min(chunk, last - begin);
    for (std::size_t i = 0; i < count * p; ++i) {
      store(r_chunk.data(), i, load(r, points[begin * p + i]));
      if (v != nullptr) store(v_chunk.data(), i, load(v, points[begin * p + i]));
    }
    const ConstraintBatch batch{count,
                                t,
                                r_chunk.data(),
                                v_chunk.data(),
                                xi.data(),
                                v != nullptr ? rate.data() : nullptr,
                                v != nullptr ? phi.data() : nullptr,
                                WithGradients ? gradient.data() : nullptr};
    kernel.evaluate(kernel.context.get(), batch);
    use(TupleValues{begin, count, size, xi.data(), batch.rate, batch.phi, batch.gradient});
  }
}

/// Returns the largest length of a point's block, by which the gradient's length is measured; NaN if any is NaN.
inline double largest_block(const double* gradient, std::size_t size) {
  double square = 0.0;
  for (std::size_t i = 0; i < size; i += 3) {
    const Vec3 block = load(gradient, i / 3);
    square = larger(square, dot(block, block));
  }
  return std::sqrt(square);
}

}  // namespace tanor::detail
