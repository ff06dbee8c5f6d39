#pragma once

#include <Eigen/Sparse>

#include "problem.hpp"

namespace rivals {

/// The constraints and their rates as equations of a differential-algebraic system of index 2 (Gear, Gupta &
/// Leimkuhler 1985) for equal masses, by hand, with its Newton matrix on a fixed pattern:
///
///     r' = v - K mu,  m v' = f - K lambda,  K'v = 0,  xi(r) = (|d|^2 - length^2)/2 = 0,  y = (r, v, lambda, mu)
class StabilisedForm {
 public:
  explicit StabilisedForm(const Problem& problem) : problem_(problem), n_(3 * problem.size()), f_(problem.places.size()) {
    std::vector<Eigen::Triplet<double>> pattern;
    const std::vector<double> zero(static_cast<std::size_t>(unknowns()));
    for_each_entry(zero.data(), 1.0, [&](int row, int column, double) { pattern.emplace_back(row, column, 1.0); });
    matrix_.resize(unknowns(), unknowns());
    matrix_.setFromTriplets(pattern.begin(), pattern.end());
    for (const auto& entry : pattern) {
      const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[entry.col()];
      const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[entry.col() + 1];
      slots_.push_back(static_cast<int>(std::lower_bound(begin, end, entry.row()) - matrix_.innerIndexPtr()));
    }
  }

  int unknowns() const { return 2 * (n_ + problem_.equations()); }

  /// F(y, y'): r' - v + K mu, m v' - f + K lambda, K'v, xi
  void residual(const double* y, const double* slope, double* out) {
    problem_.forces(y, y + n_, f_.data());
    for (int i = 0; i < n_; ++i) {
      out[i] = slope[i] - y[n_ + i];
      out[n_ + i] = problem_.mass * slope[n_ + i] - f_[static_cast<std::size_t>(i)];
    }
    for (int k = 0; k < problem_.equations(); ++k) {
      const Rod& rod = problem_.rods[k];
      const Place d = problem_.difference(rod, y, true), u = problem_.difference(rod, y + n_, false);
      double xi = -0.5 * problem_.length * problem_.length, rate = 0.0;
      for (int c = 0; c < 3; ++c) {
        xi += 0.5 * d[c] * d[c];
        rate += d[c] * u[c];
        for_each_end(rod, [&](int point, double sign) {
          out[3 * point + c] += sign * d[c] * y[row_of_mu(k)];
          out[n_ + 3 * point + c] += sign * d[c] * y[row_of_lambda(k)];
        });
      }
      out[row_of_lambda(k)] = rate;
      out[row_of_mu(k)] = xi;
    }
  }

  /// dF/dy + a dF/dy'
  const Eigen::SparseMatrix<double>& newton_matrix(const double* y, double a) {
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
    auto slot = slots_.begin();
    for_each_entry(y, a, [&](int, int, double value) { matrix_.valuePtr()[*slot++] += value; });
    return matrix_;
  }

 private:
  int row_of_lambda(int k) const { return 2 * n_ + k; }
  int row_of_mu(int k) const { return 2 * n_ + problem_.equations() + k; }

  /// visit(point, dd/dr_point) at the ends that move
  template <class Visit>
  static void for_each_end(const Rod& rod, const Visit& visit) {
    visit(rod.j, 1.0);
    if (rod.i >= 0) visit(rod.i, -1.0);
  }

  /// add(row, column, value), always in the same order
  template <class Add>
  void for_each_entry(const double* y, double a, const Add& add) const {
    for (int i = 0; i < n_; ++i) {
      add(i, i, a);
      add(i, n_ + i, -1.0);
      add(n_ + i, n_ + i, a * problem_.mass + problem_.drag);
    }
    for (const Rod& spring : problem_.springs) {
      add_spring(spring, problem_.difference(spring, y, true), problem_.difference(spring, y + n_, false), add);
    }
    for (int k = 0; k < problem_.equations(); ++k) {
      const Rod& rod = problem_.rods[k];
      const int lambda = row_of_lambda(k), mu = row_of_mu(k);
      const Place d = problem_.difference(rod, y, true), u = problem_.difference(rod, y + n_, false);
      for (int c = 0; c < 3; ++c) {
        for_each_end(rod, [&](int point, double sign) {
          const int r = 3 * point + c, v = n_ + r;
          add(r, mu, sign * d[c]);
          add(v, lambda, sign * d[c]);
          add(lambda, r, sign * u[c]);
          add(lambda, v, sign * d[c]);
          add(mu, r, sign * d[c]);
          for_each_end(rod, [&](int other, double other_sign) {
            add(r, 3 * other + c, sign * other_sign * y[mu]);
            add(v, 3 * other + c, sign * other_sign * y[lambda]);
          });
        });
      }
    }
  }

  /// Of a spring with e = d/|d|, E = e e', p = (E - 1) u/|d|, s = e.u:
  ///
  ///     -df/dr = k (E + (1 - l/|d|) (1 - E)) + c (s (1 - E)/|d| - e p'),   -df/dv = c E
  template <class Add>
  void add_spring(const Rod& spring, const Place& d, const Place& u, const Add& add) const {
    const double size = std::max(std::hypot(d[0], d[1], d[2]), 1e-300);  // 0 where only the pattern is asked for
    const Place e{d[0] / size, d[1] / size, d[2] / size};
    const double s = e[0] * u[0] + e[1] * u[1] + e[2] * u[2], c = problem_.damping;
    const double along = problem_.stiffness, across = along * (1.0 - problem_.length / size) + c * s / size;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double E = e[i] * e[j], p = (e[j] * s - u[j]) / size;
        const double by_r = along * E + across * ((i == j ? 1.0 : 0.0) - E) - c * e[i] * p;
        for_each_end(spring, [&](int point, double sign) {
          for_each_end(spring, [&](int other, double other_sign) {
            add(n_ + 3 * point + i, 3 * other + j, sign * other_sign * by_r);
            add(n_ + 3 * point + i, n_ + 3 * other + j, sign * other_sign * c * E);
          });
        });
      }
    }
  }

  const Problem& problem_;
  int n_;
  std::vector<double> f_;  // N
  Eigen::SparseMatrix<double> matrix_;
  std::vector<int> slots_;  // of each entry, in their order
};

}  // namespace rivals
