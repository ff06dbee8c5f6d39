#include "factor/sparse_lu.hpp"

#include <klu.h>

#include <new>
#include <type_traits>
#include <utility>

#include "base/check.hpp"

namespace tanor::detail {

template <class T>
struct SparseLu<T>::Implementation {
  static constexpr bool is_complex = !std::is_same_v<T, double>;
  /// The pivots of another matrix serve while the reciprocal pivot growth, the least max |a|/max |u| of a column, is
  /// above this.
  static constexpr double least_growth = 1e-8;

  SquarePattern pattern;
  std::vector<T> values;
  klu_common common{};
  klu_symbolic* symbolic = nullptr;
  klu_numeric* numeric = nullptr;
  std::size_t num_pivotings = 0;

  explicit Implementation(SquarePattern given) : pattern(std::move(given)), values(pattern.rows.size()) {
    klu_defaults(&common);
    common.ordering = 1;  // COLAMD: several times less fill on saddle point matrices than AMD (measured)
    common.halt_if_singular = 1;
    symbolic = klu_analyze(size(), pattern.start.data(), pattern.rows.data(), &common);
    check();
  }
  ~Implementation() {
    free_numeric();
    klu_free_symbolic(&symbolic, &common);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  int size() { return static_cast<int>(pattern.size()); }
  /// KLU takes complex numbers as pairs.
  double* numbers() { return reinterpret_cast<double*>(values.data()); }

  void check() const {
    if (common.status == KLU_OUT_OF_MEMORY || common.status == KLU_TOO_LARGE) throw std::bad_alloc();
    ensure(common.status >= KLU_OK, "KLU takes the matrices that we build");
  }

  void free_numeric() {
    if (numeric == nullptr) return;
    if constexpr (is_complex)
      klu_z_free_numeric(&numeric, &common);
    else
      klu_free_numeric(&numeric, &common);
  }

  /// Factorizes with new pivots.
  bool factorize_anew() {
    free_numeric();
    ++num_pivotings;
    if constexpr (is_complex)
      numeric = klu_z_factor(pattern.start.data(), pattern.rows.data(), numbers(), symbolic, &common);
    else
      numeric = klu_factor(pattern.start.data(), pattern.rows.data(), numbers(), symbolic, &common);
    check();
    return numeric != nullptr && common.status == KLU_OK && is_finite();
  }

  /// Factorizes with the pivots of an earlier factorization.
  bool factorize_again() {
    if (numeric == nullptr) return false;
    int* const start = pattern.start.data();
    int* const rows = pattern.rows.data();
    if constexpr (is_complex) {
      if (!klu_z_refactor(start, rows, numbers(), symbolic, numeric, &common)) return false;
      if (common.status != KLU_OK || !klu_z_rgrowth(start, rows, numbers(), symbolic, numeric, &common)) return false;
    } else {
      if (!klu_refactor(start, rows, numbers(), symbolic, numeric, &common)) return false;
      if (common.status != KLU_OK || !klu_rgrowth(start, rows, numbers(), symbolic, numeric, &common)) return false;
    }
    return common.rgrowth > least_growth && is_finite();
  }

  bool is_finite() {
    if constexpr (is_complex)
      klu_z_rcond(symbolic, numeric, &common);
    else
      klu_rcond(symbolic, numeric, &common);
    return common.rcond > 0.0;  // false for NaN
  }
};

template <class T>
SparseLu<T>::SparseLu(SquarePattern pattern) : implementation_(std::make_unique<Implementation>(std::move(pattern))) {}

template <class T>
SparseLu<T>::SparseLu(SparseLu&&) noexcept = default;
template <class T>
SparseLu<T>& SparseLu<T>::operator=(SparseLu&&) noexcept = default;
template <class T>
SparseLu<T>::~SparseLu() = default;

template <class T>
const SquarePattern& SparseLu<T>::pattern() const {
  return implementation_->pattern;
}
template <class T>
T* SparseLu<T>::values() {
  return implementation_->values.data();
}
template <class T>
std::size_t SparseLu<T>::num_pivotings() const {
  return implementation_->num_pivotings;
}

template <class T>
bool SparseLu<T>::factorize() {
  Implementation& self = *implementation_;
  if (self.factorize_again() || self.factorize_anew()) return true;
  self.free_numeric();
  return false;
}

template <class T>
void SparseLu<T>::forget_pivots() {
  implementation_->free_numeric();
}

template <class T>
bool SparseLu<T>::has_factor() const {
  return implementation_->numeric != nullptr;
}

template <class T>
void SparseLu<T>::solve(T* x) {
  Implementation& self = *implementation_;
  ensure(self.numeric != nullptr, "a factor is there before it solves");
  const int n = self.size();
  double* const numbers = reinterpret_cast<double*>(x);
  if constexpr (Implementation::is_complex)
    klu_z_solve(self.symbolic, self.numeric, n, 1, numbers, &self.common);
  else
    klu_solve(self.symbolic, self.numeric, n, 1, numbers, &self.common);
  self.check();
}

template class SparseLu<double>;
template class SparseLu<std::complex<double>>;

}  // namespace tanor::detail
