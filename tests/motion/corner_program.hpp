#pragma once

/// \file The motion of a few points on guides with corners, written a second time with dense matrices. It shares
/// nothing with src/. Between corners each term has one branch, whatever its argument is, and a Runge-Kutta method of
/// order 5 takes fixed steps that end at corners. At a corner the guide is rounded: its terms go over from one branch
/// to the other while the points stand still, which is integrated.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "dense.hpp"

namespace tanor::corner_program {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using Eigen::Vector3d;

/// weight |a'r - b|, or weight |t - b| if a is 0.
struct Kink {
  double weight;
  Vector3d a;
  double b;
  double side = 1.0;
  bool is_of_time() const { return a.isZero(); }
};
/// n'r = shift + the sum of the kinks, of one point.
struct Guide {
  Eigen::Index point;
  Vector3d n;
  double shift;
  std::vector<Kink> kinks;
};
/// |r_j - r_i| = length + its kink in time.
struct Rod {
  Eigen::Index i, j;
  double length;
  std::vector<Kink> kinks;
};
struct Spring {
  Eigen::Index i, j;
  double stiffness, length;
};

struct DenseMotion {
  std::vector<Guide> guides;
  std::vector<Rod> rods;
  std::vector<Spring> springs;
  Vector masses;
  Vector3d gravity{0.0, 0.0, -10.0};
  double t = 0.0;
  Vector r, v;
  std::size_t corners = 0;

  Eigen::Index rows() const { return static_cast<Eigen::Index>(guides.size() + rods.size()); }
  template <class Visit>
  void for_each_kink(const Visit& visit) {
    Eigen::Index row = 0;
    for (Guide& guide : guides) {
      for (Kink& kink : guide.kinks) visit(kink, row, guide.point);
      ++row;
    }
    for (Rod& rod : rods) {
      for (Kink& kink : rod.kinks) visit(kink, row, rod.j);
      ++row;
    }
  }
  static double argument(const Kink& kink, Eigen::Index point, double t, const Vector& r) {
    return kink.is_of_time() ? t - kink.b : kink.a.dot(r.segment<3>(3 * point)) - kink.b;
  }

  struct Rows {
    Vector xi, xi_t, phi;
    Matrix K;  // 3n x rows
  };
  Rows evaluate(double at, const Vector& x, const Vector& u) const {
    const Eigen::Index d = rows();
    Rows result{Vector::Zero(d), Vector::Zero(d), Vector::Zero(d), Matrix::Zero(x.size(), d)};
    Eigen::Index row = 0;
    for (const Guide& guide : guides) {
      Vector3d gradient = guide.n;
      double xi = guide.n.dot(x.segment<3>(3 * guide.point)) - guide.shift, xi_t = 0.0;
      for (const Kink& kink : guide.kinks) {
        xi -= kink.weight * kink.side * argument(kink, guide.point, at, x);
        gradient -= kink.weight * kink.side * kink.a;
        if (kink.is_of_time()) xi_t -= kink.weight * kink.side;
      }
      result.xi[row] = xi;
      result.xi_t[row] = xi_t;
      result.K.block<3, 1>(3 * guide.point, row) = gradient;
      ++row;
    }
    for (const Rod& rod : rods) {
      const Vector3d e = x.segment<3>(3 * rod.j) - x.segment<3>(3 * rod.i);
      const Vector3d rate = u.segment<3>(3 * rod.j) - u.segment<3>(3 * rod.i);
      double length = rod.length, l_t = 0.0;
      for (const Kink& kink : rod.kinks) {
        length += kink.weight * kink.side * (at - kink.b);
        l_t += kink.weight * kink.side;
      }
      const double now = e.norm();
      const Vector3d along = e / now;
      result.xi[row] = now - length;
      result.xi_t[row] = -l_t;
      result.phi[row] = (rate.squaredNorm() - std::pow(along.dot(rate), 2)) / now;
      result.K.block<3, 1>(3 * rod.j, row) = along;
      result.K.block<3, 1>(3 * rod.i, row) = -along;
      ++row;
    }
    return result;
  }

  Matrix inverse_mass() const { return masses.cwiseInverse().asDiagonal(); }
  /// Returns M^-1 K S^-1 y.
  Vector respond(const Matrix& K, const Vector& y) const {
    const Matrix weighted = inverse_mass() * K;
    return weighted * reference::solve_definite(K.transpose() * weighted, y);
  }
  Vector accelerate(double at, const Vector& x, const Vector& u) const {
    Vector w(x.size());
    for (Eigen::Index i = 0; i < x.size(); i += 3) w.segment<3>(i) = gravity;
    for (const Spring& spring : springs) {
      const Vector3d e = x.segment<3>(3 * spring.j) - x.segment<3>(3 * spring.i);
      const Vector3d force = spring.stiffness * (1.0 - spring.length / e.norm()) * e;
      w.segment<3>(3 * spring.i) += force / masses[3 * spring.i];
      w.segment<3>(3 * spring.j) -= force / masses[3 * spring.j];
    }
    const Rows at_it = evaluate(at, x, u);
    return w - respond(at_it.K, at_it.phi + at_it.K.transpose() * w);
  }
  void project() {
    for (int pass = 0; pass < 5; ++pass) {
      const Rows here = evaluate(t, r, v);
      r -= respond(here.K, here.xi);
    }
    const Rows here = evaluate(t, r, v);
    v -= respond(here.K, here.K.transpose() * v + here.xi_t);
  }

  /// Makes a step by the method of Dormand and Prince.
  void step(double h) {
    static const double a[6][6] = {{1.0 / 5},
                                   {3.0 / 40, 9.0 / 40},
                                   {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                   {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                   {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                   {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
    static const double c[6] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0};
    std::array<Vector, 6> rates, accelerations;
    Vector x = r, u = v;
    for (std::size_t stage = 0; stage < 6; ++stage) {
      rates[stage] = u;
      accelerations[stage] = accelerate(t + c[stage] * h, x, u);
      x = r;
      u = v;
      for (std::size_t j = 0; j <= stage; ++j) {
        x += h * a[stage][j] * rates[j];
        u += h * a[stage][j] * accelerations[j];
      }
    }
    r = x;
    v = u;
    t += h;
    project();
  }

  /// Turns the kink over: d(K'v + xi_t) = 0 while the term goes from one branch to the other.
  void turn(Kink* kink) {
    constexpr int steps = 280;
    const double from = kink->side, h = -2.0 * from / steps;
    kink->side = 1.0;
    const Rows high = evaluate(t, r, v);
    kink->side = -1.0;
    const Rows low = evaluate(t, r, v);
    const Matrix middle = 0.5 * (high.K + low.K), change = 0.5 * (high.K - low.K);
    const Vector change_t = 0.5 * (high.xi_t - low.xi_t);
    const auto slope = [&](double side, const Vector& u) -> Vector {
      return -respond(middle + side * change, change.transpose() * u + change_t);
    };
    for (int i = 0; i < steps; ++i) {
      const double side = from + i * h;
      const Vector k1 = slope(side, v), k2 = slope(side + 0.5 * h, v + 0.5 * h * k1),
                   k3 = slope(side + 0.5 * h, v + 0.5 * h * k2), k4 = slope(side + h, v + h * k3);
      v += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    kink->side = -from;
    ++corners;
    project();
  }

  /// Advances to `end` in steps of at most h.
  void advance(double end, double h) {
    for_each_kink([&](Kink& kink, Eigen::Index, Eigen::Index point) {
      kink.side = argument(kink, point, t, r) < 0.0 ? -1.0 : 1.0;
    });
    project();
    while (t < end) {
      const DenseMotion before = *this;
      double length = std::min(h, end - t);
      if (end - t - length < 1e-9) length = end - t;
      step(length);
      // The first corner that was passed.
      Kink* first = nullptr;
      double place = 2.0;
      for_each_kink([&](Kink& kink, Eigen::Index, Eigen::Index point) {
        const double from = argument(kink, point, before.t, before.r), to = argument(kink, point, t, r);
        if (!(kink.side * to < 0.0) || from / (from - to) > place) return;
        place = from / (from - to);
        first = &kink;
      });
      if (first == nullptr) continue;
      Eigen::Index number = 0, wanted = 0;
      for_each_kink([&](Kink& kink, Eigen::Index, Eigen::Index) {
        if (&kink == first) wanted = number;
        ++number;
      });
      Kink* turned = nullptr;
      double low = 0.0, high = length;
      DenseMotion at = before;
      for (int pass = 0; pass < 60 && high - low > 1e-16; ++pass) {
        at = before;
        const double trial = pass < 8 ? std::clamp(place * length, low, high) : 0.5 * (low + high);
        at.step(trial);
        double value = 0.0, start = 0.0;
        number = 0;
        at.for_each_kink([&](Kink& kink, Eigen::Index, Eigen::Index point) {
          if (number++ != wanted) return;
          value = kink.side * argument(kink, point, at.t, at.r);
          start = kink.side * argument(kink, point, before.t, before.r);
          turned = &kink;
        });
        if (std::abs(value) < 1e-15) break;
        (value > 0.0 ? low : high) = trial;
        // A secant from the beginning, which converges as the step is short.
        place = trial / length * start / (start - value);
      }
      *this = at;
      number = 0;
      for_each_kink([&](Kink& kink, Eigen::Index, Eigen::Index) {
        if (number++ == wanted) turned = &kink;
      });
      turn(turned);
    }
  }
};

}  // namespace tanor::corner_program
