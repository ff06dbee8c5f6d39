#pragma once

#include <Eigen/Sparse>

#include "problem.hpp"

namespace rivals {

/// The constraints and their rates as equations of a differential-algebraic system of index 2 (Gear, Gupta &
/// Leimkuhler 1985) for equal masses, by hand, with its Newton matrix on a fixed pattern:
///
///     r' = v - K mu,  m v' = f - K lambda - B tau,  K'v = 0,  xi(r) = (|d|^2 - length^2)/2 = 0,
///     |d| - length + (c B'v - tau)/k = 0 of the springs,  y = (r, v, lambda, mu, tau)
///
/// Weight and drag are f; B holds the units e = d/|d| of the springs, whose forces tau are unknowns as those of rods
/// are
/// (inserted, they make a run up to 2.5 times as long).
class StabilisedForm {
 public:
  explicit StabilisedForm(const Problem& problem) : problem_(problem), n_(3 * problem.size()) {
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

  int unknowns() const { return 2 * (n_ + problem_.equations()) + num_springs(); }

  /// Computes F(y, y'): r' - v + K mu, m v' - f + K lambda + B tau, K'v, xi, |d| - length + (c B'v - tau)/k.
  void residual(const double* y, const double* slope, double* out) const {
    for (int i = 0; i < n_; ++i) {
      const double weight = i % 3 == 2 ? problem_.mass * problem_.gravity : 0.0;
      out[i] = slope[i] - y[n_ + i];
      out[n_ + i] = problem_.mass * slope[n_ + i] + problem_.drag * y[n_ + i] + weight;
    }
    for (int k = 0; k < num_springs(); ++k) {
      const Spring spring = evaluate_spring(k, y);
      const double tau = y[row_of_tau(k)];
      out[row_of_tau(k)] = spring.size - problem_.length + (problem_.damping * spring.rate - tau) / problem_.stiffness;
      for (int c = 0; c < 3; ++c) {
        for_each_end(problem_.springs[k],
                     [&](int point, double sign) { out[n_ + 3 * point + c] += sign * spring.e[c] * tau; });
      }
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

  /// Returns dF/dy + a dF/dy'.
  const Eigen::SparseMatrix<double>& newton_matrix(const double* y, double a) {
    std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
    auto slot = slots_.begin();
    for_each_entry(y, a, [&](int, int, double value) { matrix_.valuePtr()[*slot++] += value; });
    return matrix_;
  }

 private:
  int row_of_lambda(int k) const { return 2 * n_ + k; }
  int row_of_mu(int k) const { return 2 * n_ + problem_.equations() + k; }
  int row_of_tau(int k) const { return 2 * (n_ + problem_.equations()) + k; }
  int num_springs() const { return static_cast<int>(problem_.springs.size()); }

  struct Spring {
    double size, rate;  // |d|, e.u
    Place e, turning;   // d/|d| and its rate (u - e e.u)/|d|
  };
  Spring evaluate_spring(int k, const double* y) const {
    const Place d = problem_.difference(problem_.springs[k], y, true);
    const Place u = problem_.difference(problem_.springs[k], y + n_, false);
    Spring spring;
    // The distance is 0 where only the pattern is asked for.
    spring.size = std::max(std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), 1e-300);
    for (int c = 0; c < 3; ++c) spring.e[c] = d[c] / spring.size;
    spring.rate = spring.e[0] * u[0] + spring.e[1] * u[1] + spring.e[2] * u[2];
    for (int c = 0; c < 3; ++c) spring.turning[c] = (u[c] - spring.e[c] * spring.rate) / spring.size;
    return spring;
  }

  /// Calls visit(point, dd/dr_point) at the ends that move.
  template <class Visit>
  static void for_each_end(const Rod& rod, const Visit& visit) {
    visit(rod.j, 1.0);
    if (rod.i >= 0) visit(rod.i, -1.0);
  }

  /// Calls add(row, column, value), always in the same order.
  template <class Add>
  void for_each_entry(const double* y, double a, const Add& add) const {
    for (int i = 0; i < n_; ++i) {
      add(i, i, a);
      add(i, n_ + i, -1.0);
      add(n_ + i, n_ + i, a * problem_.mass + problem_.drag);
    }
    for (int k = 0; k < num_springs(); ++k) add_spring(k, y, add);
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

  /// Adds d(e tau)/dr = tau (1 - e e')/|d|, d|d|/dr = e, d(e.u)/dr = turning, d(e.u)/du = e.
  template <class Add>
  void add_spring(int k, const double* y, const Add& add) const {
    const Spring spring = evaluate_spring(k, y);
    const int row = row_of_tau(k);
    const double relaxation = problem_.damping / problem_.stiffness;  // s
    add(row, row, -1.0 / problem_.stiffness);
    for_each_end(problem_.springs[k], [&](int point, double sign) {
      for (int i = 0; i < 3; ++i) {
        const int r = 3 * point + i, v = n_ + r;
        add(v, row, sign * spring.e[i]);
        add(row, r, sign * (spring.e[i] + relaxation * spring.turning[i]));
        add(row, v, sign * relaxation * spring.e[i]);
        for_each_end(problem_.springs[k], [&](int other, double other_sign) {
          for (int j = 0; j < 3; ++j) {
            const double across = (i == j ? 1.0 : 0.0) - spring.e[i] * spring.e[j];
            add(v, 3 * other + j, sign * other_sign * y[row] * across / spring.size);
          }
        });
      }
    });
  }

  const Problem& problem_;
  int n_;
  Eigen::SparseMatrix<double> matrix_;
  std::vector<int> slots_;  // of each entry, in their order
};

}  // namespace rivals
