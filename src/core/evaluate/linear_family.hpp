#pragma once

#include <cmath>
#include <vector>

#include "evaluate/family.hpp"
#include "kinds/linear_kernel.hpp"

namespace tanor::detail {

/// Linear constraints on tuples of any size. The interface is that of Family.
class LinearFamily {
 public:
  LinearKernel kernel;
  std::vector<Index> rows;  ///< [member]
  Index first_block = 0;

  std::size_t size() const { return rows.size(); }

  double evaluate_values(const Parallel& parallel, const IndexRanges& members, const double* r, double* xi) const {
    return fill(
        parallel, members, xi, [&](std::size_t k) { return kernel.transposed(k, r) - kernel.value[k].value; },
        [&](std::size_t k) { return kernel.size[k]; });
  }

  double evaluate_rates(const Parallel& parallel, const IndexRanges& members, const double*, const double* v,
                        double* rate) const {
    return fill(parallel, members, rate,
                [&](std::size_t k) { return kernel.transposed(k, v) - kernel.value[k].first; });
  }

  void evaluate_gradients(const Parallel& parallel, const IndexRanges& members, const double*, double* blocks) const {
    members.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      for (Index i = kernel.start[begin]; i < kernel.start[end]; ++i)
        store(blocks, first_block + i, kernel.coefficients[i]);
    });
  }

  template <bool WithGradients>
  double evaluate_right_side(const Parallel& parallel, const IndexRanges& members, const double* r, const double*,
                             const double* w0, double* phi, double* blocks) const {
    if constexpr (WithGradients) evaluate_gradients(parallel, members, r, blocks);
    return fill(parallel, members, phi,
                [&](std::size_t k) { return kernel.transposed(k, w0) - kernel.value[k].second; });
  }

  double apply_transposed(const Parallel& parallel, const IndexRanges& members, const double*, const double* x,
                          const double* shift, double* y) const {
    return fill(parallel, members, y,
                [&](std::size_t k) { return kernel.transposed(k, x) + (shift != nullptr ? shift[rows[k]] : 0.0); });
  }

  void measure(const double* r, const double* v, double* position, double* velocity) const {
    for (std::size_t k = 0; k < size(); ++k) {
      position[rows[k]] =
          std::abs(kernel.transposed(k, r) - kernel.value[k].value) / (kernel.norms[k] * kernel.size[k]);
      velocity[rows[k]] = std::abs(kernel.transposed(k, v) - kernel.value[k].first) / kernel.norms[k];
    }
  }

  void write_lengths(double* lengths) const {
    for (std::size_t k = 0; k < size(); ++k) lengths[rows[k]] = kernel.size[k];
  }

  template <class Append>
  void list_incidences(const Append& append) const {
    for (std::size_t k = 0; k < size(); ++k) {
      for (Index i = kernel.start[k]; i < kernel.start[k + 1]; ++i) {
        append(Incidence{kernel.points[i], rows[k], first_block + i, 1.0});
      }
    }
  }

 private:
  struct One {
    double operator()(std::size_t) const { return 1.0; }
  };
  /// Writes y[row] = value(k) of each member k; returns the largest |y|/|gradient|/length.
  template <class RowValue, class Length = One>
  double fill(const Parallel& parallel, const IndexRanges& members, double* y, const RowValue& value,
              const Length& length = {}) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        y[rows[k]] = value(k);
        worst = larger(worst, std::abs(y[rows[k]]) / (kernel.norms[k] * length(k)));
      }
      return worst;
    });
  }
};

}  // namespace tanor::detail
