#pragma once

/// \file The mechanics of a system, written a second time, with constraints over jets, forces by their formulas and
/// dense matrices. The code is slow and short, and shares nothing with src/. Everything is in the user's order.

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <Eigen/Dense>
#include <tanor/jet.hpp>
#include <tanor/system.hpp>

namespace tanor::reference {

using Number = Jet<2>;
using Place = std::array<Number, 3>;
using Numbers = std::span<const double>;

inline Place operator-(const Place& a, const Place& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Place operator+(const Place& a, const Place& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Place operator*(const Number& s, const Place& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline Number dot(const Place& a, const Place& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Number norm(const Place& a) {
  return sqrt(dot(a, a));
}
inline Place cross(const Place& a, const Place& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Place place(const Vector3& a) {
  return {a[0], a[1], a[2]};
}
inline Eigen::Vector3d point(Numbers array, Index i) {
  return {array[3 * i], array[3 * i + 1], array[3 * i + 2]};
}
inline Eigen::Map<const Eigen::VectorXd> vector(Numbers array) {
  return {array.data(), static_cast<Eigen::Index>(array.size())};
}

// ---- constraints -------------------------------------------------------------------------------------------------

/// The arguments of constraints, which are the points and the time. Time runs along the jets or stands still.
struct Configuration {
  std::vector<Place> points;
  double t = 0.0;
  bool time_runs = false;

  const Place& operator[](Index i) const { return points[static_cast<std::size_t>(i)]; }
  Number operator()(const ScalarFunction& function) const {
    const Number now = function(t);
    return time_runs ? now : Number(now.value());
  }
  Place operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

inline Configuration standing(Numbers r, double t) {
  Configuration result{{}, t, false};
  for (std::size_t i = 0; i + 2 < r.size(); i += 3) result.points.push_back({r[i], r[i + 1], r[i + 2]});
  return result;
}

/// Returns (r + e v, t + e).
inline Configuration moving(Numbers r, Numbers v, double t) {
  Configuration result = standing(r, t);
  result.time_runs = true;
  for (std::size_t i = 0; i < v.size(); ++i) result.points[i / 3][i % 3].c[1] = v[i];
  return result;
}

/// Evaluates xi of one member, row by row, as docs/scene-format.md defines it. `start` has the initial positions, to
/// which parameters that are "initial" refer.
struct Xi {
  const Configuration &now, &start;

  template <class Measure>
  Number parameter(const Parameter& given, std::size_t k, const Measure& measure) const {
    if (given.is_initial()) return measure(start);
    if (!given.functions.empty()) return now(given.functions[given.functions.size() == 1 ? 0 : k]);
    return given.constants[given.constants.size() == 1 ? 0 : k];
  }

  std::vector<Number> operator()(const Rods& rods, std::size_t k) const {
    const auto [i, j] = rods.pairs[k];
    const Place offset = rods.offsets.empty() ? Place{} : place(rods.offsets[k]);
    const auto length = [&, i = i, j = j](const Configuration& at) { return norm(at[j] - at[i] + offset); };
    return {length(now) - parameter(rods.length, k, length)};
  }

  std::vector<Number> operator()(const Planes& planes, std::size_t k) const {
    const auto height = [&](const Configuration& at) { return dot(at(planes.normal), at[planes.points[k]]); };
    return {(height(now) - parameter(planes.offset, k, height)) / norm(now(planes.normal))};
  }

  std::vector<Number> operator()(const Spheres& spheres, std::size_t k) const {
    const auto radius = [&](const Configuration& at) { return norm(at[spheres.points[k]] - at(spheres.center)); };
    return {radius(now) - parameter(spheres.radius, k, radius)};
  }

  /// Returns the distances along e1 and e2 = d x e1. e1 is the part orthogonal to d of the axis farthest from d.
  std::vector<Number> operator()(const Lines& lines, std::size_t k) const {
    const Place given = now(lines.direction), d = (1.0 / norm(given)) * given;
    Place axis{};
    const auto is_smaller = [](const Number& a, const Number& b) { return std::abs(a.value()) < std::abs(b.value()); };
    axis[static_cast<std::size_t>(std::min_element(d.begin(), d.end(), is_smaller) - d.begin())] = 1.0;
    const Place e = axis - dot(axis, d) * d, e1 = (1.0 / norm(e)) * e;
    const Place a = now[lines.points[k]] - now(lines.origin);
    return {dot(e1, a), dot(cross(d, e1), a)};
  }

  std::vector<Number> operator()(const Circles& circles, std::size_t k) const {
    const auto height = [&](const Configuration& at) {
      const Place n = at(circles.normal);
      return dot(n, at[circles.points[k]] - at(circles.center)) / norm(n);
    };
    // |n x a|/|n| is the distance from the axis.
    const auto radius = [&](const Configuration& at) {
      const Place n = at(circles.normal);
      return norm(cross(n, at[circles.points[k]] - at(circles.center))) / norm(n);
    };
    return {height(now), radius(now) - parameter(circles.radius, k, radius)};
  }

  std::vector<Number> operator()(const Angles& angles, std::size_t m) const {
    const auto [i, j, k] = angles.triples[m];
    const auto cosine = [&, i = i, j = j, k = k](const Configuration& at) {
      const Place a = at[i] - at[j], b = at[k] - at[j];
      return dot(a, b) / (norm(a) * norm(b));
    };
    return {cosine(now) - parameter(angles.cosine, m, cosine)};
  }

  std::vector<Number> operator()(const Ropes& ropes, std::size_t k) const {
    const std::vector<Index>& path = ropes.paths[k];
    const auto measure = [&](const Configuration& at) {
      Number sum = 0.0;
      for (std::size_t p = 1; p < path.size(); ++p) {
        const double c = ropes.coefficients.empty() ? 1.0 : ropes.coefficients[p - 1];
        sum = sum + c * norm(at[path[p]] - at[path[p - 1]]);
      }
      return sum;
    };
    return {measure(now) - parameter(ropes.length, k, measure)};
  }

  std::vector<Number> operator()(const Pulleys& pulleys, std::size_t k) const {
    const auto [i, j] = pulleys.pairs[k];
    const auto length = [&, i = i, j = j](const Configuration& at) {
      return norm(at[i] - place(pulleys.a)) + pulleys.ratio * norm(at[j] - place(pulleys.b));
    };
    return {length(now) - parameter(pulleys.length, k, length)};
  }

  std::vector<Number> operator()(const Linears& linears, std::size_t k) const {
    const auto sum = [&](const Configuration& at) {
      Number result = 0.0;
      for (std::size_t p = 0; p < linears.coefficients.size(); ++p) {
        result += dot(place(linears.coefficients[p]), at[linears.tuples[k][p]]);
      }
      return result;
    };
    return {sum(now) - parameter(linears.value, k, sum)};
  }

  /// With Q = a'(sum of u u'/s^2) a and P = a'(sum of u u'/s^4) a over the axes u with radii s, returns (Q - sqrt
  /// Q)/sqrt P.
  std::vector<Number> operator()(const Ellipsoids& ellipsoids, std::size_t k) const {
    using Eigen::Vector3d;
    const Vector3d first = Vector3d(ellipsoids.axes[0].data()).normalized(), second(ellipsoids.axes[1].data());
    const Vector3d third = first.cross(second).normalized();
    const Vector3d axes[] = {first, third.cross(first), third};
    Eigen::Matrix3d inner = Eigen::Matrix3d::Zero(), outer = inner;
    for (std::size_t j = 0; j < 3; ++j) {
      inner += axes[j] * axes[j].transpose() / std::pow(ellipsoids.radii[j], 2);
      outer += axes[j] * axes[j].transpose() / std::pow(ellipsoids.radii[j], 4);
    }
    const Place a = now[ellipsoids.points[k]] - now(ellipsoids.center);
    const auto square = [&](const Eigen::Matrix3d& form) {
      Number sum = 0.0;
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) sum += form(i, j) * a[static_cast<std::size_t>(i)] * a[static_cast<std::size_t>(j)];
      }
      return sum;
    };
    return {(square(inner) - sqrt(square(inner))) / sqrt(square(outer))};
  }

  /// Returns the distance from the cylinder, and 2 rho tan(half the angle between the point and the wire) times the
  /// cosine of the wire's slope.
  std::vector<Number> operator()(const Helices& helices, std::size_t k) const {
    const Eigen::Vector3d d = Eigen::Vector3d(helices.axis.data()).normalized();
    int farthest = 0;
    d.cwiseAbs().minCoeff(&farthest);
    const Eigen::Vector3d e = Eigen::Vector3d::Unit(farthest), e1 = (e - d.dot(e) * d).normalized(), e2 = d.cross(e1);
    const double turns = 2.0 * M_PI / helices.pitch;
    const auto along = [&](const Configuration& at, const Eigen::Vector3d& u) {
      return dot(place({u[0], u[1], u[2]}), at[helices.points[k]] - at(helices.origin));
    };
    const auto phase = [&](const Configuration& at) {
      return atan2(along(at, e2), along(at, e1)) - turns * along(at, d);
    };
    const Number half = 0.5 * (phase(now) - parameter(helices.phase, k, phase));
    const Number x = along(now, e1), y = along(now, e2), rho = sqrt(x * x + y * y);
    const double cosine = 1.0 / std::hypot(1.0, helices.radius * turns);
    return {rho - helices.radius, 2.0 * cosine * rho * tan(half)};
  }
};

/// The constraints at one instant.
struct ConstraintNumbers {
  Eigen::VectorXd xi, rate, phi;  ///< [d]; rate = K'v + xi_t, phi = second derivative along (r + e v, t + e)
  Eigen::MatrixXd K;              ///< 3n x d
};

ConstraintNumbers evaluate_constraints(const System& system, double t, Numbers r, Numbers v);

// ---- forces ------------------------------------------------------------------------------------------------------

/// Returns [point] 1 where it is a support.
std::vector<char> find_supports(const System& system);

/// Returns f [3n]. Gravity does not act on supports, the other forces do.
Eigen::VectorXd evaluate_forces(const System& system, double t, Numbers r, Numbers v);

// ---- dynamics ----------------------------------------------------------------------------------------------------

/// The dense problem at one instant, on the points that move. Supports enter K'w + phi = 0 with their prescribed
/// acceleration.
struct Mechanics {
  std::vector<Eigen::Index> coordinates;  ///< the moving points' indices in 3n
  Eigen::VectorXd M, f, v;                ///< diagonal of the mass matrix; active forces; velocities
  Eigen::MatrixXd K;                      ///< the moving points' rows
  Eigen::VectorXd phi;                    ///< with K_s'a_s of the supports
  Eigen::VectorXd rheonomic_rate;         ///< xi_t + K_s'v_s

  Eigen::VectorXd pick(const Eigen::Ref<const Eigen::VectorXd>& all) const;
  Eigen::VectorXd pick(const std::vector<double>& all) const;

  /// Returns K'M^-1K.
  Eigen::MatrixXd S() const;

  /// Returns sqrt(cond) of S scaled to a unit diagonal. Rounding errors are multiplied by at least this factor.
  double sqrt_condition() const;
};

Mechanics make_mechanics(const System& system, double t, Numbers r, Numbers v);

struct Solution {
  Eigen::VectorXd w, lambda;
};

/// Solves [M -K; K' 0][w; lambda] = [f; -phi] by LU with full pivoting in extended precision, equilibrated (the
/// unknowns are M^1/2 w, and lambda times the length of its column of M^-1/2 K) and refined.
Solution solve_kkt(const Mechanics& mechanics);

// ---- the paper's equations, dense ---------------------------------------------------------------------------------

/// K, a basis A of its complement, and the paper's quantities. Each equation is solved as it is written.
struct Paper {
  using Matrix = Eigen::MatrixXd;
  using Vector = Eigen::VectorXd;

  Matrix K, A, M;
  Vector f, phi;

  explicit Paper(const Mechanics& mechanics);

  /// Applies Gamma^-1, S^-1, G^-1 or H^-1 of (5) to one right-hand side.
  static Vector solve(const Matrix& gram, const Vector& b);
  Matrix S() const;
  Matrix H() const;

  /// Projections (15), (16).
  Vector normal_part(const Vector& u) const;
  Vector tangent_part(const Vector& u) const;
  /// The matrix (4).
  Matrix P() const;
  /// The matrix (8).
  Matrix P_M() const;

  /// Equations (21), (22).
  Vector w_N() const;
  Vector w_N_by_A(const Vector& psi) const;
  /// Equations (19), (20), (32), (33) for the given force.
  Vector w_T_by_K(const Vector& force) const;
  Vector w_T_by_A(const Vector& force) const;
  /// Equations (23), (24).
  Vector eta_by_K(const Vector& force) const;
  Vector eta_by_A(const Vector& force) const;
  /// Solves (27), P_M [lambda; w^(q)] = f - M w_N.
  Vector solve_27() const;
};

/// Returns the solution of one point on one surface with gradient k: w = f/m - (k'f/m + phi) k/k'k and lambda = -m
/// (k'f/m + phi)/k'k.
Solution solve_single_point(double m, const Eigen::Vector3d& f, const Eigen::Vector3d& k, double phi);

}  // namespace tanor::reference
