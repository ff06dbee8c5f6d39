#pragma once

#include <cstddef>

#include "base/pack.hpp"

namespace tanor::detail {

/// The power series of rods in lanes. With a = r_j - r_i and the force mu a = lambda a/|a_0| on the end j, order k
/// needs products of the lower coefficients alone; see GroupSeries.
template <std::size_t lanes>
struct RodSeries {
  using Lane = Pack<lanes>;
  using Vector = Pack3<lanes>;

  struct Coefficient {
    Vector a;
    Lane mu;
  };
  struct Known {
    Vector force;      // sum of a_j mu_{k-j}
    Lane half_square;  // half the known part of a.a
  };
  /// Returns the known terms of order k: the sum over j = 1 … k of a_j mu_{k-j}, and half the coefficient k + 2 of a.a
  /// without a_{k+2}. If k is odd, it also finds those of order k + 1, but for a_1 mu_k and a_1.a_{k+2}, so that the
  /// series are read only every second time; `kept` has them until then.
  [[gnu::always_inline]] static Known multiply(const Coefficient* series, int k, Known* kept) {
    const auto c = [=](int j) __attribute__((always_inline))->const Coefficient& {
      return series[static_cast<std::size_t>(j)];
    };
    if (k % 2 == 0) {
      const Vector a = c(1).a;
      return {kept->force + c(k - 1).mu * a, kept->half_square + dot(a, c(k + 1).a)};
    }
    // Each product of two a is formed once. The newest coefficients come last, since otherwise all would wait for them.
    const int middle = (k + 1) / 2;
    Known now{}, next{};
    Vector now_squares{}, next_squares{};
    Lane mu = c(0).mu;
    int j = k;
    for (; j > middle; --j) {
      const Lane next_mu = c(k + 1 - j).mu;
      now.force = now.force + mu * c(j).a;
      next.force = next.force + next_mu * c(j).a;
      mu = next_mu;
    }
    Vector b = c(middle + 1).a;
    next_squares = (Lane{} + 0.5) * (b * b);
    for (; j > 1; --j) {
      const Vector a = c(j).a, next_b = c(k + 3 - j).a;
      const Lane next_mu = c(k + 1 - j).mu;
      now_squares = now_squares + a * b;
      next_squares = next_squares + a * next_b;
      now.force = now.force + mu * a;
      next.force = next.force + next_mu * a;
      b = next_b;
      mu = next_mu;
    }
    const Vector newest = c(k + 1).a;
    *kept = {next.force + c(0).mu * newest, next_squares.sum()};
    return {now.force + mu * c(1).a, (now_squares + c(1).a * newest).sum()};
  }
};

}  // namespace tanor::detail
