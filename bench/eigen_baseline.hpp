#pragma once

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

#include <array>
#include <vector>

/// What anybody would write first with Eigen: K from triplets, S = K'M^-1K by sparse products, SimplicialLDLT whose
/// analysis is kept, w = M^-1 (f + K lambda). Gravity, no supports. The yardstick of the benchmarks.
class EigenStep {
 public:
  std::vector<Eigen::Triplet<double>> triplets;  ///< of K
  Eigen::VectorXd phi;

  EigenStep(const std::vector<double>& masses, Eigen::Vector3d gravity)
      : inverse_masses_(3 * masses.size()), f_(3 * masses.size()) {
    for (std::size_t i = 0; i < masses.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        inverse_masses_[static_cast<Eigen::Index>(3 * i + k)] = 1.0 / masses[i];
        f_[static_cast<Eigen::Index>(3 * i + k)] = masses[i] * gravity[static_cast<Eigen::Index>(k)];
      }
    }
  }

  /// w [3n] for K and phi as they are.
  const Eigen::VectorXd& solve() {
    Eigen::SparseMatrix<double> K(f_.size(), phi.size());
    K.setFromTriplets(triplets.begin(), triplets.end());
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

  static Eigen::Vector3d point(const double* x, int k) { return Eigen::Map<const Eigen::Vector3d>(x + 3 * k); }
  void add(int point, Eigen::Index row, const Eigen::Vector3d& gradient) {
    for (int k = 0; k < 3; ++k) triplets.emplace_back(3 * point + k, static_cast<int>(row), gradient[k]);
  }

 private:
  Eigen::VectorXd inverse_masses_, f_, w_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor_;
  bool analyzed_ = false;
};

/// Rods.
class EigenBaseline {
 public:
  EigenBaseline(std::vector<std::array<int, 2>> rods, const std::vector<double>& masses, Eigen::Vector3d gravity)
      : rods_(std::move(rods)), step_(masses, gravity) {}

  /// Accelerations [3n] at (r, v).
  const Eigen::VectorXd& evaluate(const double* r, const double* v) {
    step_.triplets.clear();
    step_.phi.resize(static_cast<Eigen::Index>(rods_.size()));
    for (Eigen::Index a = 0; a < step_.phi.size(); ++a) {
      const auto [i, j] = rods_[static_cast<std::size_t>(a)];
      const Eigen::Vector3d d = EigenStep::point(r, j) - EigenStep::point(r, i);
      const Eigen::Vector3d dv = EigenStep::point(v, j) - EigenStep::point(v, i);
      const double length = d.norm();
      const Eigen::Vector3d u = d / length;
      step_.phi[a] = (dv.squaredNorm() - u.dot(dv) * u.dot(dv)) / length;
      step_.add(i, a, -u);
      step_.add(j, a, u);
    }
    return step_.solve();
  }

 private:
  std::vector<std::array<int, 2>> rods_;
  EigenStep step_;
};

/// Points, each on its own sphere around the origin, or on its own circle around the z axis.
class EigenBeads {
 public:
  enum class Guide { Sphere, Circle };
  EigenBeads(Guide guide, const std::vector<double>& masses, Eigen::Vector3d gravity)
      : guide_(guide), num_points_(static_cast<int>(masses.size())), step_(masses, gravity) {}

  const Eigen::VectorXd& evaluate(const double* r, const double* v) {
    const Eigen::Index rows_each = guide_ == Guide::Sphere ? 1 : 2;
    step_.triplets.clear();
    step_.phi.resize(rows_each * num_points_);
    for (int i = 0; i < num_points_; ++i) {
      Eigen::Vector3d d = EigenStep::point(r, i), b = EigenStep::point(v, i);
      Eigen::Index row = rows_each * i;
      if (guide_ == Guide::Circle) {
        step_.phi[row] = 0.0;
        step_.add(i, row++, Eigen::Vector3d::UnitZ());
        d[2] = b[2] = 0.0;
      }
      const double length = d.norm();
      const Eigen::Vector3d u = d / length;
      step_.phi[row] = (b.squaredNorm() - u.dot(b) * u.dot(b)) / length;
      step_.add(i, row, u);
    }
    return step_.solve();
  }

 private:
  Guide guide_;
  int num_points_;
  EigenStep step_;
};
