#include "factor/sparse_lu.hpp"

#include <klu.h>

#include <new>
#include <type_traits>
#include <utility>

#include "base/check.hpp"

namespace tanor::detail {

/// KLU's objects, and its functions for one type of numbers. It takes complex numbers as pairs.
template <class T>
struct SparseLu<T>::Klu {
  klu_common common{};
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;

  ~Klu() {
    klu_free_numeric(&numeric, &common);
    klu_free_symbolic(&symbolic, &common);
  }

  template <class Real, class Complex>
  static auto choose(Real real, Complex complex) {
    if constexpr (std::is_same_v<T, double>)
      return real;
    else
      return complex;
  }
  static double* numbers(T* x) { return reinterpret_cast<double*>(x); }

  void check() const {
    if (common.status == KLU_OUT_OF_MEMORY || common.status == KLU_TOO_LARGE) throw std::bad_alloc();
    ensure(common.status >= KLU_OK, "KLU takes the matrices that we build");
  }
  bool is_finite() {
    choose(klu_rcond, klu_z_rcond)(symbolic, numeric, &common);
    return common.rcond > 0.0;  // false for NaN
  }
};

template <class T>
SparseLu<T>::SparseLu(SquarePattern pattern)
    : pattern_(std::move(pattern)), values_(pattern_.rows.size()), klu_(std::make_unique<Klu>()) {
  klu_defaults(&klu_->common);
  klu_->common.ordering = 1;  // COLAMD: several times less fill on saddle point matrices than AMD (measured)
  klu_->common.halt_if_singular = 1;
  klu_->symbolic =
      klu_analyze(static_cast<int>(pattern_.size()), pattern_.start.data(), pattern_.rows.data(), &klu_->common);
  klu_->check();
}

template <class T>
SparseLu<T>::~SparseLu() = default;

template <class T>
bool SparseLu<T>::factorize() {
  if (factorize_again() || factorize_anew()) return true;
  forget_pivots();
  return false;
}

/// Factorizes with new pivots.
template <class T>
bool SparseLu<T>::factorize_anew() {
  forget_pivots();
  ++num_pivotings_;
  klu_->numeric = Klu::choose(klu_factor, klu_z_factor)(pattern_.start.data(), pattern_.rows.data(),
                                                        Klu::numbers(values()), klu_->symbolic, &klu_->common);
  klu_->check();
  return klu_->numeric != nullptr && klu_->common.status == KLU_OK && klu_->is_finite();
}

/// Factorizes with the pivots of an earlier factorization. They serve while the reciprocal pivot growth, the least max
/// |a|/max |u| of a column, is above a limit.
template <class T>
bool SparseLu<T>::factorize_again() {
  constexpr double least_growth = 1e-8;
  if (!has_factor()) return false;
  const auto call = [&](auto function) {
    return function(pattern_.start.data(), pattern_.rows.data(), Klu::numbers(values()), klu_->symbolic, klu_->numeric,
                    &klu_->common) != 0;
  };
  if (!call(Klu::choose(klu_refactor, klu_z_refactor)) || klu_->common.status != KLU_OK) return false;
  if (!call(Klu::choose(klu_rgrowth, klu_z_rgrowth))) return false;
  return klu_->common.rgrowth > least_growth && klu_->is_finite();
}

template <class T>
void SparseLu<T>::forget_pivots() {
  klu_free_numeric(&klu_->numeric, &klu_->common);  // of either type
}

template <class T>
bool SparseLu<T>::has_factor() const {
  return klu_->numeric != nullptr;
}

template <class T>
void SparseLu<T>::solve(T* x) {
  ensure(has_factor(), "a factor is there before it solves");
  Klu::choose(klu_solve, klu_z_solve)(klu_->symbolic, klu_->numeric, static_cast<int>(pattern_.size()), 1,
                                      Klu::numbers(x), &klu_->common);
  klu_->check();
}

template class SparseLu<double>;
template class SparseLu<std::complex<double>>;

}  // namespace tanor::detail
