#include "factor/reflection_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"
#include "factor/front_lanes.hpp"

namespace tanor::detail::kernels {

namespace {

static_assert(rows_read_beyond == num_lanes);

constexpr std::size_t most = 4;  // reflections applied at once

/// A product of reflections H_0 H_1 … = 1 - V T V' with T upper triangular.
struct Block {
  std::size_t count = 0, length = 0, stride = 0;  // length: in whole lanes
  double* v = nullptr;                            // [count][stride]
  double t[most][most] = {};

  double* reflector(std::size_t k) const { return v + k * stride; }
};

template <class Lanes>
[[gnu::always_inline]] inline double dot(std::size_t length, const double* a, const double* b) {
  Lanes sum{};
  for (std::size_t i = 0; i < length; i += num_lanes) sum += Lanes::at(a + i) * Lanes::at(b + i);
  return sum.sum();
}

/// Computes x := (1 - V T' V') x.
template <class Lanes, std::size_t count>
[[gnu::always_inline]] inline void apply(const Block& block, double* x) {
  Lanes sum[count]{};
  for (std::size_t i = 0; i < block.length; i += num_lanes) {
    const Lanes x_i = Lanes::at(x + i);
    for (std::size_t k = 0; k < count; ++k) sum[k] += Lanes::at(block.v + k * block.stride + i) * x_i;
  }
  double y[count], z[count];
  for (std::size_t k = 0; k < count; ++k) {
    y[k] = sum[k].sum();
    z[k] = 0.0;
    for (std::size_t l = 0; l <= k; ++l) z[k] += block.t[l][k] * y[l];
  }
  for (std::size_t i = 0; i < block.length; i += num_lanes) {
    Lanes x_i = Lanes::at(x + i);
    for (std::size_t k = 0; k < count; ++k) x_i -= z[k] * Lanes::at(block.v + k * block.stride + i);
    x_i.write(x + i);
  }
}

/// Swaps the row with the largest number of column c into row `first` + `at`, also in the reflections of the block.
/// Rows of very different sizes, as of points without mass, keep their own digits so (M. J. D. Powell, J. K. Reid
/// 1969).
inline void pivot_rows(const RowFront& front, std::size_t first, std::size_t at, std::size_t c, const Block& block) {
  const double* const x = front.values + c * front.stride;
  std::size_t largest = first + at;
  for (std::size_t i = largest + 1; i < front.height[c]; ++i)
    if (std::abs(x[i]) > std::abs(x[largest])) largest = i;
  if (largest == first + at) return;
  for (std::size_t k = c; k < front.columns; ++k) {
    double* const column = front.values + k * front.stride;
    std::swap(column[first + at], column[largest]);
  }
  for (std::size_t k = 0; k < block.count; ++k) std::swap(block.reflector(k)[at], block.reflector(k)[largest - first]);
}

/// Appends the reflection that takes x[at …] into x[at], unless x is no longer than the tolerance there.
template <class Lanes>
[[gnu::always_inline]] inline bool append_reflection(std::size_t at, double tolerance, double* x, Block* block) {
  double* const v = block->reflector(block->count);
  std::fill_n(v, at, 0.0);
  std::copy(x + at, x + block->length, v + at);
  const double length = std::sqrt(dot<Lanes>(block->length, v, v));
  if (!(length > tolerance)) return false;
  // H = 1 - tau v v', v = (1, x_2/u, …), u = x_1 + sign(x_1) length, tau = u/(sign(x_1) length);
  // H x = -sign(x_1) length e_1
  const double signed_length = std::copysign(length, x[at]), u = x[at] + signed_length, inverse = 1.0 / u;
  for (std::size_t i = at / num_lanes * num_lanes; i < block->length; i += num_lanes)
    (inverse * Lanes::at(v + i)).write(v + i);
  v[at] = 1.0;
  std::fill(x + at, x + block->length, 0.0);
  x[at] = -signed_length;
  // The next column of T is -tau T V'v, tau.
  const std::size_t k = block->count;
  const double tau = u / signed_length;
  double y[most];
  for (std::size_t l = 0; l < k; ++l) y[l] = -tau * dot<Lanes>(block->length, block->reflector(l), v);
  for (std::size_t l = 0; l < k; ++l) {
    double sum = 0.0;
    for (std::size_t p = l; p < most && p < k; ++p) sum += block->t[l][p] * y[p];
    block->t[l][k] = sum;
  }
  block->t[k][k] = tau;
  ++block->count;
  return true;
}

}  // namespace

std::size_t reduce_rows(const RowFront& front, std::size_t own, double tolerance, double* scratch, int* row_at) {
  return dispatch([=, &front]<class Lanes>(std::type_identity<Lanes>) {
    std::size_t end = 0;  // rows that are done
    Block block{.stride = front.stride, .v = scratch};
    for (std::size_t c = 0; c < front.columns;) {
      const std::size_t first = end, last = std::min(c + most, front.columns);
      block.count = 0;
      block.length = (front.height[last - 1] - first + num_lanes - 1) / num_lanes * num_lanes;
      const auto apply_to = [&](std::size_t from, std::size_t to) __attribute__((always_inline)) {
        if (block.count == 0) return;
        with_columns<most>(
            block.count, [&](auto count) __attribute__((always_inline)) {
              for (std::size_t k = from; k < to; ++k)
                apply<Lanes, count>(block, front.values + k * front.stride + first);
            });
      };
      for (; c < last; ++c) {
        apply_to(c, c + 1);
        if (end < front.height[c]) pivot_rows(front, first, end - first, c, block);
        const bool begins =
            end < front.height[c] && append_reflection<Lanes>(end - first, c < own ? tolerance : 0.0,
                                                              front.values + c * front.stride + first, &block);
        row_at[c] = begins ? static_cast<int>(end++) : -1;
      }
      apply_to(last, front.columns);
    }
    return end;
  });
}

}  // namespace tanor::detail::kernels
