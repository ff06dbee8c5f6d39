#include "schur/conjugate_gradients.hpp"

#include <algorithm>

namespace tanor::detail {

ConjugateGradients::ConjugateGradients(const GramOperator& S) : S_(S) {
  for (std::vector<double>* array : {&rho_, &z_, &p_, &q_}) array->resize(S.constraints.num_rows(), 0.0);
}

/// Computes dw = M^-1 K lambda and rho = S lambda + b.
void ConjugateGradients::start(const Parallel& parallel, const double* blocks, const double* b, double* lambda,
                               double* dw) {
  std::fill(lambda + S_.num_rows, lambda + rho_.size(), 0.0);
  finish(parallel, blocks, lambda, dw);
  S_.constraints.apply_transposed(parallel, blocks, dw, b, rho_.data());
}

/// Returns x'y. Eight sums run side by side, so that additions need not wait for those before.
double ConjugateGradients::dot(const Parallel& parallel, const std::vector<double>& x,
                               const std::vector<double>& y) const {
  constexpr std::size_t width = 8;
  const double *const a = x.data(), *const b = y.data();
  const std::size_t whole = S_.num_rows / width;
  double result = parallel.sum(
      whole,
      [&](std::size_t k) {
        const double *const u = a + width * k, *const v = b + width * k;
        return ((u[0] * v[0] + u[1] * v[1]) + (u[2] * v[2] + u[3] * v[3])) +
               ((u[4] * v[4] + u[5] * v[5]) + (u[6] * v[6] + u[7] * v[7]));
      },
      1024);
  for (std::size_t k = width * whole; k < S_.num_rows; ++k) result += a[k] * b[k];
  return result;
}

/// Computes p = z + beta p, lambda += alpha p and rho += alpha S p. Returns false if p'S p is not positive. dw is
/// scratch.
bool ConjugateGradients::advance(const Parallel& parallel, const double* blocks, double error2, double beta,
                                 double* lambda, double* dw) {
  parallel.for_ranges(S_.num_rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) p_[a] = z_[a] + beta * p_[a];
  });
  S_.gather.write_scaled(parallel, blocks, p_.data(), S_.inverse_mass.data(), S_.num_moving, dw);
  S_.constraints.apply_transposed(parallel, blocks, dw, nullptr, q_.data());
  const double curvature = dot(parallel, p_, q_);
  if (!(curvature > 0.0)) return false;
  const double alpha = error2 / curvature;
  parallel.for_ranges(S_.num_rows, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      lambda[a] += alpha * p_[a];
      rho_[a] += alpha * q_[a];
    }
  });
  return true;
}

void ConjugateGradients::finish(const Parallel& parallel, const double* blocks, const double* lambda,
                                double* dw) const {
  S_.gather.write_scaled(parallel, blocks, lambda, S_.inverse_mass.data(), S_.num_moving, dw);
}

}  // namespace tanor::detail
