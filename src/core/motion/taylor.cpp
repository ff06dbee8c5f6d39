#include "motion/taylor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <type_traits>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"
#include "motion/runge_kutta.hpp"

namespace tanor::detail {

namespace {

constexpr int least_order = 6, most_order = 24;

/// Returns the order for a series of n numbers, of all processes. The best order grows with the logarithm of the
/// tolerance (Jorba & Zou 2005), by 0.7 while the series stays in the caches (bench/rivals, chains and nets). In larger
/// systems more terms pay if each costs little beside the step's factor and projections, more still if few islands need
/// the last ones, and fewer if every term runs through all memory (bench/taylor_order.py).
int choose_order(double tolerance, Mechanics& mechanics, const SeriesExpansion& series) {
  constexpr double large = 50000.0;
  const double n = mechanics.sum(static_cast<double>(mechanics.size()));
  const bool has_cheap_terms = mechanics.all(series.has_cheap_terms());
  const bool leaves_out_terms = mechanics.any(series.leaves_out_terms()) && has_cheap_terms;
  const double order = n < large          ? 4.0 - 0.7 * std::log(tolerance)
                       : leaves_out_terms ? 11.0 - 0.7 * std::log(tolerance)
                       : has_cheap_terms  ? 8.0 - 0.6 * std::log(tolerance)
                                          : 3.0 - 0.5 * std::log(tolerance);
  return std::clamp(static_cast<int>(std::lround(order)), least_order, most_order);
}

// Pack<> loses its alignment as a template argument; copies by memcpy do not need it.
#pragma GCC diagnostic ignored "-Wignored-attributes"

/// Sums x, x' and x'' (unless `a` is null) of some numbers at h, with q = c_2 + c_3 h + … and its derivatives by
/// Horner's scheme:
///
///   x = c_0 + h (c_1 + h q),   x' = c_1 + h (2 q + h q'),   x'' = 2 q + h (4 q' + h q'')
template <class Number>
[[gnu::always_inline]] inline void sum_series(std::span<double* const> coefficients, double h, std::size_t at,
                                              double* x, double* v, double* a) {
  constexpr std::size_t count = std::is_same_v<Number, Pack<>> ? 4 : 1;  // number of lanes that stay in registers
  constexpr std::size_t width = sizeof(Number) / sizeof(double);
  const auto load = [at](const double* from, std::size_t i) {
    Number number;
    std::memcpy(&number, from + at + width * i, sizeof(number));
    return number;
  };
  const auto store = [at](const Number& number, double* to, std::size_t i) {
    std::memcpy(to + at + width * i, &number, sizeof(number));
  };
  Number q[count]{}, slope[count]{}, half_bend[count]{};
  for (std::size_t k = coefficients.size() - 1; k >= 2; --k) {
    for (std::size_t i = 0; i < count; ++i) {
      half_bend[i] = h * half_bend[i] + slope[i];
      slope[i] = h * slope[i] + q[i];
      q[i] = h * q[i] + load(coefficients[k], i);
    }
  }
  // The small terms are added first.
  for (std::size_t i = 0; i < count; ++i) {
    const Number v0 = load(coefficients[1], i);
    store(load(coefficients[0], i) + h * (v0 + h * q[i]), x, i);
    store(v0 + h * (2.0 * q[i] + h * slope[i]), v, i);
    if (a != nullptr) store(2.0 * (q[i] + h * (2.0 * slope[i] + h * half_bend[i])), a, i);
  }
}

/// Sums the numbers [begin, end). The last ones are summed twice if they do not fill the lanes.
void sum_series(std::span<double* const> coefficients, double h, std::size_t begin, std::size_t end, double* x,
                double* v, double* a) {
  dispatch([=] {
    constexpr std::size_t width = 32;
    if (end - begin < width) {
      for (std::size_t i = begin; i < end; ++i) sum_series<double>(coefficients, h, i, x, v, a);
      return;
    }
    for (std::size_t next = begin; next < end; next += width)
      sum_series<Pack<>>(coefficients, h, std::min(next, end - width), x, v, a);
  });
}

/// The largest |a_i| and |a_i - b_i|, which ignore NaNs.
struct Comparison {
  double size = 0.0, difference = 0.0;

  void include(const Comparison& more) {
    size = std::max(size, more.size);
    difference = std::max(difference, more.difference);
  }
};
Comparison compare(const double* a, const double* b, std::size_t n) {
  return dispatch([=]() -> Comparison {
    double size = 0.0, difference = 0.0;
#pragma omp simd reduction(max : size, difference)
    for (std::size_t i = 0; i < n; ++i) {
      const double own = std::abs(a[i]), other = std::abs(a[i] - b[i]);
      size = own > size ? own : size;
      difference = other > difference ? other : difference;
    }
    return {size, difference};
  });
}

/// Sets b := a - b, and 0 where this is not larger than `noise`.
void subtract_from(const double* __restrict a, double noise, std::size_t n, double* __restrict b) {
  dispatch([=] {
    for (std::size_t i = 0; i < n; ++i) {
      const double difference = a[i] - b[i];
      b[i] = std::abs(difference) > noise ? difference : 0.0;
    }
  });
}

/// Calls visit(first, count, k) for the numbers that follow one another in neighbourhood k; `own` [n/3] is empty if all
/// numbers belong to one.
template <class Visit>
void for_runs(std::span<const Index> own, std::size_t n, const Visit& visit) {
  if (own.empty()) return visit(0, n, 0);
  for (std::size_t first = 0, end = 0; first < own.size(); first = end) {
    while (end < own.size() && own[end] == own[first]) ++end;
    visit(3 * first, 3 * (end - first), static_cast<std::size_t>(own[first]));
  }
}

/// Finds the nodes and weights of Gauss-Legendre quadrature on [0, 1] by Newton's method on the polynomial.
void make_quadrature(int count, std::vector<double>* nodes, std::vector<double>* weights) {
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5)), slope = 1.0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      // (k + 1) P_{k+1} = (2k + 1) x P_k - k P_{k-1}
      double before = 1.0, value = x;
      for (int k = 1; k < count; ++k) {
        const double next = ((2 * k + 1) * x * value - k * before) / (k + 1);
        before = value;
        value = next;
      }
      slope = count * (x * value - before) / (x * x - 1.0);
      x -= value / slope;
    }
    nodes->push_back(0.5 * (1.0 - x));
    weights->push_back(1.0 / ((1.0 - x * x) * slope * slope));
  }
}

SeriesExpansion& series_of(Mechanics& mechanics) {
  std::string why_not;
  if (SeriesExpansion* const series = mechanics.series(&why_not)) return *series;
  throw InputError("/motion/method", "taylor: " + why_not + "; take dop853, which needs no series, or auto");
}

}  // namespace

Taylor::Taylor(const IntegrationOptions& options, Mechanics& mechanics)
    : options_(options),
      mechanics_(mechanics),
      series_(series_of(mechanics)),
      order_(options.order > 0 ? options.order : choose_order(options.rtol, mechanics, series_)) {
  const std::size_t n = mechanics.size();
  expansion_.log_of_limits.resize(static_cast<std::size_t>(order_) + 1);
  coefficients_.assign(static_cast<std::size_t>(order_) + 1, std::vector<double>(n));
  for (std::vector<double>& coefficient : coefficients_) pointers_.push_back(coefficient.data());
  for (std::vector<double>* array : {&inside_.x, &inside_.v, &inside_.a}) array->resize(n, 0.0);
  other_ = std::make_unique<RungeKutta>(dop853_tableau(), options, mechanics);
  if (mechanics.has_work()) make_quadrature((order_ + 1) / 2, &nodes_, &weights_);
}

/// Right behind a jump, as of s v/|v|, quotients are small over small, and their series are rounding alone.
double Taylor::propose_step(const State& from, double resolution) {
  constexpr double right_behind = 1e4;  // resolutions
  if (!expansion_.is_known || expansion_.time != from.t) expand(from);
  if (expansion_.reach < right_behind * resolution) expansion_.exists = false;
  if (!expansion_.exists) return 0.0;
  // A piece of a table that ends within the resolution of time has ended.
  const bool has_ended = expansion_.extent.smooth_until - from.t < resolution;
  const double longest = has_ended ? std::min(expansion_.reach, resolution) : expansion_.longest;
  return rejected_.may_be_noise ? std::min(longest, 0.5 * rejected_.h) : longest;
}

/// Steps hardly grow from one to the next, so that islands may leave out terms that a little longer step than the last
/// would not need. Where they do, steps grow by little more than that each time.
void Taylor::expand(const State& from) {
  constexpr double growth = 1.1;
  if (expansion_.time != from.t) expansion_.wanted = std::min(growth * expansion_.reach, any_length);
  expand_for(expansion_.wanted, from);
}

void Taylor::expand_for(double h, const State& from) {
  const bool knows_acceleration = acceleration_.is_known && acceleration_.time == from.t;
  Outcome found;
  if (!knows_acceleration) {
    found = mechanics_.accelerations(from.at(), options_.request(Gradients::Keep),
                                     {pointers_[2], nullptr, nullptr, &found_});
  }
  const double* const a = knows_acceleration ? from.a.data() : pointers_[2];
  const Reactions& reactions = knows_acceleration ? from.reactions : found_;
  const SeriesDemand wanted{h, options_.atol, options_.rtol};
  SeriesExtent& extent = expansion_.extent;
  if (found.ok()) {
    std::array<double, 2> earliest{};
    found = mechanics_.together(
        [&] {
          Outcome own = series_.expand(from.at(), a, reactions, wanted, pointers_, &extent);
          earliest = {-extent.smooth_until, -extent.longest};
          return own;
        },
        earliest);
    extent.smooth_until = -earliest[0];
    extent.longest = -earliest[1];
  }
  expansion_.exists = found.ok();
  expansion_.is_known = true;
  rejected_ = {};
  expansion_.time = from.t;
  expansion_.reach = any_length;
  if (!expansion_.exists) return;
  std::fill(expansion_.log_of_limits.begin(), expansion_.log_of_limits.end(), std::numeric_limits<double>::quiet_NaN());
  choose_terms(from);
  expansion_.reach = std::min(expansion_.longest, extent.longest);
  expansion_.longest = std::min(expansion_.reach, extent.smooth_until - from.t);
}

/// Chooses all terms, unless rounding dominates the last ones. Near a singular configuration the terms of other motions
/// that start within the rounding grow faster than those of the motion itself.
void Taylor::choose_terms(const State& from) {
  expansion_.terms = order_;
  expansion_.longest = longest_step(from, order_);
  const int half = order_ / 2;
  if (mechanics_.rank_monitor() == nullptr || half <= least_order || longest_step(from, half) < expansion_.longest)
    return;
  for (int terms = least_order; terms < order_; ++terms) {
    if (const double h = longest_step(from, terms); h > expansion_.longest) {
      expansion_.longest = h;
      expansion_.terms = terms;
    }
  }
}

/// Returns the number of terms with the least remainder for a step longer than the series allows.
int Taylor::terms_for(const State& from, double h) {
  if (h <= expansion_.longest || mechanics_.rank_monitor() == nullptr) return expansion_.terms;
  // Logarithm of |term k| over the tolerance
  const auto size = [&](int k) { return k * (std::log(h) - log_of_longest_step(from, k)); };
  int best = expansion_.terms;
  double smallest = std::numeric_limits<double>::infinity();
  for (int terms = least_order; terms <= order_; ++terms) {
    if (const double left = std::max(size(terms - 1), size(terms)); left < smallest) {
      smallest = left;
      best = terms;
    }
  }
  return best;
}

/// Returns the longest h for which the last term, and the one before it, stay within the tolerance.
double Taylor::longest_step(const State& from, int terms) {
  return std::exp(std::min(log_of_longest_step(from, terms - 1), log_of_longest_step(from, terms)));
}

/// Returns the logarithm of the longest h for which term k stays within the tolerance, in positions and velocities. It
/// is computed once a series.
double Taylor::log_of_longest_step(const State& from, int k) {
  double& log_of_limit = expansion_.log_of_limits[static_cast<std::size_t>(k)];
  if (!std::isnan(log_of_limit)) return log_of_limit;
  const double* const c = pointers_[static_cast<std::size_t>(k)];
  const ErrorRatios ratios = mechanics_.error_ratios(
      from.t, {c, c, from.x.data(), from.v.data(), from.x.data(), from.v.data()}, options_.atol, options_.rtol);
  log_of_limit = detail::log_of_longest_step(k, ratios.x, ratios.v);
  return log_of_limit;
}

/// Returns the order of the last term that some of the numbers [begin, end) have.
std::size_t Taylor::count_terms(std::size_t begin, std::size_t end) const {
  const auto all = static_cast<std::size_t>(terms_);
  const std::vector<std::uint8_t>& last = expansion_.extent.last_term;
  if (last.empty()) return all;
  return std::min<std::size_t>(all, *std::max_element(last.begin() + begin / 3, last.begin() + (end + 2) / 3));
}

/// Evaluates x, x' and x'' (unless `a` is null) at h, in pieces that stay in the first-level cache.
void Taylor::evaluate(double h, double* x, double* v, double* a) const {
  const std::size_t n = coefficients_[0].size();
  constexpr std::size_t piece = 256;
  const auto evaluate_pieces = [&](std::size_t first, std::size_t end) {
    for (std::size_t begin = first * piece; begin < std::min(n, end * piece); begin += piece) {
      const std::size_t piece_end = std::min(n, begin + piece);
      sum_series(std::span(pointers_).first(count_terms(begin, piece_end) + 1), h, begin, piece_end, x, v, a);
    }
  };
  mechanics_.parallel().for_ranges((n + piece - 1) / piece, evaluate_pieces, 16);
}

Power Taylor::integrate_power(const State& from, double h) {
  Power sum = from.work;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const double t = from.t + nodes_[i] * h;
    evaluate(nodes_[i] * h, inside_.x.data(), inside_.v.data(), nullptr);
    mechanics_.prescribe(t, inside_.x.data(), inside_.v.data());
    Power power;
    (void)mechanics_.together([&] {
      power = series_.power_along({t, inside_.x.data(), inside_.v.data()}, terms_);
      return Outcome{};
    });
    sum.add(h * weights_[i], mechanics_.sum(power));
  }
  return sum;
}

/// Enlarges what is missing where the series ends before the others, at the order l: there it shows r_{l+1}, whose part
/// of the error is (P+1) P/((l+1) l) times as large. Series of two terms are exact.
void Taylor::weigh_missing(double* missing) const {
  const std::vector<std::uint8_t>& last = expansion_.extent.last_term;
  for (std::size_t i = 0; i < last.size(); ++i) {
    const int l = last[i];
    if (l <= 2 || l >= terms_) continue;
    const double factor = (terms_ + 1.0) * terms_ / ((l + 1.0) * l);
    for (std::size_t c = 0; c < 3; ++c) missing[3 * i + c] *= factor;
  }
}

/// Measures the first omitted term by what the series misses in the acceleration at the new state:
///
///   (P+1) P r_{P+1} h^{P-1} = a - sum,   so   r_{P+1} h^{P+1} = (a - sum) h^2/((P+1) P)
double Taylor::measure_error(const State& from, double h, const State& to) {
  const double of_v = h / terms_, of_x = of_v * h / (terms_ + 1);
  // Accelerations are accurate to about 1e-12 of the largest one, so that smaller differences mean nothing.
  constexpr double noise = 1e-11, most_noise = 1e-6;
  const std::span<const Index> own = series_.neighbourhoods();
  const double* const a = to.a.data();
  double* const missing = inside_.a.data();
  Comparison here;
  largest_.clear();
  for_runs(own, to.a.size(), [&](std::size_t first, std::size_t count, std::size_t k) {
    const Comparison part = compare(a + first, missing + first, count);
    here.include(part);
    if (k >= largest_.size()) largest_.resize(k + 1, 0.0);
    largest_[k] = std::max(largest_[k], part.size);
  });
  if (!own.empty()) series_.find_largest(largest_);
  for_runs(own, to.a.size(), [&](std::size_t first, std::size_t count, std::size_t k) {
    subtract_from(a + first, noise * largest_[k], count, missing + first);
  });
  weigh_missing(missing);
  const ErrorRatios ratios = mechanics_.error_ratios(
      from.t, {missing, missing, from.x.data(), from.v.data(), to.x.data(), to.v.data()}, options_.atol, options_.rtol);
  const double error = larger(of_x * ratios.x, of_v * ratios.v);
  const double largest = mechanics_.largest(here.size), most_missing = mechanics_.largest(here.difference);
  // There is more noise far from the origin, or if S is ill-conditioned. When a step is halved, its terms become less
  // than half as large, and so does the effect of a kink (of |v| v where a point turns round); noise does not.
  const bool should_fall = rejected_.missing > 0.0 && h < 0.51 * rejected_.h;
  const bool is_noise = should_fall && most_missing < most_noise * largest && most_missing > 0.6 * rejected_.missing;
  rejected_ = error > 1.0 ? Rejected{h, most_missing, most_missing < most_noise * largest} : Rejected{};
  return is_noise ? std::min(error, 1.0) : error;
}

Outcome Taylor::prepare_inside(const State& from, const State& to) {
  return expansion_.exists ? Outcome{} : other_->prepare_inside(from, to);
}

/// Interpolates by the series itself.
void Taylor::interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                         double* v) const {
  if (!expansion_.exists || expansion_.time != from.t) return other_->interpolate(parallel, from, to, fraction, x, v);
  evaluate(fraction * (to.t - from.t), x, v, nullptr);
}

StepResult Taylor::step(const State& from, double h, State* to) {
  if (!expansion_.is_known || expansion_.time != from.t) expand(from);
  constexpr double much = 1.05;  // the last step to an end may be longer by less
  const bool lacks_terms = expansion_.exists && expansion_.extent.longest < any_length;
  if (lacks_terms && h > much * expansion_.longest) expand_for(any_length, from);
  if (!expansion_.exists) return other_->step(from, h, to);
  terms_ = terms_for(from, h);
  to->work = nodes_.empty() ? from.work : integrate_power(from, h);
  evaluate(h, to->x.data(), to->v.data(), inside_.a.data());
  StepResult result = stabilize(mechanics_, options_, to, MovedVelocity::IsError, Turn::Large);
  if (result.outcome.ok()) result.error = larger(result.error, measure_error(from, h, *to));
  acceleration_ = {result.outcome.ok(), to->t};
  return result;
}

}  // namespace tanor::detail
