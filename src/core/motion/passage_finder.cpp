#include "motion/passage_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/check.hpp"
#include "motion/singular_thresholds.hpp"

namespace tanor::detail {

void PassageFinder::find(RankMonitor& monitor, DenseOutput dense, const State& to, const Stretch& stretch,
                         const std::function<void(double t)>& note) {
  const auto [begin, pieces, regular] = stretch;
  Outcome found;
  if (begin < 0.0 && (found = go_inside(&dense, begin)).ok()) monitor.remember_gradients();
  double low = begin;
  for (int k = 1; k <= pieces && found.ok(); ++k) {
    if (k > 1) monitor.remember_gradients();
    // The fraction is irregular, so that no symmetry of a motion coincides with it.
    const double high = k < pieces ? begin + (k - 0.1371) * (1.0 - begin) / pieces : 1.0;
    if (found = go_inside(&dense, high); !found.ok()) break;
    if (const double value = mechanics_.smallest(monitor.compare_gradients()); value < 0.0) {
      note(dense.time(narrow(monitor, &dense, low, high, value, regular)));
      found = go_inside(&dense, high);
    }
    low = high;
  }
  x_ = to.x;
  v_ = to.v;
  mechanics_.prescribe(to.t, x_.data(), v_.data());
  found = mechanics_.accelerations({to.t, x_.data(), v_.data()}, options_.request(Gradients::Evaluate), a_.data());
  ensure(found.ok(), "where a step has ended there are accelerations");
}

Outcome PassageFinder::go_inside(DenseOutput* dense, double fraction) {
  for (std::vector<double>* array : {&x_, &v_, &a_}) array->resize(mechanics_.size());
  if (Outcome found = dense->evaluate(mechanics_.parallel(), fraction, x_.data(), v_.data()); !found.ok()) return found;
  mechanics_.prescribe(dense->time(fraction), x_.data(), v_.data());
  return mechanics_.linearise(dense->time(fraction), x_.data());
}

/// Returns the fraction at which a singular value of K vanishes that has different signs at both ends; K at the low end
/// is remembered. Inverse interpolation (Neville) evaluates nearer configurations on both sides, but never so near that
/// rows would count as dependent.
double PassageFinder::narrow(RankMonitor& monitor, DenseOutput* dense, double low, double high, double value_high,
                             double regular) {
  std::array<double, 6> fractions{low, high}, values{1.0, value_high};
  std::size_t count = 2;
  const auto interpolate = [&] {
    std::array<double, 6> at = fractions;
    for (std::size_t k = 1; k < count; ++k) {
      for (std::size_t i = 0; i + k < count; ++i)
        at[i] = (values[i + k] * at[i] - values[i] * at[i + 1]) / (values[i + k] - values[i]);
    }
    return std::isfinite(at[0]) ? std::clamp(at[0], low, high) : 0.5 * (low + high);  // equal values determine nothing
  };
  const double at_high = mechanics_.reciprocal_condition();
  for (const double distance : {0.05, 1e-3}) {
    const double root = interpolate(), part = distance * (high - low) / (high - root);
    if (at_high * part * part < singular::reached * regular) return root;
    for (const double side : {-1.0, 1.0}) {
      const double fraction = root + side * distance * (high - low);
      if (!go_inside(dense, fraction).ok()) return root;
      fractions[count] = fraction;
      values[count] = mechanics_.smallest(monitor.compare_gradients());
      ++count;
    }
  }
  return interpolate();
}

}  // namespace tanor::detail
