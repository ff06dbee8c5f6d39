#include "eigen_baseline.hpp"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

namespace {

Eigen::Vector3d point(const double* x, Eigen::Index k) {
  return Eigen::Map<const Eigen::Vector3d>(x + 3 * k);
}

}  // namespace

struct EigenBaseline::Step {
  Eigen::VectorXd inverse_masses, f, phi, w;
  Eigen::SparseMatrix<double> K;
  std::vector<Eigen::Triplet<double>> triplets;  // only the first time
  std::vector<Eigen::Index> slots;               // [triplet] its place among the values of K
  std::size_t next = 0;                          // triplet
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;

  Step(const std::vector<double>& masses, const Triple& gravity, Eigen::Index num_rows)
      : inverse_masses(3 * masses.size()), f(3 * masses.size()), phi(num_rows), K(f.size(), num_rows) {
    for (std::size_t i = 0; i < masses.size(); ++i) {
      inverse_masses.segment<3>(static_cast<Eigen::Index>(3 * i)).setConstant(1.0 / masses[i]);
      f.segment<3>(static_cast<Eigen::Index>(3 * i)) = masses[i] * Eigen::Map<const Eigen::Vector3d>(gravity.data());
    }
  }

  /// Calls come in the same order at each evaluation.
  void add(Eigen::Index of_point, Eigen::Index row, const Eigen::Vector3d& gradient) {
    for (Eigen::Index k = 0; k < 3; ++k) {
      if (slots.empty())
        triplets.emplace_back(static_cast<int>(3 * of_point + k), static_cast<int>(row), gradient[k]);
      else
        K.valuePtr()[slots[next++]] = gradient[k];
    }
  }

  /// K of the triplets; their numbers in place of values tell where each of them went.
  void make_pattern() {
    const std::vector<Eigen::Triplet<double>> given = std::move(triplets);
    for (std::size_t k = 0; k < given.size(); ++k)
      triplets.emplace_back(given[k].row(), given[k].col(), static_cast<double>(k));
    K.setFromTriplets(triplets.begin(), triplets.end());
    slots.resize(given.size());
    for (Eigen::Index slot = 0; slot < K.nonZeros(); ++slot) slots[static_cast<std::size_t>(K.valuePtr()[slot])] = slot;
    for (std::size_t k = 0; k < given.size(); ++k) K.valuePtr()[slots[k]] = given[k].value();
    triplets = {};
  }

  /// w for K and phi as they are.
  const double* solve() {
    const bool is_first = slots.empty();
    if (is_first) make_pattern();
    const Eigen::SparseMatrix<double> S = K.transpose() * inverse_masses.asDiagonal() * K;
    if (is_first) factor.analyzePattern(S);
    factor.factorize(S);
    const Eigen::VectorXd lambda = factor.solve(-(phi + K.transpose() * inverse_masses.cwiseProduct(f)));
    w = inverse_masses.cwiseProduct(f + K * lambda);
    next = 0;
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
  // u = a/|a|, phi = (v.v - (u.v)^2)/|a|
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
