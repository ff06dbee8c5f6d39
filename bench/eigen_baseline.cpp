#include "eigen_baseline.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

namespace {

Eigen::Vector3d point(const double* x, Eigen::Index k) {
  return Eigen::Map<const Eigen::Vector3d>(x + 3 * k);
}

/// A sparse matrix that is filled from triplets the first time, and entry by entry in the same order from then on.
struct Filled {
  Eigen::SparseMatrix<double> matrix;
  std::vector<Eigen::Triplet<double>> triplets;  // only the first time
  std::vector<Eigen::Index> slots;               // [triplet] its place among the values
  std::size_t next = 0;                          // triplet

  Filled(Eigen::Index rows, Eigen::Index columns) : matrix(rows, columns) {}

  void add(Eigen::Index row, Eigen::Index column, double value) {
    if (slots.empty())
      triplets.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
    else
      matrix.valuePtr()[slots[next++]] = value;
  }

  /// Returns true the first time. The triplets then hold their own numbers as values to find the slot of each.
  bool finish() {
    next = 0;
    if (!slots.empty()) return false;
    const std::vector<Eigen::Triplet<double>> given = std::move(triplets);
    for (std::size_t k = 0; k < given.size(); ++k)
      triplets.emplace_back(given[k].row(), given[k].col(), static_cast<double>(k));
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    slots.resize(given.size());
    for (Eigen::Index slot = 0; slot < matrix.nonZeros(); ++slot)
      slots[static_cast<std::size_t>(matrix.valuePtr()[slot])] = slot;
    for (std::size_t k = 0; k < given.size(); ++k) matrix.valuePtr()[slots[k]] = given[k].value();
    triplets = {};
    return true;
  }
};

}  // namespace

struct EigenBaseline::Step {
  Eigen::VectorXd inverse_masses, f, phi, w;
  Filled K;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;

  Step(const std::vector<double>& masses, const Triple& gravity, Eigen::Index num_rows)
      : inverse_masses(3 * masses.size()),
        f(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * masses.size()))),
        phi(num_rows),
        K(f.size(), num_rows) {
    for (std::size_t i = 0; i < masses.size(); ++i) {
      inverse_masses.segment<3>(static_cast<Eigen::Index>(3 * i)).setConstant(1.0 / masses[i]);
      if (!std::isfinite(masses[i])) continue;
      f.segment<3>(static_cast<Eigen::Index>(3 * i)) = masses[i] * Eigen::Map<const Eigen::Vector3d>(gravity.data());
    }
  }

  void add(Eigen::Index of_point, Eigen::Index row, const Eigen::Vector3d& gradient) {
    for (Eigen::Index k = 0; k < 3; ++k) K.add(3 * of_point + k, row, gradient[k]);
  }

  /// Returns w for the present K and phi.
  const double* solve() {
    const bool is_first = K.finish();
    const Eigen::SparseMatrix<double> S = K.matrix.transpose() * inverse_masses.asDiagonal() * K.matrix;
    if (is_first) factor.analyzePattern(S);
    factor.factorize(S);
    const Eigen::VectorXd lambda = factor.solve(-(phi + K.matrix.transpose() * inverse_masses.cwiseProduct(f)));
    w = inverse_masses.cwiseProduct(f + K.matrix * lambda);
    return w.data();
  }
};

EigenBaseline::EigenBaseline(std::vector<std::array<int, 2>> rods, const std::vector<double>& masses,
                             const Triple& gravity)
    : rods_(std::move(rods)), step_(std::make_unique<Step>(masses, gravity, static_cast<Eigen::Index>(rods_.size()))) {}

EigenBaseline::EigenBaseline(Guide guide, const std::vector<double>& masses, const Triple& gravity)
    : guide_(guide),
      step_(std::make_unique<Step>(masses, gravity,
                                   static_cast<Eigen::Index>(masses.size()) * (guide == Guide::Sphere ? 1 : 2))) {}

EigenBaseline::~EigenBaseline() = default;

const double* EigenBaseline::evaluate(const double* r, const double* v) {
  Step& step = *step_;
  // The distance has u = a/|a| and phi = (v.v - (u.v)^2)/|a|.
  const auto evaluate_distance = [&](Eigen::Index row, const Eigen::Vector3d& a, const Eigen::Vector3d& rate) {
    const double length = a.norm();
    const Eigen::Vector3d u = a / length;
    step.phi[row] = (rate.squaredNorm() - u.dot(rate) * u.dot(rate)) / length;
    return u;
  };
  for (std::size_t a = 0; a < rods_.size(); ++a) {
    const auto [i, j] = rods_[a];
    const auto row = static_cast<Eigen::Index>(a);
    const Eigen::Vector3d u = evaluate_distance(row, point(r, j) - point(r, i), point(v, j) - point(v, i));
    step.add(i, row, -u);
    step.add(j, row, u);
  }
  if (!rods_.empty()) return step.solve();
  Eigen::Index row = 0;
  for (Eigen::Index i = 0; row < step.phi.size(); ++i, ++row) {
    Eigen::Vector3d a = point(r, i), rate = point(v, i);
    if (guide_ == Guide::Circle) {
      step.phi[row] = 0.0;
      step.add(i, row++, Eigen::Vector3d::UnitZ());
      a[2] = rate[2] = 0.0;
    }
    step.add(i, row, evaluate_distance(row, a, rate));
  }
  return step.solve();
}

struct EigenTangentBaseline::Step {
  Eigen::Vector3d e1, e2;
  double radius;
  Eigen::VectorXd masses, f, psi, w;
  Filled A;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;

  explicit Step(Eigen::Index size) : masses(size), f(size), psi(size), A(size, size / 3) {}
};

EigenTangentBaseline::EigenTangentBaseline(const Triple& e1, const Triple& e2, double radius,
                                           const std::vector<double>& masses, const Triple& gravity)
    : step_(std::make_unique<Step>(static_cast<Eigen::Index>(3 * masses.size()))) {
  const auto vector = [](const Triple& a) { return Eigen::Vector3d(a[0], a[1], a[2]); };
  step_->e1 = vector(e1);
  step_->e2 = vector(e2);
  step_->radius = radius;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const auto place = static_cast<Eigen::Index>(3 * i);
    step_->masses.segment<3>(place).setConstant(masses[i]);
    step_->f.segment<3>(place) = masses[i] * vector(gravity);
  }
}

EigenTangentBaseline::~EigenTangentBaseline() = default;

const double* EigenTangentBaseline::evaluate(const double* q, const double* q_dot) {
  auto& [e1, e2, radius, masses, f, psi, w, A, factor] = *step_;
  for (Eigen::Index i = 0; i < psi.size() / 3; ++i) {
    const Eigen::Vector3d outwards = std::cos(q[i]) * e1 + std::sin(q[i]) * e2;
    const Eigen::Vector3d along = radius * (std::cos(q[i]) * e2 - std::sin(q[i]) * e1);
    psi.segment<3>(3 * i) = -radius * q_dot[i] * q_dot[i] * outwards;
    for (Eigen::Index k = 0; k < 3; ++k) A.add(3 * i + k, i, along[k]);
  }
  const bool is_first = A.finish();
  const Eigen::SparseMatrix<double> H = A.matrix.transpose() * masses.asDiagonal() * A.matrix;
  if (is_first) factor.analyzePattern(H);
  factor.factorize(H);
  const Eigen::VectorXd q_ddot = factor.solve(A.matrix.transpose() * (f - masses.cwiseProduct(psi)));
  w = A.matrix * q_ddot + psi;
  return w.data();
}
