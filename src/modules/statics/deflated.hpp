#pragma once

#include <Eigen/Core>
#include <utility>

namespace tanor::detail {

/// The operator (1 - V V') A (1 - V V') as Spectra's solvers take it. Its eigenvalues are those of A except the ones of
/// the invariant space that the orthonormal columns of V span.
template <class Apply>
class Deflated {
 public:
  using Scalar = double;

  /// apply(from, to) computes A x [rows]; V [rows, any number] must outlive the operator.
  Deflated(const Eigen::MatrixXd& V, Apply apply) : V_(V), apply_(std::move(apply)) {}
  Eigen::Index rows() const { return V_.rows(); }
  Eigen::Index cols() const { return V_.rows(); }
  void perform_op(const double* from, double* to) const {
    Eigen::Map<Eigen::VectorXd> result(to, rows());
    Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(from, rows());
    x -= V_ * (V_.transpose() * x);
    apply_(x.data(), to);
    for (int twice = 0; twice < 2; ++twice) result -= V_ * (V_.transpose() * result);
  }

 private:
  const Eigen::MatrixXd& V_;
  Apply apply_;
};

}  // namespace tanor::detail
