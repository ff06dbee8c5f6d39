#pragma once

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

#include <array>
#include <vector>

/// What anybody would write first with Eigen: K from triplets, S = K'M^-1K by sparse products, SimplicialLDLT whose
/// analysis is kept, w = M^-1 (f + K lambda). Rods and points without supports, gravity. The yardstick of the
/// benchmarks.
class EigenBaseline {
 public:
  EigenBaseline(std::vector<std::array<int, 2>> rods, const std::vector<double>& masses, Eigen::Vector3d gravity)
      : rods_(std::move(rods)), inverse_masses_(3 * masses.size()), f_(3 * masses.size()) {
    for (std::size_t i = 0; i < masses.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        inverse_masses_[static_cast<Eigen::Index>(3 * i + k)] = 1.0 / masses[i];
        f_[static_cast<Eigen::Index>(3 * i + k)] = masses[i] * gravity[static_cast<Eigen::Index>(k)];
      }
    }
  }

  /// Accelerations [3n] at (r, v).
  const Eigen::VectorXd& evaluate(const double* r, const double* v) {
    const auto num_rods = static_cast<Eigen::Index>(rods_.size());
    triplets_.clear();
    Eigen::VectorXd phi(num_rods);
    for (Eigen::Index a = 0; a < num_rods; ++a) {
      const auto [i, j] = rods_[static_cast<std::size_t>(a)];
      const auto point = [](const double* x, int k) { return Eigen::Map<const Eigen::Vector3d>(x + 3 * k); };
      const Eigen::Vector3d d = point(r, j) - point(r, i), dv = point(v, j) - point(v, i);
      const double length = d.norm();
      const Eigen::Vector3d u = d / length;
      phi[a] = (dv.squaredNorm() - u.dot(dv) * u.dot(dv)) / length;
      for (int k = 0; k < 3; ++k) {
        triplets_.emplace_back(3 * i + k, static_cast<int>(a), -u[k]);
        triplets_.emplace_back(3 * j + k, static_cast<int>(a), u[k]);
      }
    }
    Eigen::SparseMatrix<double> K(f_.size(), num_rods);
    K.setFromTriplets(triplets_.begin(), triplets_.end());
    const Eigen::SparseMatrix<double> S = K.transpose() * inverse_masses_.asDiagonal() * K;
    if (!analyzed_) {
      factor_.analyzePattern(S);
      analyzed_ = true;
    }
    factor_.factorize(S);
    const Eigen::VectorXd lambda = factor_.solve(-(phi + K.transpose() * inverse_masses_.cwiseProduct(f_)));
    w_ = inverse_masses_.cwiseProduct(f_ + K * lambda);
    return w_;
  }

 private:
  std::vector<std::array<int, 2>> rods_;
  Eigen::VectorXd inverse_masses_, f_, w_;
  std::vector<Eigen::Triplet<double>> triplets_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  bool analyzed_ = false;
};
