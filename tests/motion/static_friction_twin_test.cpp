#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <tanor/tanor.hpp>
#include <vector>

/// \file Two beads on rough lines that a rod joins, from rest, with static coefficients above the kinetic ones. They
/// are integrated a second time by a program of their own: one tension, one sense of motion, Runge-Kutta steps of fixed
/// length.
namespace tanor {
namespace {

using Eigen::Vector3d;

struct Bead {
  Vector3d r, d;  // place and direction of the line
  double mass, mu, mu_s, rate;
  Vector3d size, phase;

  Vector3d force(double t) const {
    Vector3d f;
    for (int c = 0; c < 3; ++c) f(c) = size(c) * std::sin(rate * t + phase(c));
    return f;
  }
};

using Beads = std::array<Bead, 2>;

Beads make_beads(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-2.0, 2.0), mass(0.2, 1.5), size(-20.0, 20.0), rate(4.0, 12.0),
      phase(0.0, 6.283185307179586), mu(0.1, 0.5), above(1.0, 1.6);
  Beads beads;
  for (Bead& bead : beads) {
    for (int c = 0; c < 3; ++c) {
      bead.r(c) = place(random);
      bead.d(c) = place(random);
      bead.size(c) = size(random);
      bead.phase(c) = phase(random);
    }
    bead.d.normalize();
    bead.mass = mass(random);
    bead.rate = rate(random);
    bead.mu = mu(random);
    bead.mu_s = bead.mu * above(random);
  }
  return beads;
}

System make_system(const Beads& beads) {
  const auto number = [](double x) {
    char text[32];
    std::snprintf(text, sizeof text, "(%.17g)", x);
    return std::string(text);
  };
  System system;
  for (Index i = 0; i < 2; ++i) {
    const Bead& bead = beads[static_cast<std::size_t>(i)];
    system.positions.insert(system.positions.end(), {bead.r(0), bead.r(1), bead.r(2)});
    system.masses.push_back(bead.mass);
    const std::string line = "line" + std::to_string(i);
    system.constraints.push_back(
        Lines{line, {i}, Vector3{bead.r(0), bead.r(1), bead.r(2)}, Vector3{bead.d(0), bead.d(1), bead.d(2)}});
    VectorFunction force;
    for (int c = 0; c < 3; ++c)
      force.components[static_cast<std::size_t>(c)] = ScalarFunction::formula(
          number(bead.size(c)) + "*sin(" + number(bead.rate) + "*t+" + number(bead.phase(c)) + ")");
    system.forces.push_back(ConstantForce{"", {i}, force});
    system.friction.push_back(
        Coulomb{.name = "", .at = {line}, .coefficient = bead.mu, .static_coefficient = bead.mu_s});
  }
  system.constraints.push_back(Rods{"rod", {{0, 1}}, {}, {}});
  system.velocities.assign(6, 0.0);
  return system;
}

/// The beads are at r + x d with velocities v d.
class Twin {
 public:
  /// Limits of rest are raised by the part `excess`.
  Twin(const Beads& beads, double excess) : beads_(beads), excess_(excess) {
    length_ = (beads[1].r - beads[0].r).norm();
  }

  bool is_certain = true;  // false if several motions obey the law, or none, or if the beads do not stop together
  std::array<double, 2> x{}, v{};

  void advance_to(double t_end) {
    constexpr double h = 1e-4;
    decide(0.0);
    const auto count = static_cast<int>(std::lround(t_end / h));
    for (int k = 0; k < count && is_certain; ++k) {
      double t = k * h;
      const double end = (k + 1) * h;
      for (int events = 0; t < end && is_certain && events < 20; ++events)
        t = sense_ == 0 ? wait(t, end) : slide(t, end);
    }
  }

 private:
  struct Rates {
    std::array<double, 2> x, v;
  };

  Vector3d rod(const std::array<double, 2>& at) const {
    return (beads_[1].r + at[1] * beads_[1].d - beads_[0].r - at[0] * beads_[0].d) / length_;
  }
  /// Returns the force on a bead without friction for the tension T of the rod along e.
  Vector3d load(std::size_t i, double t, double T, const Vector3d& e) const {
    return beads_[i].force(t) + (i == 0 ? T : -T) * e;
  }
  /// Returns the senses of both velocities if the first one moves in the sense `first`.
  std::array<double, 2> senses(const Vector3d& e, double first) const {
    return {first, first * beads_[0].d.dot(e) / beads_[1].d.dot(e) > 0.0 ? 1.0 : -1.0};
  }

  /// Finds accelerations for sliding in the given senses. The rod keeps its length if (a1 d1 - a0 d0).e + |u'|^2/L = 0,
  /// where u' is the velocity across it; this is one equation for T.
  std::optional<std::array<double, 2>> find_accelerations(double t, const std::array<double, 2>& at,
                                                          const std::array<double, 2>& speed,
                                                          const std::array<double, 2>& sense,
                                                          const std::array<double, 2>& mu) {
    const Vector3d e = rod(at), u = speed[1] * beads_[1].d - speed[0] * beads_[0].d;
    const double turning = (u - u.dot(e) * e).squaredNorm() / length_;
    std::array<double, 2> a{};
    const auto miss = [&](double T, double* slope) {
      double result = turning;
      *slope = 0.0;
      for (std::size_t i = 0; i < 2; ++i) {
        const Bead& bead = beads_[i];
        const Vector3d all = load(i, t, T, e), N = all - all.dot(bead.d) * bead.d, q = (i == 0 ? 1.0 : -1.0) * e;
        a[i] = (all.dot(bead.d) - sense[i] * mu[i] * N.norm()) / bead.mass;
        const double by_T =
            (q.dot(bead.d) - sense[i] * mu[i] * N.dot(q - q.dot(bead.d) * bead.d) / N.norm()) / bead.mass;
        const double along = (i == 0 ? -1.0 : 1.0) * bead.d.dot(e);
        result += a[i] * along;
        *slope += by_T * along;
      }
      return result;
    };
    double slope = 0.0;
    for (int pass = 0; pass < 60; ++pass) {
      const double value = miss(tension_, &slope);
      if (slope >= 0.0) is_certain = false;  // without friction it is negative, and then there may be several roots
      tension_ -= value / slope;
      if (std::abs(value) <= 1e-12 * (1.0 + std::abs(a[0]) + std::abs(a[1]))) return a;
    }
    return std::nullopt;
  }

  /// Returns true if some tension lets both beads rest: (f.d)^2 <= mu^2 |f across d|^2 is quadratic in T for each.
  bool may_rest(double t) const {
    const Vector3d e = rod(x);
    std::vector<double> roots;
    const auto spare = [&](std::size_t i, double T) {
      const Bead& bead = beads_[i];
      const Vector3d all = load(i, t, T, e);
      const double along = all.dot(bead.d), mu = (1.0 + excess_) * bead.mu_s;
      return mu * mu * (all.squaredNorm() - along * along) - along * along;
    };
    for (std::size_t i = 0; i < 2; ++i) {
      const double c = spare(i, 0.0), plus = spare(i, 1.0), minus = spare(i, -1.0);
      const double a = 0.5 * (plus + minus) - c, b = 0.5 * (plus - minus), D = b * b - 4.0 * a * c;
      if (D < 0.0) continue;
      const double q = -0.5 * (b + std::copysign(std::sqrt(D), b));
      roots.push_back(q / a);
      roots.push_back(c / q);
    }
    std::sort(roots.begin(), roots.end());
    std::vector<double> tried{0.0};
    if (!roots.empty()) tried = {roots.front() - 1e3, roots.back() + 1e3};
    for (std::size_t k = 0; k + 1 < roots.size(); ++k) tried.push_back(0.5 * (roots[k] + roots[k + 1]));
    return std::any_of(tried.begin(), tried.end(), [&](double T) { return spare(0, T) >= 0.0 && spare(1, T) >= 0.0; });
  }

  /// Decides at rest whether and in which sense the beads begin to slide: static limits first, then the kinetic ones.
  void decide(double t) {
    v = {};
    sense_ = 0;
    const bool rests = may_rest(t);
    const Vector3d e = rod(x);
    for (const bool is_static : {true, false}) {
      int found = 0, sense = 0;
      for (const int first : {1, -1}) {
        const std::array<double, 2> sense_of = senses(e, first), mu = is_static
                                                                          ? std::array{beads_[0].mu_s, beads_[1].mu_s}
                                                                          : std::array{beads_[0].mu, beads_[1].mu};
        const auto a = find_accelerations(t, x, v, sense_of, mu);
        if (!a || first * (*a)[0] <= 0.0) continue;
        ++found;
        sense = first;
      }
      if (rests) {
        is_certain = is_certain && found == 0;
        return;
      }
      is_certain = is_certain && found == 1;
      sense_ = sense;
    }
  }

  /// Waits at rest. Returns the end, or the instant at which the beads begin to slide.
  double wait(double t, double end) {
    if (may_rest(end)) return end;
    double low = t, high = end;
    while (high - low > 1e-15) {
      const double middle = 0.5 * (low + high);
      if (middle <= low || middle >= high) break;
      (may_rest(middle) ? low : high) = middle;
    }
    decide(high);
    return high;
  }

  /// Takes a step. Returns the end, or the instant at which the beads stop.
  double slide(double t, double end) {
    const auto x0 = x, v0 = v;
    const std::array<double, 2> sense = senses(rod(x0), sense_);
    if (!step(t, end - t, x0, v0)) return end;
    // Where the rod stands across a line, that bead passes by while the other one turns back.
    is_certain = is_certain && senses(rod(x), sense_) == sense;
    if (sense_ * v[0] > 0.0) return end;
    double low = 0.0, high = end - t, at_low = sense_ * v0[0], at_high = sense_ * v[0];
    for (int pass = 0; pass < 80 && high - low > 1e-15; ++pass) {
      double h = low + (high - low) * at_low / (at_low - at_high);
      if (pass % 3 == 2 || !(h > low && h < high)) h = 0.5 * (low + high);
      if (!step(t, h, x0, v0)) return end;
      const double now = sense_ * v[0];
      (now > 0.0 ? low : high) = h;
      (now > 0.0 ? at_low : at_high) = now;
    }
    decide(t + high);
    return t + high;
  }

  bool step(double t, double h, const std::array<double, 2>& x0, const std::array<double, 2>& v0) {
    const std::array<double, 2> sense = senses(rod(x0), sense_), mu{beads_[0].mu, beads_[1].mu};
    std::array<Rates, 4> k;
    x = x0;
    v = v0;
    constexpr std::array at{0.0, 0.5, 0.5, 1.0};
    for (std::size_t s = 0; s < 4; ++s) {
      std::array<double, 2> x_s = x0, v_s = v0;
      for (std::size_t i = 0; s > 0 && i < 2; ++i) {
        x_s[i] += at[s] * h * k[s - 1].x[i];
        v_s[i] += at[s] * h * k[s - 1].v[i];
      }
      const auto a = find_accelerations(t + at[s] * h, x_s, v_s, sense, mu);
      if (!a) is_certain = false;
      if (!a) return false;
      k[s] = {v_s, *a};
    }
    for (std::size_t i = 0; i < 2; ++i) {
      x[i] += h / 6.0 * (k[0].x[i] + 2.0 * k[1].x[i] + 2.0 * k[2].x[i] + k[3].x[i]);
      v[i] += h / 6.0 * (k[0].v[i] + 2.0 * k[1].v[i] + 2.0 * k[2].v[i] + k[3].v[i]);
    }
    return true;
  }

  const Beads& beads_;
  const double excess_;
  double length_, tension_ = 0.0;
  int sense_ = 0;  // of the first bead; 0 at rest
};

// tanor holds a shared load until it is 4e-6 above the limit. What twice that changes in the twin is allowed.
TEST(StaticFrictionTwin, RowsOfTwoBeadsEndWhereADenseProgramSays) {
  constexpr double t_end = 0.25;
  int compared = 0, refused = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const Beads beads = make_beads(seed);
    Twin exact(beads, 0.0), late(beads, 8e-6);
    exact.advance_to(t_end);
    late.advance_to(t_end);
    Simulation simulation(make_system(beads), {.method = Method::Dop853, .rtol = 1e-10, .atol = 1e-12});
    const Outcome outcome = simulation.advance_to(t_end);
    const FrictionSummary& friction = simulation.report().friction;
    if (!exact.is_certain || !late.is_certain || friction.several > 0) continue;
    if (!outcome.ok()) {
      // The twin sees one tension alone, and may miss a second motion at the start.
      EXPECT_EQ(outcome.status, Status::NotUnique) << "seed " << seed << ": " << outcome.what;
      ++refused;
      continue;
    }
    ++compared;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vector3d r = Vector3d::Map(simulation.positions().data() + 3 * i);
      const double x = (r - beads[i].r).dot(beads[i].d);
      EXPECT_LE(std::abs(x - exact.x[i]), 1e-8 + std::abs(late.x[i] - exact.x[i])) << "seed " << seed;
    }
  }
  EXPECT_GT(compared, 150);
  EXPECT_LE(refused, 3);
}

}  // namespace
}  // namespace tanor
