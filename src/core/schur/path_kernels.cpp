#include "schur/path_kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/distance.hpp"
#include "base/instruction_sets.hpp"
#include "base/pack.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail::paths {

namespace {

[[gnu::always_inline]] inline double largest_of(const Pack<>& lane) {
  double result = lane[0];
  for (int k = 1; k < 8; ++k) result = std::max(result, lane[k]);
  return result;
}

/// Returns the largest of `so_far` and |x_k|, [count], or NaN if some number is not finite.
template <class Lanes>
[[gnu::always_inline]] inline double find_largest(const double* x, std::size_t count, double so_far) {
  double largest = so_far, nothing = 0.0;  // 0 or NaN
  std::size_t k = 0;
  if (count >= num_lanes) {
    Lanes sizes{}, lost{};
    for (; k + num_lanes <= count; k += num_lanes) {
      const Lanes a = Lanes::at(x + k);
      sizes.include_magnitudes(a);
      lost += a - a;
    }
    largest = sizes.largest(largest);
    nothing = lost.sum();
  }
  for (; k < count; ++k) {
    largest = std::max(largest, std::abs(x[k]));
    nothing += x[k] - x[k];
  }
  return largest + nothing;
}

/// Computes x of the next point minus x of this one, [3 count].
[[gnu::always_inline]] inline void subtract_neighbours(const double* __restrict x, std::size_t count,
                                                       double* __restrict difference) {
  for (std::size_t i = 0; i < 3 * count; ++i) difference[i] = x[i + 3] - x[i];
}

/// Converts signs to numbers, [count].
[[gnu::always_inline]] inline void widen(const signed char* __restrict signs, std::size_t count,
                                         double* __restrict numbers) {
  for (std::size_t k = 0; k < count; ++k) numbers[k] = signs[k];
}

/// Computes a = r_{i+1} - r_i + offset of each rod, [3 count].
[[gnu::always_inline]] inline void subtract_places(const Rods& rods, double* __restrict a) {
  subtract_neighbours(rods.r, rods.count, a);
  if (rods.offset == nullptr) return;
  for (std::size_t i = 0; i < 3 * rods.count; ++i) a[i] += rods.offset[i];
}

/// Evaluates directions, or b, or both.
template <bool WantsDirections, bool WantsRightSide, bool HasField>
[[gnu::always_inline]] inline void evaluate_rods(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks_out,
                                                 double* b_out) {
  std::array<double, 3 * chunk_size> a, v, w;  // NOLINT: filled before use
  std::array<double, chunk_size> sign;         // NOLINT: likewise
  subtract_places(rods, a.data());
  if constexpr (WantsRightSide) subtract_neighbours(rods.v, rods.count, v.data());
  if constexpr (HasField) subtract_neighbours(rods.w0, rods.count, w.data());
  if constexpr (WantsDirections) widen(rods.sign, rods.count, sign.data());
  double* __restrict x = WantsDirections ? chunk->x + slot : nullptr;
  double* __restrict y = WantsDirections ? chunk->y + slot : nullptr;
  double* __restrict z = WantsDirections ? chunk->z + slot : nullptr;
  double* __restrict blocks = blocks_out;
  double* __restrict b = b_out;
  for (std::size_t k = 0; k < rods.count; ++k) {
    const Vec3 distance{a[3 * k], a[3 * k + 1], a[3 * k + 2]};
    const double inverse = 1.0 / std::sqrt(dot(distance, distance));
    const Vec3 g = inverse * distance;
    if constexpr (WantsRightSide) {
      const Vec3 velocity{v[3 * k], v[3 * k + 1], v[3 * k + 2]};
      double right_side = second_derivative_of_distance(g, velocity, inverse);
      if constexpr (HasField) right_side += dot(g, {w[3 * k], w[3 * k + 1], w[3 * k + 2]});
      b[k] = right_side;
    }
    if constexpr (WantsDirections) {
      x[k] = g.x;
      y[k] = g.y;
      z[k] = g.z;
      const double s = sign[k];
      blocks[3 * k] = s * g.x;
      blocks[3 * k + 1] = s * g.y;
      blocks[3 * k + 2] = s * g.z;
    }
  }
}

/// Does one step of the recurrence of determinants.
[[gnu::always_inline]] inline void step(Chunk& chunk, std::size_t k, Determinants& d) {
  const double next = chunk.diagonal[k] * d.last - chunk.coupling[k] * chunk.coupling[k] * d.before;
  chunk.numerator[k] = d.last;
  chunk.denominator[k] = next;
  d.before = d.last;
  d.last = next;
}
[[gnu::always_inline]] inline void scale(Determinants& d) {
  const double factor = 1.0 / d.last;
  d.before *= factor;
  d.last = 1.0;
}

}  // namespace

void evaluate(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks, double* b) {
  dispatch([=, &rods] {
    rods.w0 == nullptr ? evaluate_rods<true, true, false>(rods, slot, chunk, blocks, b)
                       : evaluate_rods<true, true, true>(rods, slot, chunk, blocks, b);
  });
}

void evaluate_directions(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks) {
  dispatch([=, &rods] { evaluate_rods<true, false, false>(rods, slot, chunk, blocks, nullptr); });
}

void evaluate_right_side(const Rods& rods, double* b) {
  dispatch([=, &rods] {
    rods.w0 == nullptr ? evaluate_rods<false, true, false>(rods, 0, nullptr, nullptr, b)
                       : evaluate_rods<false, true, true>(rods, 0, nullptr, nullptr, b);
  });
}

double evaluate_values(const Rods& rods, const double* __restrict lengths, double* __restrict xi) {
  return dispatch([=, &rods]<class Lanes>(std::type_identity<Lanes>) {
    std::array<double, 3 * chunk_size> a;   // NOLINT: filled before use
    std::array<double, chunk_size> ratios;  // NOLINT: likewise
    subtract_places(rods, a.data());
    for (std::size_t k = 0; k < rods.count; ++k) {
      const double x = a[3 * k], y = a[3 * k + 1], z = a[3 * k + 2];
      xi[k] = std::sqrt(x * x + y * y + z * z) - lengths[k];
      ratios[k] = xi[k] / lengths[k];
    }
    return find_largest<Lanes>(ratios.data(), rods.count, 0.0);
  });
}

double evaluate_rates(const Rods& rods, double* __restrict rates) {
  return dispatch([=, &rods]<class Lanes>(std::type_identity<Lanes>) {
    std::array<double, 3 * chunk_size> a, v;  // NOLINT: filled before use
    subtract_places(rods, a.data());
    subtract_neighbours(rods.v, rods.count, v.data());
    for (std::size_t k = 0; k < rods.count; ++k) {
      const Vec3 distance{a[3 * k], a[3 * k + 1], a[3 * k + 2]}, velocity{v[3 * k], v[3 * k + 1], v[3 * k + 2]};
      rates[k] = dot(distance, velocity) / std::sqrt(dot(distance, distance));
    }
    return find_largest<Lanes>(rates, rods.count, 0.0);
  });
}

void load_directions(const double* __restrict blocks, const signed char* signs, Chunk* chunk) {
  dispatch([=] {
    std::array<double, chunk_size> sign;  // NOLINT: filled before use
    widen(signs, chunk->count, sign.data());
    double* __restrict x = chunk->x + 1;
    double* __restrict y = chunk->y + 1;
    double* __restrict z = chunk->z + 1;
    for (std::size_t k = 0; k < chunk->count; ++k) {
      const double s = sign[k];
      x[k] = s * blocks[3 * k];
      y[k] = s * blocks[3 * k + 1];
      z[k] = s * blocks[3 * k + 2];
    }
  });
}

void assemble(Towards towards, Chunk* chunk) {
  dispatch([=] {
    // S_aa = g_a.g_a (1/m + 1/m') with g as it was rounded, and S_ab = -g_a.g_b/m of the point between.
    const std::size_t beside = towards == Towards::Right ? 0 : 2, shared = towards == Towards::Right ? 0 : 1;
    const double* const w = chunk->inverse_mass;
    for (std::size_t k = 0; k < chunk->count; ++k) {
      const double x = chunk->x[k + 1], y = chunk->y[k + 1], z = chunk->z[k + 1];
      const double cosine = x * chunk->x[k + beside] + y * chunk->y[k + beside] + z * chunk->z[k + beside];
      chunk->diagonal[k] = (w[k] + w[k + 1]) * (x * x + y * y + z * z);
      chunk->coupling[k] = -w[k + shared] * cosine;
    }
  });
}

void find_pivots(Chunk* right, Determinants* to_right, Chunk* left, Determinants* to_left, Upcoming* upcoming) {
  dispatch([=] {
    constexpr std::size_t group = 8;
    Determinants d = *to_right, e = *to_left;
    const std::size_t last = left->count - 1, common = std::min(right->count, left->count) / group * group;
    for (std::size_t begin = 0; begin < common; begin += group) {
      for (std::size_t k = begin; k < begin + group; ++k) {
        step(*right, k, d);
        step(*left, last - k, e);
        upcoming->fetch();
      }
      scale(d);
      scale(e);
    }
    for (std::size_t k = common; k < right->count; ++k) {
      step(*right, k, d);
      upcoming->fetch();
      if (k % group == group - 1) scale(d);
    }
    for (std::size_t k = common; k < left->count; ++k) {
      step(*left, last - k, e);
      upcoming->fetch();
      if (k % group == group - 1) scale(e);
    }
    *to_right = d;
    *to_left = e;
  });
}

void finish_pivots(Towards towards, Chunk* chunk, double* __restrict inverse_pivots, double* __restrict factors,
                   PivotRange* range) {
  dispatch([=] {
    const std::size_t count = chunk->count;
    double* const own = chunk->inverse_pivot + 1;
    for (std::size_t k = 0; k < count; ++k) own[k] = chunk->numerator[k] / chunk->denominator[k];
    const double* const before = towards == Towards::Right ? own - 1 : own + 1;
    for (std::size_t k = 0; k < count; ++k) {
      inverse_pivots[k] = own[k];
      factors[k] = chunk->coupling[k] * before[k];
    }
    Pack<> smallest = range->smallest - Pack<>{}, largest = range->largest - Pack<>{};
    std::size_t k = 0;
    for (; k + 8 <= count; k += 8) {
      const Pack<> ratio = pack_at(own + k) * pack_at(chunk->diagonal + k);
      smallest = ratio < smallest ? ratio : smallest;
      largest = ratio > largest ? ratio : largest;
    }
    for (; k < count; ++k) {
      const double ratio = own[k] * chunk->diagonal[k];
      smallest[0] = std::min(smallest[0], ratio);
      largest[0] = std::max(largest[0], ratio);
    }
    range->smallest = -largest_of(-smallest);
    range->largest = largest_of(largest);
  });
}

void substitute_forward(Substitution* right, Substitution* left) {
  dispatch([=] {
    const std::size_t common = std::min(right->count, left->count), end = left->count - 1;
    double last = right->last, other = left->last;
    const auto step_right = [&](std::size_t k) __attribute__((always_inline)) {
      right->y[k] = last = right->b[k] - right->factors[k] * last;
    };
    const auto step_left = [&](std::size_t k) __attribute__((always_inline)) {
      left->y[k] = other = left->b[k] - left->factors[k] * other;
    };
    for (std::size_t k = 0; k < common; ++k) {
      step_right(k);
      step_left(end - k);
    }
    for (std::size_t k = common; k < right->count; ++k) step_right(k);
    for (std::size_t k = common; k < left->count; ++k) step_left(end - k);
    right->last = last;
    left->last = other;
  });
}

void substitute_backward(BackSubstitution* left, BackSubstitution* right, Upcoming* upcoming) {
  dispatch([=] {
    const std::size_t common = std::min(right->count, left->count), end = left->count - 1;
    double last = left->last, factor = left->factor, other = right->last, other_factor = right->factor;
    const auto step_left = [&](std::size_t k) __attribute__((always_inline)) {
      left->lambda[k] = last = -left->lambda[k] * left->inverse_pivots[k] - factor * last;
      factor = left->factors[k];
    };
    const auto step_right = [&](std::size_t k) __attribute__((always_inline)) {
      right->lambda[k] = other = -right->lambda[k] * right->inverse_pivots[k] - other_factor * other;
      other_factor = right->factors[k];
    };
    for (std::size_t k = 0; k < common; ++k) {
      step_left(end - k);
      step_right(k);
      upcoming->fetch();
    }
    for (std::size_t k = common; k < left->count; ++k) {
      step_left(end - k);
      upcoming->fetch();
    }
    for (std::size_t k = common; k < right->count; ++k) {
      step_right(k);
      upcoming->fetch();
    }
    left->last = last;
    left->factor = factor;
    right->last = other;
    right->factor = other_factor;
  });
}

namespace {

/// Does what `accelerate` does point by point, since a few points fill few lanes. A path is always cut into the same
/// chunks, so that its bits do not depend on who cuts it.
Ends accelerate_few(const Between& of, double* residual) {
  const auto direction = [&](std::size_t k) { return static_cast<double>(of.sign[k]) * load(of.blocks, k); };
  Ends ends{};
  Vec3 g = direction(0);
  for (std::size_t k = 0; k < of.count; ++k) {
    const Vec3 next = direction(k + 1), dw = of.inverse_mass[k] * (of.lambda[k] * g - of.lambda[k + 1] * next);
    store(of.w, k, (of.uniform != nullptr ? *of.uniform : load(of.w, k)) + dw);
    if (k == 0) ends.first = dw;
    if (k > 0 && of.b != nullptr) *residual = larger(*residual, std::abs(dot(g, dw - ends.last) + of.b[k]));
    ends.last = dw;
    g = next;
  }
  return ends;
}

}  // namespace

Ends accelerate(const Between& between, double* residual) {
  if (between.count < plan::fewest_points_in_lanes) return accelerate_few(between, residual);
  return dispatch([=, &between]<class Lanes>(std::type_identity<Lanes>) -> Ends {
    constexpr std::size_t size = chunk_size + 1;
    std::array<double, size> gx, gy, gz, dx, dy, dz, rest;  // NOLINT: filled before use
    const std::size_t count = between.count;
    if (count == 0) return {};  // without this, gcc warns of dx[0]
    const double* __restrict blocks = between.blocks;
    const double* __restrict lambda = between.lambda;
    const double* __restrict inverse_mass = between.inverse_mass;
    const double* __restrict b = between.b;
    std::array<double, size> sign;  // NOLINT: likewise
    widen(between.sign, count + 1, sign.data());
    double* __restrict w = between.w;
    for (std::size_t k = 0; k <= count; ++k) {
      const double s = sign[k];
      gx[k] = s * blocks[3 * k];
      gy[k] = s * blocks[3 * k + 1];
      gz[k] = s * blocks[3 * k + 2];
    }
    // dw = (g_k lambda_k - g_{k+1} lambda_{k+1})/m
    for (std::size_t k = 0; k < count; ++k) {
      const double m = inverse_mass[k], here = lambda[k], next = lambda[k + 1];
      dx[k] = m * (here * gx[k] - next * gx[k + 1]);
      dy[k] = m * (here * gy[k] - next * gy[k + 1]);
      dz[k] = m * (here * gz[k] - next * gz[k + 1]);
    }
    if (between.uniform != nullptr) {
      const Vec3 w0 = *between.uniform;
      for (std::size_t k = 0; k < count; ++k) {
        w[3 * k] = w0.x + dx[k];
        w[3 * k + 1] = w0.y + dy[k];
        w[3 * k + 2] = w0.z + dz[k];
      }
    } else {
      for (std::size_t k = 0; k < count; ++k) {
        w[3 * k] += dx[k];
        w[3 * k + 1] += dy[k];
        w[3 * k + 2] += dz[k];
      }
    }
    const Ends ends{{dx[0], dy[0], dz[0]}, {dx[count - 1], dy[count - 1], dz[count - 1]}};
    if (b == nullptr) return ends;
    // K'dw + b
    for (std::size_t k = 1; k < count; ++k) {
      rest[k - 1] = gx[k] * (dx[k] - dx[k - 1]) + gy[k] * (dy[k] - dy[k - 1]) + gz[k] * (dz[k] - dz[k - 1]) + b[k];
    }
    *residual = find_largest<Lanes>(rest.data(), count - 1, *residual);
    return ends;
  });
}

double sum_of_products(const double* x, const double* y, const double* d, std::size_t count) {
  return dispatch([=] {
    Pack<> sums{};
    std::size_t k = 0;
    for (; k + 8 <= count; k += 8) {
      sums += pack_at(x + k) * pack_at(y + k) * pack_at(d + k);
    }
    double sum = 0.0;
    for (; k < count; ++k) sum += x[k] * y[k] * d[k];
    for (int s = 0; s < 8; ++s) sum += sums[s];
    return sum;
  });
}

void add(double factor, const double* __restrict x, std::size_t count, double* __restrict y) {
  dispatch([=] {
    for (std::size_t k = 0; k < count; ++k) y[k] += factor * x[k];
  });
}

double largest_magnitude(const double* x, std::size_t count, double so_far) {
  return dispatch([=]<class Lanes>(std::type_identity<Lanes>) { return find_largest<Lanes>(x, count, so_far); });
}

}  // namespace tanor::detail::paths
