#pragma once

#include <cmath>
#include <vector>

#include "evaluate/family.hpp"

namespace tanor {

/// sum over the tuple of c.r - value: tuples of any size, gradients constant. Same interface as Family.
class LinearFamily {
 public:
  std::vector<Index> start{0};      ///< [member] first of its points
  std::vector<Index> points;        ///< tuples one after the other
  std::vector<Vec3> coefficients;   ///< beside `points`
  std::vector<double> norms;        ///< [member] largest |c| of its tuple
  ScalarTable value;                ///< [member]
  std::vector<Index> rows;          ///< [member]
  Index first_block = 0;
  double scene_size = 1.0;

  std::size_t size() const { return rows.size(); }

  double scale(std::size_t) const { return scene_size; }
  void set_time(double t) { value.set_time(t); }
  bool depends_on_time() const { return !value.is_constant(); }

  double evaluate_values(const Parallel&, const double* r, double* xi) const {
    double worst = 0.0;
    for (std::size_t k = 0; k < size(); ++k) {
      xi[rows[k]] = transposed(k, r) - value[k].value;
      worst = larger(worst, std::abs(xi[rows[k]]) / (norms[k] * scene_size));
    }
    return worst;
  }

  double evaluate_rates(const Parallel&, const double*, const double* v, double* rate) const {
    double worst = 0.0;
    for (std::size_t k = 0; k < size(); ++k) {
      rate[rows[k]] = transposed(k, v) - value[k].first;
      worst = larger(worst, std::abs(rate[rows[k]]) / norms[k]);
    }
    return worst;
  }

  void evaluate_gradients(const Parallel&, const double*, double* blocks) const {
    for (std::size_t i = 0; i < points.size(); ++i) store(blocks, first_block + i, coefficients[i]);
  }

  template <bool WithGradients>
  double evaluate_right_side(const Parallel& parallel, const double* r, const double*, const double* w0, double* phi,
                             double* blocks) const {
    double worst = 0.0;
    for (std::size_t k = 0; k < size(); ++k) {
      phi[rows[k]] = transposed(k, w0) - value[k].second;
      worst = larger(worst, std::abs(phi[rows[k]]) / norms[k]);
    }
    if constexpr (WithGradients) evaluate_gradients(parallel, r, blocks);
    return worst;
  }

  double apply_transposed(const Parallel&, const double*, const double* x, const double* shift, double* y) const {
    double worst = 0.0;
    for (std::size_t k = 0; k < size(); ++k) {
      y[rows[k]] = transposed(k, x) + (shift != nullptr ? shift[rows[k]] : 0.0);
      worst = larger(worst, std::abs(y[rows[k]]) / norms[k]);
    }
    return worst;
  }

  void measure(const double* r, const double* v, double* position, double* velocity) const {
    for (std::size_t k = 0; k < size(); ++k) {
      position[rows[k]] = std::abs(transposed(k, r) - value[k].value) / (norms[k] * scene_size);
      velocity[rows[k]] = std::abs(transposed(k, v) - value[k].first) / norms[k];
    }
  }

  template <class Append>
  void list_incidences(const Append& append) const {
    for (std::size_t k = 0; k < size(); ++k) {
      for (Index i = start[k]; i < start[k + 1]; ++i) append(Incidence{points[i], rows[k], first_block + i, 1.0});
    }
  }

 private:
  double transposed(std::size_t k, const double* x) const {
    double sum = 0.0;
    for (Index i = start[k]; i < start[k + 1]; ++i) sum += dot(coefficients[i], load(x, points[i]));
    return sum;
  }
};

}  // namespace tanor
