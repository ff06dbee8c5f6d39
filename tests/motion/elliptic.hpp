#pragma once

#include <array>
#include <cmath>

/// Motions that are known in Jacobi's elliptic functions.
namespace tanor::elliptic {

struct Functions {
  double sn, cn, dn;
};

/// Evaluates sn, cn and dn of modulus k, 0 <= k < 1, by descending Landen steps (Abramowitz & Stegun 16.4).
inline Functions evaluate(double u, double k) {
  std::array<double, 12> a{1.0}, c{k};
  double b = std::sqrt((1.0 - k) * (1.0 + k));
  std::size_t n = 0;
  while (n + 1 < a.size() && std::abs(c[n]) > 1e-17) {
    a[n + 1] = 0.5 * (a[n] + b);
    c[n + 1] = 0.5 * (a[n] - b);
    b = std::sqrt(a[n] * b);
    ++n;
  }
  double phi = std::ldexp(a[n] * u, static_cast<int>(n));
  for (; n > 0; --n) phi = 0.5 * (phi + std::asin(c[n] / a[n] * std::sin(phi)));
  const double sn = std::sin(phi);
  return {sn, std::cos(phi), std::sqrt((1.0 - k * sn) * (1.0 + k * sn))};
}

struct Angle {
  double angle, rate;
};

/// Solves angle'' = -frequency^2 sin(angle) from rest at `amplitude`, in (-pi, pi).
inline Angle swing(double amplitude, double frequency, double t) {
  const double k = std::sin(0.5 * amplitude);
  const auto [sn, cn, dn] = evaluate(frequency * t, std::abs(k));
  // The solution is sin(angle/2) = k cd(u) with cd = cn/dn.
  return {2.0 * std::asin(k * cn / dn), -2.0 * frequency * k * std::sqrt((1.0 - k) * (1.0 + k)) * sn / dn};
}

/// Returns the time that the same motion takes from rest to angle 0.
inline double quarter_period(double amplitude, double frequency) {
  return std::comp_ellint_1(std::sin(0.5 * std::abs(amplitude))) / frequency;
}

}  // namespace tanor::elliptic
