#pragma once

#include <algorithm>
#include <vector>

#include <tanor/system.hpp>

#include "base/index_ranges.hpp"
#include "base/parallel.hpp"
#include "kinds/kernel.hpp"

namespace tanor::detail {

/// The position of a block of K: column `row` of K has `sign * blocks[block]` at `point`.
struct Incidence {
  Index point, row, block;
  double sign;
};

/// All constraints of one kind as a structure of arrays. Each quantity is one loop over the members, without virtual
/// calls and allocations. The output index is the row, so members may run in any order and on any thread. `members` are
/// those that take part.
template <class Kernel>
class Family {
 public:
  static constexpr int P = Kernel::num_points, R = Kernel::num_rows, B = Kernel::num_blocks;

  Kernel kernel;
  std::vector<Index> rows;  ///< [member] first row
  Index first_block = 0;

  std::size_t size() const { return rows.size(); }
  std::size_t num_blocks() const { return size() * B; }
  static std::size_t num_blocks_of(std::size_t) { return B; }

  /// Evaluates xi; returns the largest relative violation |xi|/|gradient|/length.
  double evaluate_values(const Parallel& parallel, const IndexRanges& members, const double* r, double* xi) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        const auto local = kernel(k, r, r);
        for (int m = 0; m < R; ++m) {
          xi[rows[k] + m] = local.xi[m];
          worst = larger(worst, std::abs(local.xi[m]) / (norm_of(local, m) * kernel.scale(k)));
        }
      }
      return worst;
    });
  }

  /// Evaluates rate = K'v + xi_t; returns the largest |rate|/|gradient|, m/s.
  double evaluate_rates(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                        double* rate) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        const auto local = kernel(k, r, v);
        for (int m = 0; m < R; ++m) {
          rate[rows[k] + m] = local.rate[m];
          worst = larger(worst, std::abs(local.rate[m]) / norm_of(local, m));
        }
      }
      return worst;
    });
  }

  /// Writes the blocks of K.
  void evaluate_gradients(const Parallel& parallel, const IndexRanges& members, const double* r, double* blocks) const {
    members.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) store_gradient(k, kernel(k, r, r), blocks);
    });
  }

  /// Evaluates phi + K'w0, minus the right-hand side of S lambda, and writes the blocks of K if they are wanted.
  /// Returns the largest |.|/|gradient|, m/s^2.
  template <bool WithGradients>
  double evaluate_right_side(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                             const double* w0, double* phi, double* blocks) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        const auto local = kernel(k, r, v);
        for (int m = 0; m < R; ++m) {
          const double value = local.phi[m] + transposed(k, m, local.gradient, w0);
          phi[rows[k] + m] = value;
          worst = larger(worst, std::abs(value) / norm_of(local, m));
        }
        if constexpr (WithGradients) store_gradient(k, local, blocks);
      }
      return worst;
    });
  }

  /// Computes y = K'x + shift from stored blocks; returns the largest |y|/|gradient|. A null `shift` is 0.
  double apply_transposed(const Parallel& parallel, const IndexRanges& members, const double* blocks, const double* x,
                          const double* shift, double* y) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        Vec3 gradient[B];
        for (int b = 0; b < B; ++b) gradient[b] = load(blocks, block(k) + b);
        for (int m = 0; m < R; ++m) {
          double norm2 = 0.0;
          for (int b = m * P; b < (m + 1) * P && !Kernel::unit_gradient; ++b)
            norm2 = std::max(norm2, dot(gradient[b], gradient[b]));
          const double value = transposed(k, m, gradient, x) + (shift != nullptr ? shift[rows[k] + m] : 0.0);
          y[rows[k] + m] = value;
          worst = larger(worst, Kernel::unit_gradient ? std::abs(value) : std::abs(value) / std::sqrt(norm2));
        }
      }
      return worst;
    });
  }

  /// Writes |xi|/|gradient|/length and |rate|/|gradient| of each row, to find the worst one.
  void measure(const double* r, const double* v, double* position, double* velocity) const {
    for (std::size_t k = 0; k < size(); ++k) {
      const auto local = kernel(k, r, v);
      for (int m = 0; m < R; ++m) {
        position[rows[k] + m] = std::abs(local.xi[m]) / (norm_of(local, m) * kernel.scale(k));
        velocity[rows[k] + m] = std::abs(local.rate[m]) / norm_of(local, m);
      }
    }
  }

  void write_lengths(double* lengths) const {
    for (std::size_t k = 0; k < size(); ++k) std::fill_n(lengths + rows[k], R, kernel.scale(k));
  }

  template <class Append>
  void list_incidences(const Append& append) const {
    for (std::size_t k = 0; k < size(); ++k) {
      for (int m = 0; m < R; ++m) {
        for (int p = 0; p < P; ++p) {
          append(Incidence{kernel.points[k][p], rows[k] + m, block(k) + local_block(m, p), sign(p)});
        }
      }
    }
  }

 private:
  // A rod has one block for both points, with opposite signs; all others have one for each row and point.
  static constexpr bool antisymmetric = B < R * P;
  static constexpr Index local_block(int m, int p) { return antisymmetric ? 0 : m * P + p; }
  static constexpr double sign(int p) { return antisymmetric && p == 0 ? -1.0 : 1.0; }

  Index block(std::size_t k) const { return first_block + static_cast<Index>(k) * B; }

  template <class L>
  static double norm_of(const L& local, int m) {
    return Kernel::unit_gradient ? 1.0 : local.gradient_norm[m];
  }

  template <class L>
  void store_gradient(std::size_t k, const L& local, double* blocks) const {
    for (int b = 0; b < B; ++b) store(blocks, block(k) + b, local.gradient[b]);
  }

  /// Returns row m of K'x.
  double transposed(std::size_t k, int m, const Vec3* gradient, const double* x) const {
    const auto& points = kernel.points[k];
    if constexpr (antisymmetric) {
      return dot(gradient[0], load(x, points[1]) - load(x, points[0]));
    } else {
      double sum = 0.0;
      for (int p = 0; p < P; ++p) sum += dot(gradient[m * P + p], load(x, points[p]));
      return sum;
    }
  }
};

}  // namespace tanor::detail
