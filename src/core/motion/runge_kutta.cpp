#include "motion/runge_kutta.hpp"

#include <algorithm>
#include <cmath>

#include "base/check.hpp"
#include "base/parallel.hpp"

namespace tanor::detail {

Tableau rk4_tableau() {
  return {.order = 4,
          .c = {0.0, 0.5, 0.5, 1.0},
          .a = {{}, {0.5}, {0.0, 0.5}, {0.0, 0.0, 1.0}},
          .b = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6},
          .e = {},
          .e3 = {},
          .dense = {}};
}

/// Dormand & Prince 5(4) with the seventh stage at the new point (Hairer, Norsett, Wanner I, table II.5.2).
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
          .e = {71.0 / 57600, 0.0, -71.0 / 16695, 71.0 / 1920, -17253.0 / 339200, 22.0 / 525, -1.0 / 40},
          .e3 = {},
          .dense = {}};
}

namespace {

/// Computes y = base + s shift + factor sum_j weights_j terms_j, in pieces that stay in the first-level cache.
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

RungeKutta::RungeKutta(const Tableau& tableau, const IntegrationOptions& options, Mechanics& mechanics)
    : tableau_(tableau), options_(options), mechanics_(mechanics) {
  for (const std::vector<double>& row : tableau_.a) rows_.push_back(weigh(row));
  rows_.push_back(weigh(tableau_.b));
  for (const std::vector<double>& row : tableau_.dense.a) rows_.push_back(weigh(row));
  // Stages round independently, each by a little less than a sample shows, which gives 4/5 |b| in the Euclidean norm.
  for (const double b : tableau_.b) rounding_gain_ = std::hypot(rounding_gain_, 0.8 * b);
  estimate_ = weigh(tableau_.e);
  estimate3_ = weigh(tableau_.e3);
  for (const std::vector<double>& row : tableau_.dense.d) powers_.push_back(weigh(row));
  ensure(rows_.size() <= most_stages, "a stage has its place among the accelerations");

  const std::size_t n = mechanics_.size();
  accelerations_.resize(tableau_.b.size() - 1 + tableau_.dense.c.size());
  for (std::size_t i = 1; i < tableau_.b.size(); ++i) accelerations_[i - 1].resize(n);
  stage_x_.resize(n);
  stage_v_.resize(n);
  zero_.resize(is_adaptive() ? n : 0, 0.0);
  for (std::size_t i = 0; i < tableau_.b.size(); ++i) {
    const bool counts = tableau_.b[i] != 0.0 || (i < tableau_.e.size() && tableau_.e[i] != 0.0);
    if (counts) looks_.push_back(tableau_.c[i]);
  }
  looks_.insert(looks_.end(), {0.0, 1.0});
  std::sort(looks_.begin(), looks_.end());
  looks_.erase(std::unique(looks_.begin(), looks_.end()), looks_.end());
  distribute_error();
}

/// Distributes the allowed error over the stages. Errors dw_i of the stages move the end of the step by h sum_i b_i
/// dw_i and also through later stages, which depend on earlier ones:
///
///   weight_i = max(|b_i|, |e_i|) + answer sum_(j > i) weight_j |a_ji|
///
/// Work is least if each stage may make the same part of the allowed error, over its weight.
void RungeKutta::distribute_error() {
  // Steps are about ten times better than their estimates. With a hundredth of the tolerance for all stages together,
  // motions of nets and lattices end with the errors that exact stages leave (bench/reuse).
  constexpr double for_all = 0.01;
  constexpr double answer = 0.3;  // dw_j/(h a_ji dw_i), by how much rods turn in a step
  constexpr double least = 0.05;
  const std::size_t stages = tableau_.b.size();
  std::vector<double> weights(stages);
  shares_.resize(stages);
  for (std::size_t i = stages; i-- > 0;) {
    for (const std::vector<double>* each : {&tableau_.b, &tableau_.e, &tableau_.e3}) {
      if (i < each->size()) weights[i] = std::max(weights[i], std::abs((*each)[i]));
    }
    for (std::size_t j = i + 1; j < stages; ++j) {
      if (i < tableau_.a[j].size()) weights[i] += answer * weights[j] * std::abs(tableau_.a[j][i]);
    }
    shares_[i] = for_all / (static_cast<double>(stages) * std::max(weights[i], least));
  }
}

/// Returns the weights and weights'A, from the rows made so far.
RungeKutta::Weights RungeKutta::weigh(const std::vector<double>& weights) const {
  Weights result{weights, std::vector<double>(weights.size(), 0.0)};
  for (std::size_t k = 0; k < weights.size(); ++k) {
    const std::vector<double>& row = rows_[k].v;
    for (std::size_t j = 0; j < row.size(); ++j) result.x[j] += weights[k] * row[j];
  }
  return result;
}

/// Lists the accelerations of all stages. The first stage is at the beginning of the step, the one after the others at
/// its end.
RungeKutta::Accelerations RungeKutta::accelerations(const State& from, const State& to) const {
  const std::size_t stages = tableau_.b.size();
  Accelerations a{from.a.data()};
  for (std::size_t i = 1; i < stages; ++i) a[i] = accelerations_[i - 1].data();
  a[stages] = to.a.data();
  for (std::size_t i = stages; i - 1 < accelerations_.size(); ++i) a[i + 1] = accelerations_[i - 1].data();
  return a;
}

/// Evaluates a stage at x_i = x + h c_i v + h^2 sum_j (A^2)_ij a_j and v_i = v + h sum_j A_ij a_j. Only accelerations
/// need to be kept.
Outcome RungeKutta::evaluate_stage(const State& from, double h, double c, const Weights& row,
                                   const Accelerations& known, double allowed_error, const AccelerationOutput& to) {
  const std::size_t n = from.x.size();
  const double t = from.t + c * h;
  combine(mechanics_.parallel(), n, from.x.data(), h * c, from.v.data(), row.x, h * h, known, stage_x_.data());
  combine(mechanics_.parallel(), n, from.v.data(), 0.0, from.v.data(), row.v, h, known, stage_v_.data());
  mechanics_.prescribe(t, stage_x_.data(), stage_v_.data());
  Request request = options_.request(Gradients::Evaluate);
  request.allowed_error = allowed_error;
  return mechanics_.accelerations({t, stage_x_.data(), stage_v_.data()}, request, to);
}

StepResult RungeKutta::step(const State& from, double h, State* to) {
  const std::size_t n = from.x.size(), stages = tableau_.b.size();
  const Accelerations a = accelerations(from, *to);
  to->work = from.work;
  StepResult result;
  result.outcome = evaluate_stages(from, h, a, &to->work);
  if (!result.outcome.ok()) return result;
  const Weights& b = rows_[stages];
  combine(mechanics_.parallel(), n, from.x.data(), h, from.v.data(), b.x, h * h, a, to->x.data());
  combine(mechanics_.parallel(), n, from.v.data(), 0.0, from.v.data(), b.v, h, a, to->v.data());
  if (!is_adaptive()) return stabilize(mechanics_, options_, to, MovedVelocity::IsNoError);
  result = stabilize(mechanics_, options_, to, MovedVelocity::IsError);
  if (result.outcome.ok()) result.error = larger(result.error, estimate_error(from, h, *to));
  return result;
}

/// Evaluates all stages but the first one, and adds the work that is done on the way.
Outcome RungeKutta::evaluate_stages(const State& from, double h, const Accelerations& a, Power* work) {
  const bool has_work = mechanics_.has_work();
  if (has_work) work->add(h * tableau_.b[0], from.power);
  // Fixed steps have no tolerance and allow little more than rounding.
  constexpr double nearly_rounding = 1e-12;
  constexpr double none = std::numeric_limits<double>::min();
  const double atol = is_adaptive() ? options_.atol : none, rtol = is_adaptive() ? options_.rtol : nearly_rounding;
  InexactSolves* const inexact = mechanics_.inexact_solves();
  const double allowed =
      inexact != nullptr ? inexact->allowed_error({h, atol, rtol, from.x.data(), from.v.data()}) : 0.0;
  for (std::size_t i = 1; i < tableau_.b.size(); ++i) {
    Power power;
    Outcome found = evaluate_stage(from, h, tableau_.c[i], rows_[i], a, shares_[i] * allowed,
                                   {accelerations_[i - 1].data(), has_work ? &power : nullptr});
    if (!found.ok()) return found;
    if (has_work) work->add(h * tableau_.b[i], power);
  }
  return {};
}

/// Returns the error over the tolerance, as the mechanics measures it. Two estimates e and e3 of different order are
/// combined to one of the method's own order, e^2 / sqrt(e^2 + e3^2/100) (Hairer, Norsett, Wanner I, II.10).
double RungeKutta::estimate_error(const State& from, double h, const State& to) {
  const double e = measure(from, h, to, estimate_);
  if (tableau_.e3.empty() || e == 0.0) return e;
  return e * e / std::hypot(e, 0.1 * measure(from, h, to, estimate3_));
}

/// Returns one estimate over the tolerance. Uses the workspaces of the stages, which are free again.
double RungeKutta::measure(const State& from, double h, const State& to, const Weights& estimate) {
  const std::size_t n = from.x.size();
  const Parallel& parallel = mechanics_.parallel();
  const Accelerations a = accelerations(from, to);
  combine(parallel, n, zero_.data(), 0.0, zero_.data(), estimate.x, h * h, a, stage_x_.data());
  combine(parallel, n, zero_.data(), 0.0, zero_.data(), estimate.v, h, a, stage_v_.data());
  return mechanics_
      .error_ratios(from.t, {stage_x_.data(), stage_v_.data(), from.x.data(), from.v.data(), to.x.data(), to.v.data()},
                    options_.atol, options_.rtol)
      .largest();
}

Outcome RungeKutta::prepare_inside(const State& from, const State& to) {
  const std::size_t end = tableau_.b.size();
  for (std::size_t i = 0; i < tableau_.dense.c.size(); ++i) {
    std::vector<double>& a = accelerations_[end - 1 + i];
    a.resize(from.x.size());
    Outcome found = evaluate_stage(from, to.t - from.t, tableau_.dense.c[i], rows_[end + 1 + i],
                                   accelerations(from, to), 0.0, a.data());
    if (!found.ok()) return found;
  }
  return {};
}

/// Evaluates y(s) = y0 + q (y1 - y0) + h (s (1-s)^2 y0' - s^2 (1-s) y1') + h sum_i p_i d_i'y' for y = (x, v), with q =
/// s^2 (3 - 2s) and p = s^2 (1-s)^2 (1, s, s (1-s), s^2 (1-s)).
void RungeKutta::interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                             double* v) const {
  if (powers_.empty()) return Scheme::interpolate(parallel, from, to, fraction, x, v);
  const double s = fraction, r = 1.0 - s, q = s * s * (3.0 - 2.0 * s), h = to.t - from.t;
  const double rise = s * r * r, fall = -s * s * r;
  const std::array<double, 4> p{s * s * r * r, s * s * r * r * s, s * s * r * r * s * r, s * s * r * r * s * s * r};
  std::array<double, most_stages> in_v{}, in_x{};
  for (std::size_t i = 0; i < powers_.size(); ++i) {
    for (std::size_t j = 0; j < powers_[i].v.size(); ++j) {
      in_v[j] += p[i] * powers_[i].v[j];
      in_x[j] += p[i] * powers_[i].x[j];
    }
  }
  in_v[0] += rise;
  in_v[tableau_.b.size()] += fall;
  const std::size_t n = from.x.size();
  parallel.for_ranges(n, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      x[i] = from.x[i] + q * (to.x[i] - from.x[i]) + h * (rise * from.v[i] + fall * to.v[i]);
      v[i] = from.v[i] + q * (to.v[i] - from.v[i]);
    }
  });
  const Accelerations a = accelerations(from, to);
  const std::size_t stages = rows_.size();
  combine(parallel, n, x, 0.0, x, std::span(in_x).first(stages), h * h, a, x);
  combine(parallel, n, v, 0.0, v, std::span(in_v).first(stages), h, a, v);
}

}  // namespace tanor::detail
