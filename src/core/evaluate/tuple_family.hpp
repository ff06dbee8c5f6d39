#pragma once

#include <cmath>
#include <vector>

#include "evaluate/family.hpp"
#include "kinds/tuple_kernels.hpp"

namespace tanor::detail {

/// Constraints with one row each on tuples of any size. The interface is that of Family.
template <class Kernel>
class TupleFamily {
 public:
  Kernel kernel;
  std::vector<Index> rows;  ///< [member]
  Index first_block = 0;

  std::size_t size() const { return rows.size(); }
  std::size_t num_blocks() const { return kernel.points.size(); }
  std::size_t num_blocks_of(std::size_t k) const { return kernel.tuple(k).size(); }

  double evaluate_values(const Parallel& parallel, const IndexRanges& members, const double* r, double* xi) const {
    return kernel.evaluate(parallel, members, r, nullptr, [&](std::size_t k, const auto& row) {
      xi[rows[k]] = row.xi();
      return std::abs(xi[rows[k]]) / (row.norm() * kernel.scale(k));
    });
  }

  double evaluate_rates(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                        double* rate) const {
    return kernel.evaluate(parallel, members, r, v, [&](std::size_t k, const auto& row) {
      rate[rows[k]] = row.rate();
      return std::abs(rate[rows[k]]) / row.norm();
    });
  }

  void evaluate_gradients(const Parallel& parallel, const IndexRanges& members, const double* r, double* blocks) const {
    (void)kernel.evaluate(parallel, members, r, nullptr, [&](std::size_t k, const auto& row) {
      store_gradient(k, row.gradient(), blocks);
      return 0.0;
    });
  }

  /// Evaluates phi + K'w0, and the blocks of K if they are wanted.
  template <bool WithGradients>
  double evaluate_right_side(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
                             const double* w0, double* phi, double* blocks) const {
    return kernel.evaluate(parallel, members, r, v, [&](std::size_t k, const auto& row) {
      phi[rows[k]] = row.phi() + kernel.transposed(k, row.gradient(), w0);
      if constexpr (WithGradients) store_gradient(k, row.gradient(), blocks);
      return std::abs(phi[rows[k]]) / row.norm();
    });
  }

  double apply_transposed(const Parallel& parallel, const IndexRanges& members, const double* blocks, const double* x,
                          const double* shift, double* y) const {
    return members.max_over_ranges(parallel, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      for (std::size_t k = begin; k < end; ++k) {
        const double* const gradient = blocks + 3 * block(k);
        y[rows[k]] = kernel.transposed(k, gradient, x) + (shift != nullptr ? shift[rows[k]] : 0.0);
        worst = larger(worst, std::abs(y[rows[k]]) / kernel.norm(k, gradient));
      }
      return worst;
    });
  }

  void measure(const double* r, const double* v, double* position, double* velocity) const {
    (void)kernel.evaluate(Parallel(1), IndexRanges(size()), r, v, [&](std::size_t k, const auto& row) {
      position[rows[k]] = std::abs(row.xi()) / (row.norm() * kernel.scale(k));
      velocity[rows[k]] = std::abs(row.rate()) / row.norm();
      return 0.0;
    });
  }

  void write_lengths(double* lengths) const {
    for (std::size_t k = 0; k < size(); ++k) lengths[rows[k]] = kernel.scale(k);
  }

  template <class Append>
  void list_incidences(const Append& append) const {
    for (std::size_t k = 0; k < size(); ++k) {
      Index next = first_block + kernel.start[k];
      for (const Index point : kernel.tuple(k)) append(Incidence{point, rows[k], next++, 1.0});
    }
  }

  /// Returns the first block of member k.
  std::size_t block(std::size_t k) const { return static_cast<std::size_t>(first_block + kernel.start[k]); }

 private:
  void store_gradient(std::size_t k, const double* gradient, double* blocks) const {
    for (std::size_t i = 0; i < num_blocks_of(k); ++i) store(blocks, block(k) + i, load(gradient, i));
  }
};

}  // namespace tanor::detail
