#include "base/root_isolation.hpp"

#include <algorithm>
#include <cmath>

#include "base/root_bracket.hpp"

namespace tanor::detail {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();

/// Returns the coefficients in Bernstein's basis of the quintic with these values at 0, 1/5, …, 1.
std::array<double, 6> to_bernstein(const std::array<double, 6>& f) {
  const auto first = [&f](std::size_t a, std::size_t b, std::size_t c, std::size_t d, std::size_t e, std::size_t g) {
    return -77.0 / 60.0 * f[a] + 5.0 * f[b] - 5.0 * f[c] + 10.0 / 3.0 * f[d] - 1.25 * f[e] + 0.2 * f[g];
  };
  const auto second = [&f](std::size_t a, std::size_t b, std::size_t c, std::size_t d, std::size_t e, std::size_t g) {
    return (269.0 * f[a] - 1450.0 * f[b] + 2950.0 * f[c] - 2300.0 * f[d] + 925.0 * f[e] - 154.0 * f[g]) / 240.0;
  };
  return {f[0], first(0, 1, 2, 3, 4, 5), second(0, 1, 2, 3, 4, 5), second(5, 4, 3, 2, 1, 0), first(5, 4, 3, 2, 1, 0),
          f[5]};
}

int sign_of(double value) {
  return (value > 0.0) - (value < 0.0);
}

/// Returns true if coefficients with errors below `error` tell that signs change at most once. Those within the error
/// tell nothing alone; they may lie between different signs if they rise or fall by more than the error. The two ends
/// are exact, up to rounding. At an end that is 0 to rounding, g = c s^2 + m s with |m| < 5 error hides no more than
/// (5 error)^2/(4 c), which does not matter if that is below rounding, too.
bool changes_sign_at_most_once(const std::array<double, 6>& b, double error, double rounding) {
  double largest = 0.0;
  for (const double each : b) largest = std::max(largest, std::abs(each));
  const bool is_exact = error <= 2.0 * rounding, hides_nothing = is_exact || error * error <= 0.1 * largest * rounding;
  const auto is_small = [&](std::size_t k) { return std::abs(b[k]) <= error; };
  const bool begins_at_zero = std::abs(b.front()) <= rounding, ends_at_zero = std::abs(b.back()) <= rounding;
  std::size_t begin = 0, end = b.size() - 1;
  if (begins_at_zero && hides_nothing)
    while (begin < end && is_small(begin)) ++begin;
  if (ends_at_zero && hides_nothing)
    while (end > begin && is_small(end)) --end;
  int last = sign_of(b.front()), changes = 0;
  bool is_open = false;  // true after numbers that tell nothing
  for (std::size_t k = begin; k <= end; ++k) {
    const bool is_flat = k > begin && std::abs(b[k] - b[k - 1]) <= error;
    if (is_flat && !is_exact && (is_small(k) || is_small(k - 1))) return false;
    const int sign = sign_of(b[k]);
    if (is_small(k) && k != 0 && k + 1 != b.size()) {
      is_open = true;
      continue;
    }
    if (is_open && sign * last >= 0) return false;
    if (sign * last < 0) ++changes;
    if (sign != 0) last = sign;
    is_open = false;
  }
  if (sign_of(b.back()) * last < 0) ++changes;
  return changes <= 1;
}

/// Returns the fraction at which the parabola through the least of these values and its neighbours is least; 0.5 if
/// there is none. The values are those of a quintic at 0, 1/5, …, 1 with the sign that makes them positive.
double find_least(const std::array<double, 6>& f, double sign) {
  std::size_t k = 0;
  for (std::size_t i = 1; i < f.size(); ++i)
    if (sign * f[i] < sign * f[k]) k = i;
  k = std::clamp<std::size_t>(k, 1, f.size() - 2);
  const double rise = 0.5 * (f[k + 1] - f[k - 1]), curvature = f[k + 1] - 2.0 * f[k] + f[k - 1];
  if (!(sign * curvature > 0.0)) return 0.5;
  return (static_cast<double>(k) - rise / curvature) / static_cast<double>(f.size() - 1);
}

}  // namespace

/// Returns the value at s of the quintic through the six samples from `first` on, where `without` is left out of seven.
double RootIsolation::predict(std::size_t first, std::size_t without, double s) const {
  std::array<const Sample*, num_nodes> node;  // NOLINT: filled before use
  for (std::size_t k = 0; k < num_nodes; ++k, ++first) {
    if (first == without) ++first;
    node[k] = &samples_[first];
  }
  double sum = 0.0;
  for (const Sample* at : node) {
    if (at->s == s) return at->value;
    double weight = 1.0;
    for (const Sample* other : node)
      if (other != at) weight *= (s - other->s) / (at->s - other->s);
    sum += weight * at->value;
  }
  return sum;
}

/// Returns how well sample j is predicted by the six around it. At the ends that is an extrapolation, by which a kink
/// right beside them is seen.
double RootIsolation::error_at(std::size_t j) {
  double& error = errors_[j];
  if (!std::isnan(error)) return error;
  const std::size_t first = std::min(j < 3 ? 0 : j - 3, samples_.size() - num_nodes - 1);
  return error = std::abs(predict(first, j, samples_[j].s) - samples_[j].value);
}

/// Returns four times the largest error of the samples around the stretch behind sample i. A smooth function misses
/// the quintic between samples by a tenth of that error, one with a kink by more.
double RootIsolation::error_around(std::size_t i, std::size_t reach) {
  const std::size_t end = std::min(i + 2 + reach, samples_.size());
  double largest = 0.0;
  for (std::size_t j = i <= reach ? 0 : i - reach; j < end; ++j) largest = std::max(largest, error_at(j));
  return 4.0 * largest;
}

/// Returns the largest magnitude of these samples.
double RootIsolation::size_around(std::size_t i) const {
  const std::size_t end = std::min(i + 4, samples_.size());
  double largest = 0.0;
  for (std::size_t j = i < 2 ? 0 : i - 2; j < end; ++j) largest = std::max(largest, std::abs(samples_[j].value));
  return largest;
}

double RootIsolation::size_between(std::size_t i) const {
  return std::max(std::abs(samples_[i].value), std::abs(samples_[std::min(i + 1, samples_.size() - 1)].value));
}

/// Returns the rounding of values in the stretch behind sample i. It is a part of their size near by, and no more than
/// that of the largest values if these are larger by many orders of magnitude, so that a function is known where it is
/// small.
double RootIsolation::rounding_around(std::size_t i) const {
  constexpr double roundings = 16.0 * std::numeric_limits<double>::epsilon(), orders = 1e6;
  const double size = std::max(samples_[i].size, size_between(i));
  const double part = orders * size < largest_ ? orders * size / largest_ : 1.0;
  return part * accuracy_.rounding + roundings * size;
}

/// Returns true if the quintic of the stretch behind sample i agrees with the samples around it.
bool RootIsolation::is_known(std::size_t i) {
  constexpr double most = 0.25;
  return error_around(i, 4) <= most * size_around(i) + rounding_around(i);
}

/// Returns the values at 0, 1/5, …, 1 of the stretch behind sample i by the quintic through the samples around it.
RootIsolation::Coefficients RootIsolation::values_between(std::size_t i) const {
  const std::size_t n = samples_.size(), first = std::min(i < 2 ? 0 : i - 2, n - num_nodes);
  const double a = samples_[i].s, length = samples_[i + 1].s - a;
  Coefficients f{};
  f.front() = samples_[i].value;
  f.back() = samples_[i + 1].value;
  for (std::size_t k = 1; k + 1 < num_nodes; ++k) f[k] = predict(first, n, a + 0.2 * static_cast<double>(k) * length);
  return f;
}

/// Returns where to divide the stretch behind sample i; NaN if it is settled.
double RootIsolation::find_division(std::size_t i) {
  constexpr double well_known = 0.1, nearest = 0.05, near_by = 0.01;
  const double a = samples_[i].s, length = samples_[i + 1].s - a;
  if (length <= 2.0 * accuracy_.s) return nan;
  if (length > near_by) samples_[i].size = size_between(i);
  const Coefficients f = values_between(i), b = to_bernstein(f);
  const double error = error_around(i, 2), rounding = rounding_around(i);
  // No sample on the other side of an end shows a kink beside it.
  const double at_end = i == 0 ? f.front() : i + 2 == samples_.size() ? f.back() : infinity;
  const bool may_hide = error > 2.0 * rounding && std::abs(at_end) > rounding && std::abs(at_end) <= error;
  if (is_known(i) && !may_hide && changes_sign_at_most_once(b, error + rounding, rounding)) return nan;
  double largest = 0.0;
  for (const double value : f) largest = std::max(largest, std::abs(value));
  const double sign = f.front() + f.back() > 0.0 ? 1.0 : -1.0;
  const double middle = i % 2 == 0 ? 0.47 : 0.53;
  const double part = error < well_known * largest ? std::clamp(find_least(f, sign), nearest, 1.0 - nearest) : middle;
  return a + part * length;
}

/// Divides each stretch that is not settled. Returns false if there was none.
bool RootIsolation::divide(const Function& g) {
  errors_.assign(samples_.size(), nan);
  next_.clear();
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    next_.push_back(samples_[i]);
    if (samples_[i].is_settled || i + 1 == samples_.size()) continue;
    const double s = find_division(i);
    next_.back().is_settled = std::isnan(s);
    if (!std::isnan(s)) next_.push_back({s, g(s), false, samples_[i].size});
  }
  const bool has_divided = next_.size() > samples_.size();
  samples_.swap(next_);
  return has_divided;
}

/// Samples that are rounding between two of equal sign are doubtful: g touches 0 there, or passes it twice.
void RootIsolation::find_doubts() {
  int before = 0;
  double place = nan;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Sample& sample = samples_[i];
    if (std::abs(sample.value) <= rounding_around(i)) {
      place = sample.s;
      continue;
    }
    const int now = sign_of(sample.value);
    if (now == before && !std::isnan(place) && std::isnan(doubtful_place_)) doubtful_place_ = place;
    before = now;
    place = nan;
  }
}

/// Looks whether the values at the probes are what the first samples tell. Those that are not become samples.
void RootIsolation::verify(std::span<const double> values) {
  next_ = samples_;
  errors_.assign(samples_.size(), nan);
  for (const std::size_t k : probes) {
    const auto after = std::ranges::upper_bound(samples_, places[k], {}, &Sample::s);
    const std::size_t i = static_cast<std::size_t>(after - samples_.begin()) - 1, n = samples_.size();
    const double told = predict(std::min(i < 2 ? 0 : i - 2, n - num_nodes), n, places[k]);
    if (std::abs(told - values[k]) <= error_around(i, 2) + 2.0 * rounding_around(i)) continue;
    if (is_known(i)) doubtful_place_ = places[k];
    next_.insert(std::ranges::upper_bound(next_, places[k], {}, &Sample::s), {places[k], values[k]});
  }
  samples_.swap(next_);
}

void RootIsolation::isolate(std::span<const double> values, const Function& g, const Accuracy& accuracy) {
  accuracy_ = accuracy;
  doubtful_place_ = nan;
  samples_.clear();
  largest_ = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (std::ranges::find(probes, i) == probes.end()) samples_.push_back({places[i], values[i]});
    largest_ = std::max(largest_, std::abs(values[i]));
  }
  const auto is_finite = [](const Sample& sample) { return std::isfinite(sample.value); };
  verify(values);
  while (std::all_of(samples_.begin(), samples_.end(), is_finite) && divide(g)) {
    if (samples_.size() <= most_samples) continue;
    const auto open = std::find_if(samples_.begin(), samples_.end(), [](const Sample& one) { return !one.is_settled; });
    doubtful_place_ = open->s;
    break;
  }
  find_doubts();
}

void RootIsolation::leave_zero(double sign, bool is_last) {
  constexpr double little = 1e-9;
  const std::size_t n = samples_.size();
  const double beside = std::abs(samples_[is_last ? n - 2 : 1].value);
  samples_[is_last ? n - 1 : 0].value = sign * std::max(little * beside, std::numeric_limits<double>::min());
}

/// Near a pole of order p, |g| falls by 4^p where the distance from it grows four times; near a jump it stays, and near
/// a root it rises. An order of 1/3 is seen.
bool RootIsolation::is_pole(double root, const Function& g) const {
  constexpr double falls = 1.3, farther = 4.0, nearest = 4096.0;  // |g|; distances, over the accuracy
  constexpr int rings = 3;
  bool is_known = false;
  for (const double side : {-1.0, 1.0}) {
    double distance = side * nearest * accuracy_.s, before = std::numeric_limits<double>::infinity();
    const double last = root + distance * farther * farther;
    if (!(last >= 0.0 && last <= 1.0)) continue;
    for (int ring = 0; ring < rings; ++ring, distance *= farther) {
      const double size = std::abs(g(root + distance));
      if (!(before > falls * size) || (ring == 0 && !(size > largest_))) return false;
      before = size;
    }
    is_known = true;
  }
  return is_known;
}

double RootIsolation::find_root(std::size_t i, const Function& g) const {
  const Sample &low = samples_[i], &high = samples_[i + 1];
  const double sign = low.value > 0.0 ? 1.0 : -1.0;
  RootBracket bracket(low.s, sign * low.value, high.s, sign * high.value, accuracy_.s);
  return bracket.narrow_by([&](double s) { return sign * g(s); }) ? bracket.root() : nan;
}

}  // namespace tanor::detail
