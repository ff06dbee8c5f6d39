#pragma once

/// \file The mechanics of a system, written down a second time: constraints over jets, forces by their formulas, dense
/// matrices. Slow and short; it shares nothing with src/. Everything stands in the user's order.

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

/// Where constraints are looked at: the points, and time, which runs along the jets or stands still.
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

/// (r + e v, t + e)
inline Configuration moving(Numbers r, Numbers v, double t) {
  Configuration result = standing(r, t);
  result.time_runs = true;
  for (std::size_t i = 0; i < v.size(); ++i) result.points[i / 3][i % 3].c[1] = v[i];
  return result;
}

/// xi of one member, row by row, as the contract of scene files defines it. `start`: the initial positions at t = 0,
/// which parameters that are "initial" refer to.
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

  /// Along e1, the part orthogonal to the direction of the axis that it is farthest from at the start, and along
  /// e2 = d x e1.
  std::vector<Number> operator()(const Lines& lines, std::size_t k) const {
    const Place given = now(lines.direction), d = (1.0 / norm(given)) * given;
    Place axis{};
    const Place first = start(lines.direction);
    const auto is_smaller = [](const Number& a, const Number& b) { return std::abs(a.value()) < std::abs(b.value()); };
    axis[static_cast<std::size_t>(std::min_element(first.begin(), first.end(), is_smaller) - first.begin())] = 1.0;
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
};

/// Users' kernels are their own definition.
inline std::vector<Number> user_xi(const UserConstraints& user, std::size_t k, const Configuration& now) {
  std::vector<double> r, v;
  for (const Index i : user.tuples[k]) {
    for (const Number& x : now[i]) {
      r.push_back(x.value());
      v.push_back(x.derivative(1));
    }
  }
  std::vector<double> gradient(r.size());
  double value = 0.0, rate = 0.0, phi = 0.0;
  user.kernel.evaluate(user.kernel.context.get(), {1, now.t, r.data(), v.data(), &value, &rate, &phi, gradient.data()});
  Number xi = Number::variable(value, rate);
  xi.c[2] = phi / 2.0;
  if (!now.time_runs) xi = Number::variable(value, vector(gradient).dot(vector(v)));
  return {xi};
}

inline std::size_t num_members(const Rods& group) {
  return group.pairs.size();
}
inline std::size_t num_members(const Angles& group) {
  return group.triples.size();
}
inline std::size_t num_members(const Pulleys& group) {
  return group.pairs.size();
}
inline std::size_t num_members(const Linears& group) {
  return group.tuples.size();
}
inline std::size_t num_members(const UserConstraints& group) {
  return group.tuples.size();
}
template <class Group>
std::size_t num_members(const Group& group) {
  return group.points.size();
}

/// All rows.
inline std::vector<Number> constraint_values(const System& system, const Configuration& now) {
  const Configuration start = standing(system.positions, 0.0);
  std::vector<Number> result;
  for (const Constraint& constraint : system.constraints) {
    std::visit(
        [&]<class Group>(const Group& group) {
          for (std::size_t k = 0; k < num_members(group); ++k) {
            if constexpr (std::is_same_v<Group, UserConstraints>) {
              for (const Number& xi : user_xi(group, k, now)) result.push_back(xi);
            } else {
              for (const Number& xi : Xi{now, start}(group, k)) result.push_back(xi);
            }
          }
        },
        constraint);
  }
  return result;
}

/// The constraints at one instant.
struct ConstraintNumbers {
  Eigen::VectorXd xi, rate, phi;  ///< [d]; rate = K'v + xi_t, phi = second derivative along (r + e v, t + e)
  Eigen::MatrixXd K;              ///< 3n x d
};

inline ConstraintNumbers evaluate_constraints(const System& system, double t, Numbers r, Numbers v) {
  const std::vector<Number> along = constraint_values(system, moving(r, v, t));
  const auto d = static_cast<Eigen::Index>(along.size()), size = static_cast<Eigen::Index>(r.size());
  ConstraintNumbers result{Eigen::VectorXd(d), Eigen::VectorXd(d), Eigen::VectorXd(d), Eigen::MatrixXd(size, d)};
  for (Eigen::Index a = 0; a < d; ++a) {
    const Number& jet = along[static_cast<std::size_t>(a)];
    result.xi[a] = jet.value();
    result.rate[a] = jet.derivative(1);
    result.phi[a] = jet.derivative(2);
  }
  Configuration at = standing(r, t);
  for (Eigen::Index c = 0; c < size && d > 0; ++c) {
    double& rate = at.points[static_cast<std::size_t>(c / 3)][static_cast<std::size_t>(c % 3)].c[1];
    rate = 1.0;
    const std::vector<Number> values = constraint_values(system, at);
    for (Eigen::Index a = 0; a < d; ++a) result.K(c, a) = values[static_cast<std::size_t>(a)].derivative(1);
    rate = 0.0;
  }
  return result;
}

// ---- forces ------------------------------------------------------------------------------------------------------

inline std::vector<char> find_supports(const System& system) {
  std::vector<char> result(system.num_points(), 0);
  for (const Support& support : system.supports) {
    for (const Index i : support.points) result[static_cast<std::size_t>(i)] = 1;
  }
  return result;
}

/// f [3n]; gravity leaves supports alone, the other forces do not.
inline Eigen::VectorXd evaluate_forces(const System& system, double t, Numbers r, Numbers v) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
  const std::vector<char> is_support = find_supports(system);
  const auto on = [&](Index i) { return f.segment<3>(3 * i); };
  for (const Force& force : system.forces) {
    if (const auto* gravity = std::get_if<Gravity>(&force)) {
      for (std::size_t i = 0; i < system.num_points(); ++i) {
        if (!is_support[i]) {
          on(static_cast<Index>(i)) += system.masses[i] * point(gravity->acceleration, 0);
        }
      }
    } else if (const auto* given = std::get_if<ConstantForce>(&force)) {
      const auto now = given->force(t);
      for (const Index i : given->points) on(i) += Eigen::Vector3d(now[0].value(), now[1].value(), now[2].value());
    } else if (const auto* drag = std::get_if<Drag>(&force)) {
      for (const Index i : drag->points) {
        on(i) -= (drag->linear + drag->quadratic * point(v, i).norm()) * point(v, i);
      }
    } else if (const auto* formula = std::get_if<FormulaForce>(&force)) {
      for (const Index i : formula->points) {
        const std::size_t c = 3 * static_cast<std::size_t>(i);
        Eigen::Vector3d value;
        formula->kernel.evaluate(formula->kernel.context.get(), {1, t, &r[c], &v[c], value.data()});
        on(i) += value;
      }
    } else {
      const auto& springs = std::get<Springs>(force);
      for (std::size_t k = 0; k < springs.pairs.size(); ++k) {
        const auto [i, j] = springs.pairs[k];
        const Eigen::Vector3d along = point(r, j) - point(r, i), unit = along.normalized();
        const auto& rest = springs.rest_length.constants;
        const double rest_length = rest.empty() ? (point(system.positions, j) - point(system.positions, i)).norm()
                                                : rest[rest.size() == 1 ? 0 : k];
        const double tension =
            springs.stiffness * (along.norm() - rest_length) + springs.damping * unit.dot(point(v, j) - point(v, i));
        on(i) += tension * unit;
        on(j) -= tension * unit;
      }
    }
  }
  return f;
}

// ---- dynamics ----------------------------------------------------------------------------------------------------

/// The dense problem at one instant, on the points that move. Supports enter K'w + phi = 0 with their prescribed
/// acceleration.
struct Mechanics {
  std::vector<Eigen::Index> coordinates;  ///< of the moving points, in 3n
  Eigen::VectorXd M, f, v;                ///< diagonal of the mass matrix; active forces; velocities
  Eigen::MatrixXd K;                      ///< their rows
  Eigen::VectorXd phi;                    ///< with K_s'a_s of the supports
  Eigen::VectorXd rheonomic_rate;         ///< xi_t + K_s'v_s

  Eigen::VectorXd pick(const Eigen::Ref<const Eigen::VectorXd>& all) const { return all(coordinates); }
  Eigen::VectorXd pick(const std::vector<double>& all) const { return vector(all)(coordinates); }

  /// K'M^-1K
  Eigen::MatrixXd S() const { return K.transpose() * M.cwiseInverse().asDiagonal() * K; }

  /// sqrt(cond) of S scaled to a unit diagonal: what rounding errors are multiplied with at least.
  double sqrt_condition() const {
    if (K.cols() == 0) return 1.0;
    const Eigen::MatrixXd columns = (M.cwiseSqrt().cwiseInverse().asDiagonal() * K).colwise().normalized();
    const Eigen::VectorXd singular = columns.bdcSvd().singularValues();
    return singular[0] / singular[singular.size() - 1];
  }
};

inline Mechanics make_mechanics(const System& system, double t, Numbers r, Numbers v) {
  const ConstraintNumbers numbers = evaluate_constraints(system, t, r, v);
  const std::vector<char> is_support = find_supports(system);
  Mechanics result;
  std::vector<double> masses;
  for (std::size_t c = 0; c < r.size(); ++c) {
    if (is_support[c / 3]) continue;
    result.coordinates.push_back(static_cast<Eigen::Index>(c));
    masses.push_back(system.masses[c / 3]);
  }
  Eigen::VectorXd given_acceleration = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(r.size()));
  for (const Support& support : system.supports) {
    const auto now = support.displacement(t);
    for (const Index i : support.points) {
      for (int k = 0; k < 3; ++k) given_acceleration[3 * i + k] = now[static_cast<std::size_t>(k)].derivative(2);
    }
  }
  result.M = vector(masses);
  result.f = result.pick(evaluate_forces(system, t, r, v));
  result.v = result.pick(vector(v));
  result.K = numbers.K(result.coordinates, Eigen::all);
  result.phi = numbers.phi + numbers.K.transpose() * given_acceleration;
  result.rheonomic_rate = numbers.rate - result.K.transpose() * result.v;
  return result;
}

struct Solution {
  Eigen::VectorXd w, lambda;
};

/// [M -K; K' 0][w; lambda] = [f; -phi] by LU with full pivoting in extended precision, equilibrated (the unknowns
/// are M^1/2 w and lambda times the length of its column of M^-1/2 K) and refined.
inline Solution solve_kkt(const Mechanics& mechanics) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;
  const Eigen::Index s = mechanics.M.size(), d = mechanics.K.cols();
  const Vector root = mechanics.M.cast<long double>().cwiseSqrt();
  Matrix columns = root.cwiseInverse().asDiagonal() * mechanics.K.cast<long double>();
  const Vector length = columns.colwise().norm();
  columns = columns * length.cwiseInverse().asDiagonal();
  Matrix matrix = Matrix::Zero(s + d, s + d);
  matrix.topLeftCorner(s, s).setIdentity();
  matrix.topRightCorner(s, d) = -columns;
  matrix.bottomLeftCorner(d, s) = columns.transpose();
  Vector right_side(s + d);
  right_side << mechanics.f.cast<long double>().cwiseQuotient(root),
      -mechanics.phi.cast<long double>().cwiseQuotient(length);
  const Eigen::FullPivLU<Matrix> lu(matrix);
  Vector x = lu.solve(right_side);
  for (int pass = 0; pass < 2; ++pass) x += lu.solve(right_side - matrix * x);
  return {x.head(s).cwiseQuotient(root).cast<double>(), x.tail(d).cwiseQuotient(length).cast<double>()};
}

}  // namespace tanor::reference
