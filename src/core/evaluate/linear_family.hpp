#pragma once

#include <cmath>
#include <vector>

#include "evaluate/family.hpp"
#include "kinds/linear_kernel.hpp"

namespace tanor::detail {

/// Linear constraints on tuples of any size.
class LinearFamily : public RowLoops<LinearFamily> {
 public:
  LinearKernel kernel;
  std::vector<Index> rows;  ///< [member]
  Index first_block = 0;

  std::size_t size() const { return rows.size(); }

  template <class Take>
  double visit(const Parallel& parallel, const IndexRanges& members, const double* r, const double* v,
               const Take& take) const {
    return find_largest(parallel, members, [&](std::size_t k) {
      return take(Member{kernel, k, rows[k], first_block, r, v}, 0);
    });
  }
  /// The gradients are constant, and those of the kernel are the stored ones.
  template <class Take>
  double visit_stored(const Parallel& parallel, const IndexRanges& members, const double*, const Take& take) const {
    return visit(parallel, members, nullptr, nullptr, take);
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
  struct Member {
    const LinearKernel& kernel;
    std::size_t k;
    Index row, first_block;
    const double *r, *v;

    double xi(int) const { return kernel.transposed(k, r) - kernel.value[k].value; }
    double rate(int) const { return kernel.transposed(k, v) - kernel.value[k].first; }
    double phi(int) const { return -kernel.value[k].second; }
    double norm(int) const { return kernel.norms[k]; }
    double scale() const { return kernel.size[k]; }
    double transposed(int, const double* x) const { return kernel.transposed(k, x); }
    void store(int, double* blocks) const {
      for (Index i = kernel.start[k]; i < kernel.start[k + 1]; ++i)
        detail::store(blocks, first_block + i, kernel.coefficients[i]);
    }
  };
};

}  // namespace tanor::detail
