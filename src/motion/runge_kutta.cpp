#include "motion/runge_kutta.hpp"

#include <algorithm>
#include <cmath>

#include "base/check.hpp"
#include "base/parallel.hpp"

namespace tanor {

Tableau rk4_tableau() {
  return {.order = 4,
          .c = {0.0, 0.5, 0.5, 1.0},
          .a = {{}, {0.5}, {0.0, 0.5}, {0.0, 0.0, 1.0}},
          .b = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6},
          .e = {}};
}

/// Dormand & Prince 5(4), the seventh stage at the new point (Hairer, Norsett, Wanner I, table II.5.2).
Tableau dopri5_tableau() {
  return {.order = 5,
          .c = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0},
          .a = {{},
                {1.0 / 5},
                {3.0 / 40, 9.0 / 40},
                {44.0 / 45, -56.0 / 15, 32.0 / 9},
                {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656}},
          .b = {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84},
          .e = {71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40}};
}

RungeKutta::RungeKutta(const Tableau& tableau, const MotionOptions& options, Mechanics& mechanics)
    : tableau_(tableau), options_(options), mechanics_(mechanics) {
  const std::size_t stages = tableau_.b.size();
  const auto a = [&](std::size_t i, std::size_t j) { return j < tableau_.a[i].size() ? tableau_.a[i][j] : 0.0; };
  // x_i = x + h c_i v + h^2 sum_j (A^2)_ij a_j, likewise b'A for the step: only accelerations need to be kept.
  for (std::size_t i = 0; i < stages; ++i) {
    std::vector<double> squared(i, 0.0);
    for (std::size_t j = 0; j < i; ++j) {
      for (std::size_t k = j + 1; k < i; ++k) squared[j] += a(i, k) * a(k, j);
    }
    a_squared_.push_back(squared);
  }
  b_a_.assign(stages, 0.0);
  for (std::size_t j = 0; j < stages; ++j) {
    for (std::size_t k = j + 1; k < stages; ++k) b_a_[j] += tableau_.b[k] * a(k, j);
  }
  if (is_adaptive()) {
    // The last stage of the estimate stands at the new point: its row of A is b.
    e_a_.assign(stages, 0.0);
    for (std::size_t j = 0; j < stages; ++j) {
      for (std::size_t k = j + 1; k < stages; ++k) e_a_[j] += tableau_.e[k] * a(k, j);
      e_a_[j] += tableau_.e[stages] * tableau_.b[j];
    }
  }
  const std::size_t n = mechanics_.size();
  for (std::size_t i = 1; i < stages; ++i) accelerations_.emplace_back(n);
  stage_x_.resize(n);
  stage_v_.resize(n);
  zero_.resize(is_adaptive() ? n : 0, 0.0);
}

namespace {

/// y = base + s shift + factor sum_j weights_j terms_j, in pieces that stay in the first cache.
void combine(const Parallel& parallel, std::size_t n, const double* base, double s, const double* shift,
             std::span<const double> weights, double factor, std::span<const double* const> terms, double* y) {
  constexpr std::size_t piece = 512;
  const auto combine_pieces = [&](std::size_t first, std::size_t last) {
    for (std::size_t begin = first * piece; begin < std::min(n, last * piece); begin += piece) {
      const std::size_t end = std::min(n, begin + piece);
      for (std::size_t i = begin; i < end; ++i) y[i] = base[i] + s * shift[i];
      for (std::size_t j = 0; j < weights.size(); ++j) {
        if (weights[j] == 0.0) continue;
        const double weight = factor * weights[j];
        const double* const term = terms[j];
        for (std::size_t i = begin; i < end; ++i) y[i] += weight * term[i];
      }
    }
  };
  parallel.for_ranges((n + piece - 1) / piece, combine_pieces, 16);
}

}  // namespace

StepResult RungeKutta::step(const State& from, double h, State* to) {
  const std::size_t n = from.x.size(), stages = tableau_.b.size();
  std::array<const double*, most_stages + 1> a{from.a.data()};
  for (std::size_t i = 1; i < stages; ++i) a[i] = accelerations_[i - 1].data();
  const auto first = [&](std::size_t count) { return std::span<const double* const>(a.data(), count); };

  const bool has_work = mechanics_.has_work();
  to->work = from.work;
  const auto add_work = [&](std::size_t i, const Power& power) {
    to->work.supports += h * tableau_.b[i] * power.supports;
    to->work.forces += h * tableau_.b[i] * power.forces;
    to->work.friction += h * tableau_.b[i] * power.friction;
  };
  if (has_work) add_work(0, from.power);

  StepResult result;
  for (std::size_t i = 1; i < stages; ++i) {
    const double t = from.t + tableau_.c[i] * h;
    combine(mechanics_.parallel(), n, from.x.data(), h * tableau_.c[i], from.v.data(), a_squared_[i], h * h, first(i),
            stage_x_.data());
    combine(mechanics_.parallel(), n, from.v.data(), 0.0, from.v.data(), tableau_.a[i], h, first(i), stage_v_.data());
    mechanics_.prescribe(t, stage_x_.data(), stage_v_.data());
    result.outcome = mechanics_.accelerations(t, stage_x_.data(), stage_v_.data(), Gradients::Evaluate,
                                              accelerations_[i - 1].data());
    if (!result.outcome.ok()) return result;
    if (has_work) add_work(i, mechanics_.power(stage_x_.data(), stage_v_.data()));
  }
  combine(mechanics_.parallel(), n, from.x.data(), h, from.v.data(), b_a_, h * h, first(stages), to->x.data());
  combine(mechanics_.parallel(), n, from.v.data(), 0.0, from.v.data(), tableau_.b, h, first(stages), to->v.data());
  result = settle(mechanics_, options_.stabilisation, to);
  if (result.outcome.ok() && is_adaptive()) {
    a[stages] = to->a.data();
    result.error = estimate_error(from, h, *to, first(stages + 1));
  }
  return result;
}

/// Over the tolerance, as the mechanics measures it. The stages' workspaces are free again.
double RungeKutta::estimate_error(const State& from, double h, const State& to, std::span<const double* const> a) {
  const std::size_t n = from.x.size();
  const Parallel& parallel = mechanics_.parallel();
  combine(parallel, n, zero_.data(), 0.0, zero_.data(), e_a_, h * h, a, stage_x_.data());
  combine(parallel, n, zero_.data(), 0.0, zero_.data(), tableau_.e, h, a, stage_v_.data());
  return mechanics_.error_ratio(
      from.t, {stage_x_.data(), stage_v_.data(), from.x.data(), from.v.data(), to.x.data(), to.v.data()}, options_.atol,
      options_.rtol);
}

}  // namespace tanor
