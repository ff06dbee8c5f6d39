#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstddef>

namespace rivals {

/// The numbers of the mechanism (kg, kg m^2, m, N/m, N m), its loops and its spring.
struct AndrewsMechanism {
  using Complex = std::complex<double>;
  enum Angle : std::size_t { beta, theta, gamma, phi, delta, omega, epsilon };

  static constexpr double m1 = .04325, m2 = .00365, m3 = .02373, m4 = .00706, m5 = .07050, m6 = .00706, m7 = .05498;
  static constexpr double i1 = 2.194e-6, i2 = 4.410e-7, i3 = 5.255e-6, i4 = 5.667e-7, i5 = 1.169e-5, i6 = 5.667e-7,
                          i7 = 1.912e-5;
  static constexpr double d = 28e-3, da = 115e-4, e = 2e-2, ea = 1421e-5, zf = 2e-2, fa = 1421e-5, rr = 7e-3,
                          ra = 92e-5, ss = 35e-3, sa = 1874e-5, sb = 1043e-5, sc = 18e-3, sd = 2e-2, ta = 2308e-5,
                          tb = 916e-5, u = 4e-2, ua = 1228e-5, ub = 449e-5, zt = 4e-2, c0 = 4530.0, l0 = 7785e-5,
                          moment = 0.033;
  static constexpr Complex a{-.06934, -.00227}, b{-.03635, .03273}, c{.014, .072};

  /// A term A exp(i (q_first + q_second)) of the closing equation; if second = first, it has that one angle alone.
  struct Arm {
    std::size_t equation;
    Complex amplitude;
    std::size_t first, second;
  };
  static constexpr std::array<Arm, 11> arms{{{0, {rr, 0}, beta, beta},
                                             {0, {-d, 0}, beta, theta},
                                             {0, {0, ss}, gamma, gamma},
                                             {1, {rr, 0}, beta, beta},
                                             {1, {-d, 0}, beta, theta},
                                             {1, {0, e}, phi, delta},
                                             {1, {-zt, 0}, delta, delta},
                                             {2, {rr, 0}, beta, beta},
                                             {2, {-d, 0}, beta, theta},
                                             {2, {-zf, 0}, omega, epsilon},
                                             {2, {0, u}, epsilon, epsilon}}};
  static constexpr std::array<Complex, 3> ends{b, a, a};

  struct Spring {
    double stretch, by_angle, curvature;  // L - l0, L', L''
  };
  static Spring spring(double angle) {
    const Complex arm = Complex(sd, -sc) * std::polar(1.0, angle), reach = b - c + arm, turn = Complex(0.0, 1.0) * arm;
    const double length = std::abs(reach), by_angle = (std::conj(reach) * turn).real() / length;
    return {length - l0, by_angle, (std::norm(turn) - (std::conj(reach) * arm).real() - by_angle * by_angle) / length};
  }

  static constexpr double k2 = m2 * da * rr, k4 = m4 * zt * (e - ea), k6 = m6 * u * (zf - fa);
};

/// Andrews' squeezing mechanism in its bodies' seven angles q with six equations (Hairer & Wanner II, VII.7; Test Set
/// for IVP Solvers), in the stabilised form of index 2 by Gear, Gupta and Leimkuhler:
///
///   q' = v - G'mu,   M(q) v' = f(q, v) - G'lambda,   G v = 0,   g(q) = 0
struct AndrewsForm : AndrewsMechanism {
  static constexpr std::size_t n = 7, m = 6, unknowns = 2 * n + 2 * m;

  std::array<Complex, arms.size()> turned{};     // A exp(i psi)
  std::array<std::array<double, n>, m> slope{};  // G
  std::array<double, m> g{};
  std::array<std::array<double, n>, n> mass{};
  std::array<double, n> force{};

  /// Evaluates all of them at q and v.
  void evaluate(const double* q, const double* v) {
    const Complex unit_beta = std::polar(1.0, q[beta]), unit_link = std::polar(1.0, q[beta] + q[theta]);
    const std::array<Complex, 5> others{std::polar(1.0, q[gamma]), std::polar(1.0, q[phi] + q[delta]),
                                        std::polar(1.0, q[delta]), std::polar(1.0, q[omega] + q[epsilon]),
                                        std::polar(1.0, q[epsilon])};
    std::size_t other = 0;
    for (std::size_t k = 0; k < arms.size(); ++k) {
      const bool is_crank = arms[k].first == beta;
      const Complex unit = !is_crank ? others[other++] : arms[k].second == beta ? unit_beta : unit_link;
      turned[k] = arms[k].amplitude * unit;
    }
    for (auto& row : slope) row.fill(0.0);
    for (std::size_t j = 0; j < 3; ++j) set(j, -ends[j]);
    for (std::size_t k = 0; k < arms.size(); ++k) {
      const Arm& arm = arms[k];
      g[2 * arm.equation] += turned[k].real();
      g[2 * arm.equation + 1] += turned[k].imag();
      add_slope(arm, arm.first, turned[k]);
      if (arm.second != arm.first) add_slope(arm, arm.second, turned[k]);
    }
    evaluate_mass(q);
    evaluate_force(q, v);
  }

  /// Computes F(y, y') of y = (q, v, lambda, mu).
  void residual(const double* y, const double* y_dot, double* out) {
    const double *q = y, *v = y + n, *lambda = y + 2 * n, *mu = y + 2 * n + m;
    evaluate(q, v);
    for (std::size_t i = 0; i < n; ++i) {
      double first = y_dot[i] - v[i], second = -force[i];
      for (std::size_t j = 0; j < m; ++j) {
        first += slope[j][i] * mu[j];
        second += slope[j][i] * lambda[j];
      }
      for (std::size_t j = 0; j < n; ++j) second += mass[i][j] * y_dot[n + j];
      out[i] = first;
      out[n + i] = second;
    }
    for (std::size_t j = 0; j < m; ++j) {
      double rate = 0.0;
      for (std::size_t i = 0; i < n; ++i) rate += slope[j][i] * v[i];
      out[2 * n + j] = rate;
      out[2 * n + m + j] = g[j];
    }
  }

  /// Adds dF/dy + s dF/dy'. The function `entry(row, column)` returns a writable number that is 0 before.
  template <class Entry>
  void newton_matrix(const double* y, const double* y_dot, double s, const Entry& entry) {
    const double *q = y, *v = y + n, *lambda = y + 2 * n, *mu = y + 2 * n + m, *w = y_dot + n;
    evaluate(q, v);
    for (std::size_t i = 0; i < n; ++i) {
      entry(i, i) += s;
      entry(i, n + i) -= 1.0;
      for (std::size_t j = 0; j < m; ++j) {
        entry(i, 2 * n + m + j) = slope[j][i];
        entry(n + i, 2 * n + j) = slope[j][i];
        entry(2 * n + j, n + i) = slope[j][i];
        entry(2 * n + m + j, i) = slope[j][i];
      }
      for (std::size_t j = 0; j < n; ++j) entry(n + i, n + j) += s * mass[i][j];
    }
    // The derivative of G is -A exp(i psi) for both angles of an arm.
    for (std::size_t k = 0; k < arms.size(); ++k) {
      const Arm& arm = arms[k];
      const std::size_t row = 2 * arm.equation;
      const auto weigh = [&](const double* x) { return -(x[row] * turned[k].real() + x[row + 1] * turned[k].imag()); };
      const double by_mu = weigh(mu), by_lambda = weigh(lambda);
      const bool is_single = arm.first == arm.second;
      const double rate = v[arm.first] + (is_single ? 0.0 : v[arm.second]);
      for (const std::size_t i : {arm.first, arm.second}) {
        for (const std::size_t j : {arm.first, arm.second}) {
          entry(i, j) += by_mu;
          entry(n + i, j) += by_lambda;
          if (is_single) break;
        }
        entry(2 * n + row, i) -= turned[k].real() * rate;
        entry(2 * n + row + 1, i) -= turned[k].imag() * rate;
        if (is_single) break;
      }
    }
    add_mass_derivative(q, w, entry);
    add_force_derivative(q, v, entry);
  }

 private:
  void set(std::size_t equation, Complex value) {
    g[2 * equation] = value.real();
    g[2 * equation + 1] = value.imag();
  }
  void add_slope(const Arm& arm, std::size_t angle, Complex at) {
    slope[2 * arm.equation][angle] -= at.imag();
    slope[2 * arm.equation + 1][angle] += at.real();
  }

  void evaluate_mass(const double* q) {
    const double ct = std::cos(q[theta]), sp = std::sin(q[phi]), so = std::sin(q[omega]);
    for (auto& row : mass) row.fill(0.0);
    mass[0][0] = m1 * ra * ra + m2 * (rr * rr - 2.0 * da * rr * ct + da * da) + i1 + i2;
    mass[0][1] = mass[1][0] = m2 * (da * da - da * rr * ct) + i2;
    mass[1][1] = m2 * da * da + i2;
    mass[2][2] = m3 * (sa * sa + sb * sb) + i3;
    mass[3][3] = m4 * (e - ea) * (e - ea) + i4;
    mass[3][4] = mass[4][3] = m4 * ((e - ea) * (e - ea) + zt * (e - ea) * sp) + i4;
    mass[4][4] = m4 * (zt * zt + 2.0 * zt * (e - ea) * sp + (e - ea) * (e - ea)) + m5 * (ta * ta + tb * tb) + i4 + i5;
    mass[5][5] = m6 * (zf - fa) * (zf - fa) + i6;
    mass[5][6] = mass[6][5] = m6 * ((zf - fa) * (zf - fa) - u * (zf - fa) * so) + i6;
    mass[6][6] = m6 * ((zf - fa) * (zf - fa) - 2.0 * u * (zf - fa) * so + u * u) + m7 * (ua * ua + ub * ub) + i6 + i7;
  }

  void evaluate_force(const double* q, const double* v) {
    const Spring s = spring(q[gamma]);
    const double st = std::sin(q[theta]), cp = std::cos(q[phi]), co = std::cos(q[omega]);
    force = {moment - k2 * v[theta] * (v[theta] + 2.0 * v[beta]) * st,
             k2 * v[beta] * v[beta] * st,
             -c0 * s.stretch * s.by_angle,
             k4 * v[delta] * v[delta] * cp,
             -k4 * v[phi] * (v[phi] + 2.0 * v[delta]) * cp,
             -k6 * v[epsilon] * v[epsilon] * co,
             k6 * v[omega] * (v[omega] + 2.0 * v[epsilon]) * co};
  }

  template <class Entry>
  void add_mass_derivative(const double* q, const double* w, const Entry& entry) const {
    const double by_theta = k2 * std::sin(q[theta]), by_phi = k4 * std::cos(q[phi]),
                 by_omega = -k6 * std::cos(q[omega]);
    entry(n + beta, theta) += by_theta * (2.0 * w[beta] + w[theta]);
    entry(n + theta, theta) += by_theta * w[beta];
    entry(n + phi, phi) += by_phi * w[delta];
    entry(n + delta, phi) += by_phi * (w[phi] + 2.0 * w[delta]);
    entry(n + omega, omega) += by_omega * w[epsilon];
    entry(n + epsilon, omega) += by_omega * (w[omega] + 2.0 * w[epsilon]);
  }

  /// Adds -df/dq and -df/dv.
  template <class Entry>
  void add_force_derivative(const double* q, const double* v, const Entry& entry) const {
    const Spring s = spring(q[gamma]);
    const double st = std::sin(q[theta]), ct = std::cos(q[theta]), sp = std::sin(q[phi]), cp = std::cos(q[phi]),
                 so = std::sin(q[omega]), co = std::cos(q[omega]);
    const auto dv = [](std::size_t angle) { return n + angle; };
    entry(n + beta, theta) += k2 * v[theta] * (v[theta] + 2.0 * v[beta]) * ct;
    entry(n + beta, dv(theta)) += k2 * 2.0 * (v[theta] + v[beta]) * st;
    entry(n + beta, dv(beta)) += k2 * 2.0 * v[theta] * st;
    entry(n + theta, theta) -= k2 * v[beta] * v[beta] * ct;
    entry(n + theta, dv(beta)) -= k2 * 2.0 * v[beta] * st;
    entry(n + gamma, gamma) += c0 * (s.by_angle * s.by_angle + s.stretch * s.curvature);
    entry(n + phi, phi) += k4 * v[delta] * v[delta] * sp;
    entry(n + phi, dv(delta)) -= k4 * 2.0 * v[delta] * cp;
    entry(n + delta, phi) -= k4 * v[phi] * (v[phi] + 2.0 * v[delta]) * sp;
    entry(n + delta, dv(phi)) += k4 * 2.0 * (v[phi] + v[delta]) * cp;
    entry(n + delta, dv(delta)) += k4 * 2.0 * v[phi] * cp;
    entry(n + omega, omega) -= k6 * v[epsilon] * v[epsilon] * so;
    entry(n + omega, dv(epsilon)) += k6 * 2.0 * v[epsilon] * co;
    entry(n + epsilon, omega) += k6 * v[omega] * (v[omega] + 2.0 * v[epsilon]) * so;
    entry(n + epsilon, dv(omega)) -= k6 * 2.0 * (v[omega] + v[epsilon]) * co;
    entry(n + epsilon, dv(epsilon)) -= k6 * 2.0 * v[omega] * co;
  }
};

}  // namespace rivals
