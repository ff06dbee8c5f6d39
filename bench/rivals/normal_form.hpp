#pragma once

#include <Eigen/Sparse>

#include "problem.hpp"

namespace rivals {

/// The normal form as a careful user writes it by hand for equal masses. S = K'K/m has a fixed pattern, with each entry
/// straight from the two rods that meet there, and is factorized by Eigen's SimplicialLDLT; xi = (|d|^2 - length^2)/2.
class NormalForm {
 public:
  explicit NormalForm(const Problem& problem)
      : problem_(problem), d_(problem.rods.size()), f_(problem.places.size()), b_(problem.equations()) {
    std::vector<std::vector<int>> rods_at(static_cast<std::size_t>(problem.size()));
    for (int k = 0; k < problem.equations(); ++k) {
      for (const int point : {problem.rods[k].i, problem.rods[k].j}) {
        if (point >= 0) rods_at[point].push_back(k);
      }
    }
    // An entry is d_a.d_b times +1/m where both begin or both end at the point they share, and times -1/m otherwise.
    std::vector<Eigen::Triplet<double>> weights;
    for (std::size_t point = 0; point < rods_at.size(); ++point) {
      const auto sign = [&](int k) { return problem.rods[k].j == static_cast<int>(point) ? 1.0 : -1.0; };
      for (const int a : rods_at[point]) {
        for (const int b : rods_at[point]) {
          if (a >= b) weights.emplace_back(a, b, sign(a) * sign(b) / problem.mass);
        }
      }
    }
    S_.resize(problem.equations(), problem.equations());
    S_.setFromTriplets(weights.begin(), weights.end());
    weights_.assign(S_.valuePtr(), S_.valuePtr() + S_.nonZeros());
    solver_.analyzePattern(S_);
  }

  long factorizations() const { return factorizations_; }

  /// Computes w = (f - K lambda)/m with S lambda = phi + K'f/m, at a position and velocity.
  void accelerations(const double* r, const double* v, double* w) {
    factorize(r);
    if (problem_.is_stiff()) return accelerations_under_forces(r, v, w);
    for (int k = 0; k < problem_.equations(); ++k) {
      const Place u = problem_.difference(problem_.rods[k], v, false);
      b_[k] = dot(u, u) - (problem_.rods[k].i < 0 ? d_[k][2] * problem_.gravity : 0.0);
    }
    for (int i = 0; i < 3 * problem_.size(); ++i) w[i] = i % 3 == 2 ? -problem_.gravity : 0.0;
    add_correction(w);
  }

  /// Returns lambda, N/m, of the last accelerations.
  const Eigen::VectorXd& multipliers() const { return b_; }

  /// Solves xi(r) = 0 by Newton's method to a share of the length, then removes the normal part of v.
  void project(double* r, double* v, double tolerance) {
    const double length2 = problem_.length * problem_.length;
    for (int pass = 0; pass < 10; ++pass) {
      factorize(r);
      double worst = 0.0;
      for (int k = 0; k < problem_.equations(); ++k) {
        b_[k] = 0.5 * (dot(d_[k], d_[k]) - length2);
        worst = std::max(worst, std::abs(b_[k]));
      }
      if (worst <= std::max(tolerance, 1e-14) * length2) break;
      add_correction(r);
    }
    remove_normal_part(v);
  }

  /// Computes u -= M^-1 K S^-1 K'u with the present factor.
  void remove_normal_part(double* u) {
    for (int k = 0; k < problem_.equations(); ++k) b_[k] = dot(d_[k], problem_.difference(problem_.rods[k], u, false));
    add_correction(u);
  }

 private:
  void accelerations_under_forces(const double* r, const double* v, double* w) {
    problem_.forces(r, v, f_.data());
    for (std::size_t i = 0; i < f_.size(); ++i) w[i] = f_[i] / problem_.mass;
    for (int k = 0; k < problem_.equations(); ++k) {
      const Place u = problem_.difference(problem_.rods[k], v, false);
      b_[k] = dot(u, u) + dot(d_[k], problem_.difference(problem_.rods[k], w, false));
    }
    add_correction(w);
  }

  static double dot(const Place& a, const Place& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

  void factorize(const double* r) {
    for (std::size_t k = 0; k < d_.size(); ++k) d_[k] = problem_.difference(problem_.rods[k], r, true);
    for (int column = 0; column < S_.outerSize(); ++column) {
      for (int p = S_.outerIndexPtr()[column]; p < S_.outerIndexPtr()[column + 1]; ++p) {
        S_.valuePtr()[p] = weights_[p] * dot(d_[column], d_[S_.innerIndexPtr()[p]]);
      }
    }
    solver_.factorize(S_);
    ++factorizations_;
  }

  /// Computes u -= M^-1 K S^-1 b.
  void add_correction(double* u) {
    b_ = solver_.solve(b_).eval();
    for (std::size_t k = 0; k < d_.size(); ++k) {
      const Rod& rod = problem_.rods[k];
      for (int c = 0; c < 3; ++c) {
        const double change = b_[static_cast<Eigen::Index>(k)] * d_[k][c] / problem_.mass;
        u[3 * rod.j + c] -= change;
        if (rod.i >= 0) u[3 * rod.i + c] += change;
      }
    }
  }

  const Problem& problem_;
  std::vector<Place> d_;
  std::vector<double> f_;  // N
  std::vector<double> weights_;
  Eigen::VectorXd b_;
  Eigen::SparseMatrix<double> S_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>> solver_;
  long factorizations_ = 0;
};

}  // namespace rivals
