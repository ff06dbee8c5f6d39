#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "base/memory.hpp"
#include "base/vec3.hpp"

/// \file Charts without poles. They are rational, without trigonometry, and their derivatives are written by hand. Each
/// is centred where the motion is.
namespace tanor::detail {

/// Returns a unit vector orthogonal to the unit vector n, along n x (the axis that n is farthest from).
inline Vec3 any_orthogonal(Vec3 n) {
  const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
  const Vec3 axis = x <= y && x <= z ? Vec3{1.0, 0.0, 0.0} : y <= z ? Vec3{0.0, 1.0, 0.0} : Vec3{0.0, 0.0, 1.0};
  const Vec3 e = cross(n, axis);
  return (1.0 / norm(e)) * e;
}

/// Unit vectors u(q1, q2) around a centre n, by stereographic projection from -n. With s = (q1^2 + q2^2)/4,
///   u = ((1 - s) n + q1 e1 + q2 e2)/(1 + s).
/// At q = 0, u = n, du/dq = (e1, e2), and |u''| = |q'|^2 along -n.
class DirectionChart {
 public:
  DirectionChart() = default;
  explicit DirectionChart(Vec3 unit) : n_(unit), e1_(any_orthogonal(unit)), e2_(cross(unit, e1_)) {}

  struct Value {
    Vec3 u, first, second;  ///< u, and its derivatives along q + e q'
    Vec3 tangent[2];
  };
  Value operator()(const double* q, const double* q_dot) const {
    const double s = 0.25 * (q[0] * q[0] + q[1] * q[1]);
    const double s1 = 0.5 * (q[0] * q_dot[0] + q[1] * q_dot[1]);
    const double s2 = 0.5 * (q_dot[0] * q_dot[0] + q_dot[1] * q_dot[1]);
    const double inverse = 1.0 / (1.0 + s);
    Value result;
    // The derivatives are those of u (1 + s) = N.
    result.u = inverse * ((1.0 - s) * n_ + q[0] * e1_ + q[1] * e2_);
    result.first = inverse * (q_dot[0] * e1_ + q_dot[1] * e2_ - s1 * (n_ + result.u));
    result.second = -inverse * (s2 * (n_ + result.u) + 2.0 * s1 * result.first);
    result.tangent[0] = inverse * (e1_ - 0.5 * q[0] * (n_ + result.u));
    result.tangent[1] = inverse * (e2_ - 0.5 * q[1] * (n_ + result.u));
    return result;
  }

  void exchange_memory(Memory& memory) { memory.exchange(n_, e1_, e2_); }

  /// Centres the chart anew at u(q) and converts the motion to the new chart, in which q = 0.
  void recentre(double* q, double* q_dot, double* q_ddot) {
    const Value now = (*this)(q, q_dot);
    const Vec3 second = now.second + q_ddot[0] * now.tangent[0] + q_ddot[1] * now.tangent[1];
    *this = DirectionChart((1.0 / norm(now.u)) * now.u);
    q[0] = q[1] = 0.0;
    q_dot[0] = dot(e1_, now.first);
    q_dot[1] = dot(e2_, now.first);
    // The part u''(q'' = 0) of u'' is normal to the tangents at the centre and drops out.
    q_ddot[0] = dot(e1_, second);
    q_ddot[1] = dot(e2_, second);
  }

 private:
  Vec3 n_{0.0, 0.0, 1.0}, e1_{1.0, 0.0, 0.0}, e2_{0.0, 1.0, 0.0};
};

/// Rotations R(theta) R_c around a centre R_c, by Gibbs' vector g = theta/2 (Cayley's map):
///   R(theta) a = a + 2/(1 + g^2) (g x a + g x (g x a)),   omega = (theta' + g x theta')/(1 + g^2).
/// At theta = 0, omega = theta' and omega' = theta''.
class RotationChart {
 public:
  RotationChart() = default;
  explicit RotationChart(const Eigen::Quaterniond& centre) : centre_(centre.normalized()) {}

  struct Value {
    Eigen::Matrix3d rotation;  ///< from the body's frame to space
    Vec3 omega, alpha;         ///< angular velocity, and its derivative if theta'' = 0
    Vec3 axis[3];              ///< omega = sum_j theta'_j axis_j
  };
  Value operator()(const double* theta, const double* theta_dot) const {
    const Vec3 g = 0.5 * load(theta, 0), h = load(theta_dot, 0);
    const double inverse = 1.0 / (1.0 + dot(g, g));
    Value result;
    result.rotation = quaternion(g).toRotationMatrix();
    result.omega = inverse * (h + cross(g, h));
    // This is the derivative of omega (1 + g^2) = theta' + g x theta', whose right side is constant if theta'' = 0.
    result.alpha = -inverse * dot(g, h) * result.omega;
    for (int j = 0; j < 3; ++j) {
      const Vec3 e{j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0};
      result.axis[j] = inverse * (e + cross(g, e));
    }
    return result;
  }

  void exchange_memory(Memory& memory) {
    for (double& coefficient : centre_.coeffs()) memory.exchange(coefficient);
  }

  void recentre(double* theta, double* theta_dot, double* theta_ddot) {
    const Value now = (*this)(theta, theta_dot);
    const Vec3 alpha =
        now.alpha + theta_ddot[0] * now.axis[0] + theta_ddot[1] * now.axis[1] + theta_ddot[2] * now.axis[2];
    centre_ = quaternion(0.5 * load(theta, 0));
    store(theta, 0, Vec3{});
    store(theta_dot, 0, now.omega);
    store(theta_ddot, 0, alpha);
  }

 private:
  /// Returns the rotation of Gibbs' vector g, which is the quaternion (1, g) up to its length, after that of the
  /// centre.
  Eigen::Quaterniond quaternion(Vec3 g) const {
    return (Eigen::Quaterniond(1.0, g.x, g.y, g.z) * centre_).normalized();
  }

  Eigen::Quaterniond centre_ = Eigen::Quaterniond::Identity();
};

}  // namespace tanor::detail
