#pragma once

/// \file Chains with stiff springs and uneven masses, whose forces cancel, for tests of tolerances below the rounding.

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <tanor/motion.hpp>

namespace tanor::noise {

/// Points on rods from an anchor, the last one held by a spring, in gravity.
struct StiffChain {
  std::vector<double> masses;    ///< kg
  std::vector<Vector3> rods;     ///< m, from point to point
  Vector3 anchor{};              ///< m
  double stiffness = 1e8;        ///< N/m
  Vector3 spring{0.3, 0.4, 0};   ///< m, from the last point to the spring's other end
  std::vector<double> speeds{};  ///< rad/s of each rod about z; at rest if empty
  double t_end = 0.01;           ///< s
};

inline Vector3 sum(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

inline System make_system(const StiffChain& chain) {
  System system;
  Vector3 place = chain.anchor, velocity{};
  const auto add = [&](const Vector3& r, const Vector3& v, double mass) {
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.velocities.insert(system.velocities.end(), v.begin(), v.end());
    system.masses.push_back(mass);
    return static_cast<Index>(system.masses.size() - 1);
  };
  const Index anchor = add(place, velocity, 1.0);
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t k = 0; k < chain.rods.size(); ++k) {
    const double speed = chain.speeds.empty() ? 0.0 : chain.speeds[k];
    place = sum(place, chain.rods[k]);
    velocity = sum(velocity, {-speed * chain.rods[k][1], speed * chain.rods[k][0], 0});
    const Index i = add(place, velocity, chain.masses[k]);
    rods.pairs.push_back({i - 1, i});
  }
  const auto last = static_cast<Index>(chain.rods.size());
  const Index hook = add(sum(place, chain.spring), {}, 1.0);
  system.supports = {{"ends", {anchor, hook}, {}}};
  system.constraints = {rods};
  const double rest = std::hypot(system.positions[3 * hook] - system.positions[3 * last],
                                 system.positions[3 * hook + 1] - system.positions[3 * last + 1],
                                 system.positions[3 * hook + 2] - system.positions[3 * last + 2]);
  system.forces = {Gravity{"gravity", {0, -9.81, 0}}, Springs{"spring", {{last, hook}}, chain.stiffness, 0.0, rest}};
  return system;
}

/// Makes a chain of 1e-6, 1, 1e-6 and 1 kg.
inline StiffChain make_uneven_chain() {
  return {.masses = {1e-6, 1, 1e-6, 1}, .rods = std::vector<Vector3>(4, Vector3{0.3, -0.4, 0})};
}

/// Draws a chain of that kind, with t_end at 100 rad of its fastest vibration.
inline StiffChain draw_chain(unsigned seed, double offset = 0.0) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  StiffChain chain;
  const int count = static_cast<int>(uniform(2.0, 6.0));
  const double ratio = std::pow(10.0, uniform(3.0, 9.0));
  chain.stiffness = std::pow(10.0, uniform(4.0, 10.0));
  double angle = uniform(-1.2, -0.3);
  for (int k = 0; k < count; ++k) {
    const double length = uniform(0.2, 0.8);
    chain.rods.push_back({length * std::cos(angle), length * std::sin(angle), 0});
    chain.masses.push_back((k % 2 == 0) == (count % 2 == 0) ? 1.0 / ratio : 1.0);
    if (seed % 2 == 0) angle += uniform(-0.3, 0.3);
  }
  chain.anchor = {offset, 0, 0};
  const double fastest = std::max(std::sqrt(chain.stiffness), std::sqrt(40.0 * ratio));
  chain.t_end = 100.0 / fastest;
  return chain;
}

/// Integrates the motion of the chain in long double by classical Runge-Kutta steps. It keeps the positions of all
/// points.
class Reference {
 public:
  using Number = long double;
  explicit Reference(const System& system) {
    const std::size_t n = system.masses.size();
    for (double x : system.positions) x_.push_back(x);
    for (double v : system.velocities) v_.push_back(v);
    for (std::size_t i = 0; i < n; ++i)
      inverse_.push_back(i == 0 || i + 1 == n ? 0.0L : 1.0L / Number(system.masses[i]));
    const auto& springs = std::get<Springs>(system.forces[1]);
    stiffness_ = springs.stiffness;
    rest_ = springs.rest_length.constants.empty() ? 0.0L : Number(springs.rest_length.constants[0]);
  }
  void run(double t_end, int steps) {
    const Number h = Number(t_end) / steps;
    const std::size_t n = x_.size();
    using Numbers = std::vector<Number>;
    for (int s = 0; s < steps; ++s) {
      Numbers x = x_, v = v_;
      std::array<Numbers, 4> kx, kv;
      const std::array<Number, 4> c{0.0L, 0.5L, 0.5L, 1.0L};
      for (std::size_t k = 0; k < 4; ++k) {
        if (k > 0) {
          for (std::size_t i = 0; i < n; ++i) {
            x[i] = x_[i] + c[k] * h * kx[k - 1][i];
            v[i] = v_[i] + c[k] * h * kv[k - 1][i];
          }
        }
        kx[k] = v;
        kv[k] = accelerations(x, v);
      }
      for (std::size_t i = 0; i < n; ++i) {
        x_[i] += h / 6 * (kx[0][i] + 2 * kx[1][i] + 2 * kx[2][i] + kx[3][i]);
        v_[i] += h / 6 * (kv[0][i] + 2 * kv[1][i] + 2 * kv[2][i] + kv[3][i]);
      }
    }
  }
  const std::vector<Number>& positions() const { return x_; }

 private:
  using Number3 = std::array<Number, 3>;
  static Number dot(const Number3& a, const Number3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  std::vector<Number> accelerations(const std::vector<Number>& x, const std::vector<Number>& v) const {
    const std::size_t n = inverse_.size(), rods = n - 2;
    const auto between = [](const std::vector<Number>& y, std::size_t i, std::size_t j) {
      return Number3{y[3 * j] - y[3 * i], y[3 * j + 1] - y[3 * i + 1], y[3 * j + 2] - y[3 * i + 2]};
    };
    std::vector<Number> a(3 * n, 0.0L);
    for (std::size_t i = 1; i + 1 < n; ++i) a[3 * i + 1] = -Number(9.81);
    const Number3 s = between(x, n - 2, n - 1);
    const Number length = std::sqrt(dot(s, s));
    for (std::size_t q = 0; q < 3; ++q)
      a[3 * (n - 2) + q] += inverse_[n - 2] * stiffness_ * (length - rest_) * s[q] / length;
    // S lambda = -(phi + K'a) is tridiagonal, with rods as |d|^2/2.
    std::vector<Number3> d(rods);
    std::vector<Number> diagonal(rods), beside(rods), b(rods);
    for (std::size_t k = 0; k < rods; ++k) {
      d[k] = between(x, k, k + 1);
      const Number3 dv = between(v, k, k + 1), da = between(a, k, k + 1);
      b[k] = -(dot(dv, dv) + dot(d[k], da));
      diagonal[k] = (inverse_[k] + inverse_[k + 1]) * dot(d[k], d[k]);
      if (k > 0) beside[k] = -inverse_[k] * dot(d[k - 1], d[k]);
    }
    for (std::size_t k = 1; k < rods; ++k) {
      const Number m = beside[k] / diagonal[k - 1];
      diagonal[k] -= m * beside[k];
      b[k] -= m * b[k - 1];
    }
    for (std::size_t k = rods; k-- > 0;) {
      if (k + 1 < rods) b[k] -= beside[k + 1] * b[k + 1];
      b[k] /= diagonal[k];
    }
    for (std::size_t k = 0; k < rods; ++k) {
      for (std::size_t q = 0; q < 3; ++q) {
        a[3 * k + q] -= inverse_[k] * b[k] * d[k][q];
        a[3 * (k + 1) + q] += inverse_[k + 1] * b[k] * d[k][q];
      }
    }
    return a;
  }
  std::vector<Number> x_, v_, inverse_;
  Number stiffness_ = 0.0L, rest_ = 0.0L;
};

/// Returns the positions [3n] of all points at t_end, extrapolated from two runs.
inline std::vector<long double> find_end(const System& system, double t_end) {
  constexpr int steps = 4000;
  Reference coarse(system), fine(system);
  coarse.run(t_end, steps);
  fine.run(t_end, 2 * steps);
  std::vector<long double> result = fine.positions();
  for (std::size_t i = 0; i < result.size(); ++i) result[i] += (result[i] - coarse.positions()[i]) / 15.0L;
  return result;
}

}  // namespace tanor::noise
