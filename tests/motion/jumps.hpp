#pragma once

/// \file Motions whose right side jumps where numbers change their signs, integrated side by side without src/.

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace tanor::jumps {

using Numbers = std::vector<double>;

/// y' = rate(is_positive, y) where is_positive [k] tells on which side of sides(y)[k] = 0 the motion is.
struct Piecewise {
  std::function<Numbers(const std::vector<bool>& is_positive, const Numbers& y)> rate;
  std::function<Numbers(const Numbers& y)> sides;
};

/// Makes a step of the extrapolated midpoint rule, of order 14 (Hairer, Norsett & Wanner, Solving ODEs I, II.9).
inline Numbers extrapolate(const std::function<Numbers(const Numbers&)>& rate, const Numbers& y, double h) {
  constexpr std::size_t columns = 7;
  std::vector<Numbers> row;
  for (std::size_t k = 0; k < columns; ++k) {
    const std::size_t n = 2 * (k + 1);
    const double part = h / static_cast<double>(n);
    Numbers before = y, now = y, slope = rate(y);
    for (std::size_t i = 0; i < y.size(); ++i) now[i] += part * slope[i];
    for (std::size_t m = 1; m < n; ++m) {
      slope = rate(now);
      for (std::size_t i = 0; i < y.size(); ++i) before[i] += 2.0 * part * slope[i];
      std::swap(before, now);
    }
    slope = rate(now);
    Numbers entry(y.size());
    for (std::size_t i = 0; i < y.size(); ++i) entry[i] = 0.5 * (before[i] + now[i] + part * slope[i]);
    std::vector<Numbers> next{entry};
    for (std::size_t j = 1; j <= k; ++j) {
      const double ratio = static_cast<double>(k + 1) / static_cast<double>(k + 1 - j);
      for (std::size_t i = 0; i < y.size(); ++i) entry[i] += (entry[i] - row[j - 1][i]) / (ratio * ratio - 1.0);
      next.push_back(entry);
    }
    row = next;
  }
  return row.back();
}

/// Follows the motion for that time in steps of `h`, each on one side of all jumps.
inline Numbers follow(const Piecewise& motion, Numbers y, double time, double h) {
  const auto are_positive = [&](const Numbers& at) {
    std::vector<bool> result;
    for (const double side : motion.sides(at)) result.push_back(side > 0.0);
    return result;
  };
  std::vector<bool> sides = are_positive(y);
  const auto step = [&](double length) {
    return extrapolate([&](const Numbers& at) { return motion.rate(sides, at); }, y, length);
  };
  while (time > 0.0) {
    const double length = std::min(h, time);
    double low = 0.0, high = length;
    Numbers end = step(length);
    constexpr int looks = 2;  // inside a step, for what is touched briefly
    for (int k = 1; k < looks; ++k) {
      const double inside = length * k / looks;
      if (are_positive(step(inside)) == sides) continue;
      high = inside;
      end = step(inside);
      break;
    }
    if (are_positive(end) != sides) {
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        (are_positive(step(middle)) == sides ? low : high) = middle;
      }
      end = step(high);
      y = end;
      sides = are_positive(y);
    } else {
      y = end;
    }
    time -= high;
  }
  return y;
}

}  // namespace tanor::jumps
