#include "reference.hpp"

#include <algorithm>

#include "dense.hpp"

namespace tanor::reference {

namespace {

/// Returns xi by the user's kernel, which is its own definition.
std::vector<Number> user_xi(const UserConstraints& user, std::size_t k, const Configuration& now) {
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

std::size_t num_members(const Rods& group) {
  return group.pairs.size();
}
std::size_t num_members(const Angles& group) {
  return group.triples.size();
}
std::size_t num_members(const Ropes& group) {
  return group.paths.size();
}
std::size_t num_members(const Pulleys& group) {
  return group.pairs.size();
}
std::size_t num_members(const Linears& group) {
  return group.tuples.size();
}
std::size_t num_members(const UserConstraints& group) {
  return group.tuples.size();
}
template <class Group>
std::size_t num_members(const Group& group) {
  return group.points.size();
}

/// Returns xi of all rows.
std::vector<Number> constraint_values(const System& system, const Configuration& now) {
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

}  // namespace

ConstraintNumbers evaluate_constraints(const System& system, double t, Numbers r, Numbers v) {
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

std::vector<char> find_supports(const System& system) {
  std::vector<char> result(system.num_points(), 0);
  for (const Support& support : system.supports) {
    for (const Index i : support.points) result[static_cast<std::size_t>(i)] = 1;
  }
  return result;
}

Eigen::VectorXd evaluate_forces(const System& system, double t, Numbers r, Numbers v) {
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

Eigen::VectorXd Mechanics::pick(const Eigen::Ref<const Eigen::VectorXd>& all) const {
  return all(coordinates);
}
Eigen::VectorXd Mechanics::pick(const std::vector<double>& all) const {
  return vector(all)(coordinates);
}

Eigen::MatrixXd Mechanics::S() const {
  return K.transpose() * M.cwiseInverse().asDiagonal() * K;
}

double Mechanics::sqrt_condition() const {
  if (K.cols() == 0) return 1.0;
  const Eigen::MatrixXd columns = (M.cwiseSqrt().cwiseInverse().asDiagonal() * K).colwise().normalized();
  const Eigen::VectorXd singular = singular_values(columns);
  return singular[0] / singular[singular.size() - 1];
}

Mechanics make_mechanics(const System& system, double t, Numbers r, Numbers v) {
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

Solution solve_kkt(const Mechanics& mechanics) {
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

// ---- the paper's equations, dense ---------------------------------------------------------------------------------

namespace {

Paper::Matrix beside(const Paper::Matrix& left, const Paper::Matrix& right) {
  Paper::Matrix result(right.rows(), left.cols() + right.cols());
  result << left, right;
  return result;
}

}  // namespace

Paper::Paper(const Mechanics& mechanics)
    : K(mechanics.K), M(mechanics.M.asDiagonal()), f(mechanics.f), phi(mechanics.phi) {
  const Eigen::Index size = M.rows(), d = K.cols();
  const Matrix Q = d == 0 ? Matrix(Matrix::Identity(size, size)) : orthonormal_basis(K);
  A = Q.rightCols(size - d);
}

Paper::Vector Paper::solve(const Matrix& gram, const Vector& b) {
  return gram.rows() == 0 ? b : solve_definite(gram, b);
}
Paper::Matrix Paper::S() const {
  return K.transpose() * M.inverse() * K;
}
Paper::Matrix Paper::H() const {
  return A.transpose() * M * A;
}
Paper::Vector Paper::normal_part(const Vector& u) const {
  return K * solve(K.transpose() * K, K.transpose() * u);
}
Paper::Vector Paper::tangent_part(const Vector& u) const {
  return A * solve(A.transpose() * A, A.transpose() * u);
}
Paper::Matrix Paper::P() const {
  return beside(K, A);
}
Paper::Matrix Paper::P_M() const {
  return beside(-K, M * A);
}
Paper::Vector Paper::w_N() const {
  return -K * solve(K.transpose() * K, phi);
}
Paper::Vector Paper::w_N_by_A(const Vector& psi) const {
  return psi - tangent_part(psi);
}
Paper::Vector Paper::w_T_by_K(const Vector& force) const {
  const Vector given = M.inverse() * force - w_N();
  return given - M.inverse() * K * solve(S(), K.transpose() * given);
}
Paper::Vector Paper::w_T_by_A(const Vector& force) const {
  return A * solve(H(), A.transpose() * (force - M * w_N()));
}
Paper::Vector Paper::eta_by_K(const Vector& force) const {
  return K * solve(S(), K.transpose() * (w_N() - M.inverse() * force));
}
Paper::Vector Paper::eta_by_A(const Vector& force) const {
  const Vector given = M * w_N() - force;
  return given - M * A * solve(H(), A.transpose() * given);
}
Paper::Vector Paper::solve_27() const {
  return solve_full(P_M(), f - M * w_N());
}

Solution solve_single_point(double m, const Eigen::Vector3d& f, const Eigen::Vector3d& k, double phi) {
  const double excess = (k.dot(f) / m + phi) / k.squaredNorm();
  return {f / m - excess * k, Eigen::VectorXd::Constant(1, -m * excess)};
}

}  // namespace tanor::reference
