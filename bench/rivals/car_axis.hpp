#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace rivals {

/// The car axis of the IVP test set, written by hand in its plane, r = (x_l, y_l, x_r, y_r):
///
///     r_l.b(t) = 0,  (|r_r - r_l|^2 - 1)/2 = 0,  b = (sqrt(1 - y_b^2), y_b),  y_b = 0.1 sin 10t,  m = 5e-4
///
/// Springs of stiffness 1 and length 1/2 stand on the feet 0 and b, weight -m. The class has the normal form and the
/// stabilised form of index 2.
class CarAxis {
 public:
  static constexpr int size = 4, unknowns = 12;  // y = (r, v, lambda, mu)
  static constexpr std::array<double, 2 * size> start{0.0, 0.5, 1.0, 0.5, -0.5, 0.0, -0.5, 0.0};

  /// Computes w = (f - K lambda)/m.
  void accelerations(double t, const double* r, const double* v, double* w) {
    const Road road(t);
    const auto [a, b] = gradients(road, r);
    const Plane f = forces(road, r);
    for (int i = 0; i < size; ++i) w[i] = f[i] / mass;
    const double ux = v[2] - v[0], uy = v[3] - v[1];
    const double phi_a =
        2.0 * (v[0] * road.rate[0] + v[1] * road.rate[1]) + r[0] * road.second[0] + r[1] * road.second[1];
    lambda_ = add_correction(a, b, phi_a + dot(a, w), ux * ux + uy * uy + dot(b, w), w);
    for (double& part : lambda_) part *= mass;
  }

  const std::array<double, 2>& multipliers() const { return lambda_; }

  /// Solves xi = 0 by Newton's method and then projects v onto K'v + xi_t = 0.
  void project(double t, double* r, double* v, double tolerance) const {
    const Road road(t);
    for (int pass = 0; pass < 10; ++pass) {
      const auto [a, b] = gradients(road, r);
      const double one = dot(a, r), two = 0.5 * (dot(b, r) - 1.0);
      if (std::max(std::abs(one), std::abs(two)) <= std::max(tolerance, 1e-14)) break;
      add_correction(a, b, one, two, r);
    }
    const auto [a, b] = gradients(road, r);
    add_correction(a, b, dot(a, v) + r[0] * road.rate[0] + r[1] * road.rate[1], dot(b, v), v);
  }

  void remove_normal_part(double t, const double* r, double* u) const {
    const auto [a, b] = gradients(Road(t), r);
    add_correction(a, b, dot(a, u), dot(b, u), u);
  }

  /// Computes F(t, y, y'): r' - v + K mu, m v' - f + K lambda, K'v + xi_t, xi.
  static void residual(double t, const double* y, const double* slope, double* out) {
    const Road road(t);
    const double *v = y + size, *lambda = v + size, *mu = lambda + 2;
    const auto [a, b] = gradients(road, y);
    const Plane f = forces(road, y);
    for (int i = 0; i < size; ++i) {
      out[i] = slope[i] - v[i] + a[i] * mu[0] + b[i] * mu[1];
      out[size + i] = mass * slope[size + i] - f[i] + a[i] * lambda[0] + b[i] * lambda[1];
    }
    out[8] = dot(a, v) + y[0] * road.rate[0] + y[1] * road.rate[1];
    out[9] = dot(b, v);
    out[10] = dot(a, y);
    out[11] = 0.5 * (dot(b, y) - 1.0);
  }

 private:
  static constexpr double mass = 5e-4;
  using Plane = std::array<double, size>;

  /// The vectors b, b', b''.
  struct Road {
    explicit Road(double t) {
      const double y = 0.1 * std::sin(10.0 * t), y1 = std::cos(10.0 * t), y2 = -100.0 * y, x = std::sqrt(1.0 - y * y);
      const double x1 = -y * y1 / x;
      foot = {x, y};
      rate = {x1, y1};
      second = {-(x1 * x1 + y1 * y1 + y * y2) / x, y2};
    }
    std::array<double, 2> foot, rate, second;
  };

  static double dot(const Plane& k, const double* u) { return k[0] * u[0] + k[1] * u[1] + k[2] * u[2] + k[3] * u[3]; }

  static std::array<Plane, 2> gradients(const Road& road, const double* r) {
    const double dx = r[2] - r[0], dy = r[3] - r[1];
    return {Plane{road.foot[0], road.foot[1], 0.0, 0.0}, Plane{-dx, -dy, dx, dy}};
  }

  static Plane forces(const Road& road, const double* r) {
    const double x = r[2] - road.foot[0], y = r[3] - road.foot[1];
    const double left = 0.5 / std::hypot(r[0], r[1]) - 1.0, right = 0.5 / std::hypot(x, y) - 1.0;
    return {left * r[0], left * r[1] - mass, right * x, right * y - mass};
  }

  /// Computes u -= K (K'K)^-1 (one, two) and returns the solution (K'K)^-1 (one, two).
  static std::array<double, 2> add_correction(const Plane& a, const Plane& b, double one, double two, double* u) {
    const double aa = dot(a, a.data()), ab = dot(a, b.data()), bb = dot(b, b.data()), det = aa * bb - ab * ab;
    const double x = (bb * one - ab * two) / det, y = (aa * two - ab * one) / det;
    for (int i = 0; i < size; ++i) u[i] -= a[i] * x + b[i] * y;
    return {x, y};
  }

  std::array<double, 2> lambda_{};
};

}  // namespace rivals
