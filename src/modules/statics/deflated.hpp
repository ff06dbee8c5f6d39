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

/// Returns a start for Spectra's Lanczos method, and the unit in which it takes the operator. Spectra makes its second
/// vector orthogonal to the first one, the image of the start, without a check. So the start has as little of the
/// largest eigenvalue as the image needs to have as much of it as of the others. Should all be equal, the second vector
/// is rounding, which Spectra takes for 0 below that of 1.
template <class Operation>
Eigen::VectorXd find_start(const Operation& operation, const Eigen::VectorXd& any, double* unit) {
  constexpr double rounding = 1e-12, well_below_one = 64.0;
  const auto multiply = [&](const Eigen::VectorXd& x) {
    Eigen::VectorXd y(x.size());
    operation.perform_op(x.data(), y.data());
    return y;
  };
  const Eigen::VectorXd a = multiply(any).normalized(), b = multiply(a);
  const double largest = a.dot(b);
  const Eigen::VectorXd others = b - largest * a;
  const bool has_others = others.norm() > rounding * largest;
  const Eigen::VectorXd start = has_others ? Eigen::VectorXd(others + multiply(others).norm() / largest * a) : a;
  *unit = well_below_one * largest;
  return start;
}

}  // namespace tanor::detail
