#include "factor/cholesky.hpp"

#include <cholmod.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "base/check.hpp"

namespace tanor {

namespace {

/// A cholmod_common with every choice made by us.
struct Common {
  cholmod_common c;

  Common() {
    cholmod_start(&c);
    c.print = 0;
    c.final_ll = 1;  // LL': with LDL' an indefinite matrix would pass as CHOLMOD_OK
    c.final_asis = 0;
    c.nmethods = 1;
    c.quick_return_if_not_posdef = 1;
  }
  ~Common() { cholmod_finish(&c); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;

  void check() const {
    if (c.status == CHOLMOD_OUT_OF_MEMORY || c.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
    ensure(c.status >= CHOLMOD_OK, "CHOLMOD takes the matrices that we build");
  }
};

/// CHOLMOD starts four threads in its supernodal loops whatever it is told; we share the cores by parts instead.
class OneThread {
 public:
  OneThread() { omp_set_max_active_levels(0); }
  ~OneThread() { omp_set_max_active_levels(before_); }
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int before_ = omp_get_max_active_levels();
};

/// CHOLMOD's view of our arrays; nothing is copied.
cholmod_sparse view(const TrianglePattern& pattern, double* values, bool lower) {
  cholmod_sparse a{};
  a.nrow = a.ncol = pattern.size();
  a.nzmax = pattern.rows.size();
  a.p = const_cast<int*>(pattern.start.data());
  a.i = const_cast<int*>(pattern.rows.data());
  a.x = values;
  a.stype = lower ? -1 : 1;
  a.itype = CHOLMOD_INT;
  a.xtype = values != nullptr ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

SymbolicAnalysis analyze_with(const TrianglePattern& lower, Ordering ordering) {
  Common common;
  cholmod_common& c = common.c;
  c.supernodal = CHOLMOD_SIMPLICIAL;
  c.postorder = ordering != Ordering::Natural;
  c.method[0].ordering = ordering == Ordering::Amd      ? CHOLMOD_AMD
                         : ordering == Ordering::Metis  ? CHOLMOD_METIS
                         : ordering == Ordering::Nesdis ? CHOLMOD_NESDIS
                                                        : CHOLMOD_NATURAL;
  cholmod_sparse a = view(lower, nullptr, true);
  cholmod_factor* factor = cholmod_analyze(&a, &c);
  common.check();
  SymbolicAnalysis result;
  result.ordering = ordering;
  result.factor_nonzeros = c.lnz;
  result.flops = c.fl;
  if (ordering != Ordering::Natural) {
    const int* permutation = static_cast<const int*>(factor->Perm);
    result.permutation.assign(permutation, permutation + factor->n);
  }
  cholmod_free_factor(&factor, &c);
  return result;
}

}  // namespace

SymbolicAnalysis analyze(const TrianglePattern& lower, Ordering wanted) {
  // From flops per nonzero near 80 on, dense blocks repay their overhead (measured; CHOLMOD's own default is 40).
  constexpr double supernodal_switch = 80.0;
  constexpr double metis_switch = 100.0;
  SymbolicAnalysis best = analyze_with(lower, wanted == Ordering::Auto ? Ordering::Natural : wanted);
  if (wanted == Ordering::Auto && best.factor_nonzeros > static_cast<double>(lower.rows.size())) {
    const auto try_ordering = [&](Ordering ordering) {
      SymbolicAnalysis other = analyze_with(lower, ordering);
      if (other.flops < best.flops) best = std::move(other);
    };
    try_ordering(Ordering::Amd);
    if (best.flops > metis_switch * best.factor_nonzeros) try_ordering(Ordering::Metis);
  }
  best.supernodal = best.flops > supernodal_switch * best.factor_nonzeros;
  return best;
}

struct Cholesky::Implementation {
  TrianglePattern pattern;
  std::vector<double> values;
  Common common;
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;
  std::vector<double> unit_lower, inverse_pivots;  // simplicial: L D^-1 beside L's entries, D^-2
  cholmod_dense* solution = nullptr;               // kept workspace of cholmod_solve2
  cholmod_dense* y = nullptr;
  cholmod_dense* e = nullptr;

  /// CHOLMOD's arrays of a simplicial L: columns [start, start + count), the diagonal first.
  struct Columns {
    std::size_t n;
    const int *start, *count, *rows;
    const double* values;
  };
  Columns simplicial() const {
    return {factor->n, static_cast<const int*>(factor->p), static_cast<const int*>(factor->nz),
            static_cast<const int*>(factor->i), static_cast<const double*>(factor->x)};
  }
  void prepare_solves();
  std::size_t weakest_column() const;
  void solve_simplicial(double* x) const;

  ~Implementation() {
    cholmod_free_dense(&e, &common.c);
    cholmod_free_dense(&y, &common.c);
    cholmod_free_dense(&solution, &common.c);
    cholmod_free_factor(&factor, &common.c);
  }
};

/// L = (L D^-1) D with D its diagonal: solves then divide by nothing, and the chain of dependent operations along a
/// path is one multiplication and one subtraction a row.
void Cholesky::Implementation::prepare_solves() {
  const auto [n, start, count, rows, l] = simplicial();
  unit_lower.resize(factor->nzmax);
  inverse_pivots.resize(n);
  for (std::size_t j = 0; j < n; ++j) {
    const double inverse = 1.0 / l[start[j]];
    inverse_pivots[j] = inverse * inverse;
    for (int k = start[j] + 1; k < start[j] + count[j]; ++k) unit_lower[static_cast<std::size_t>(k)] = l[k] * inverse;
  }
}

/// Column of the smallest pivot: where a matrix that is singular to rounding shows it.
std::size_t Cholesky::Implementation::weakest_column() const {
  if (!factor->is_super) {
    return static_cast<std::size_t>(std::max_element(inverse_pivots.begin(), inverse_pivots.end()) -
                                    inverse_pivots.begin());
  }
  // A supernode's columns lie side by side, its diagonal block first: stride (number of rows) + 1.
  const int* first_column = static_cast<const int*>(factor->super);
  const int* rows_start = static_cast<const int*>(factor->pi);
  const int* values_start = static_cast<const int*>(factor->px);
  const double* l = static_cast<const double*>(factor->x);
  std::size_t weakest = 0;
  double smallest = HUGE_VAL;
  for (std::size_t s = 0; s < factor->nsuper; ++s) {
    const int num_rows = rows_start[s + 1] - rows_start[s];
    for (int j = first_column[s]; j < first_column[s + 1]; ++j) {
      const double pivot = l[values_start[s] + (j - first_column[s]) * (num_rows + 1)];
      if (pivot < smallest) {
        smallest = pivot;
        weakest = static_cast<std::size_t>(j);
      }
    }
  }
  return weakest;
}

/// In place; cholmod_solve2 would copy x twice.
void Cholesky::Implementation::solve_simplicial(double* x) const {
  const auto [n, start, count, rows, l] = simplicial();
  const double* const u = unit_lower.data();
  // (L D^-1) y = x
  for (std::size_t j = 0; j < n; ++j) {
    const double xj = x[j];
    int k = start[j] + 1;
    const int end = start[j] + count[j];
    // Two columns of one pattern, as fill makes them, run through x together.
    if (count[j] > 4 && rows[k] == static_cast<int>(j) + 1 && count[j + 1] + 1 == count[j]) {
      const double* const next = u + start[j + 1] - k;
      const double xn = x[j + 1] -= u[k] * xj;
      for (++k; k < end; ++k) x[rows[k]] -= u[k] * xj + next[k] * xn;
      ++j;
      continue;
    }
    for (; k < end; ++k) x[rows[k]] -= u[k] * xj;
  }
  // (L D^-1)' x = D^-2 y
  for (std::size_t j = n; j-- > 0;) {
    double sum = x[j] * inverse_pivots[j];
    int k = start[j] + 1;
    const int end = start[j] + count[j];
    if (end - k >= 4) {  // four sums beside each other: a subtraction need not wait for the one before
      double a = 0.0, b = 0.0, c = 0.0;
      for (; k + 3 < end; k += 4) {
        sum -= u[k] * x[rows[k]];
        a -= u[k + 1] * x[rows[k + 1]];
        b -= u[k + 2] * x[rows[k + 2]];
        c -= u[k + 3] * x[rows[k + 3]];
      }
      sum = (sum + a) + (b + c);
    }
    for (; k < end; ++k) sum -= u[k] * x[rows[k]];
    x[j] = sum;
  }
}

Cholesky::Cholesky(TrianglePattern pattern, bool supernodal) : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.pattern = std::move(pattern);
  self.values.resize(self.pattern.rows.size());
  cholmod_common& c = self.common.c;
  c.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
  c.method[0].ordering = CHOLMOD_NATURAL;
  c.postorder = 0;
  self.matrix = view(self.pattern, self.values.data(), supernodal);
  self.factor = cholmod_analyze(&self.matrix, &c);
  self.common.check();
}

Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;
Cholesky::~Cholesky() = default;

const TrianglePattern& Cholesky::pattern() const {
  return implementation_->pattern;
}
double* Cholesky::values() {
  return implementation_->values.data();
}

Cholesky::Quality Cholesky::factorize() {
  Implementation& self = *implementation_;
  cholmod_common& c = self.common.c;
  const OneThread one_thread;
  cholmod_factorize(&self.matrix, self.factor, &c);
  self.common.check();
  // Read the status first: cholmod_rcond overwrites it.
  if (c.status == CHOLMOD_NOT_POSDEF || self.factor->minor < self.factor->n) {
    return {false, self.factor->minor, 0.0};
  }
  if (!self.factor->is_super) self.prepare_solves();
  return {true, self.weakest_column(), cholmod_rcond(self.factor, &c)};
}

void Cholesky::solve(double* x) {
  Implementation& self = *implementation_;
  const std::size_t n = self.pattern.size();
  if (!self.factor->is_super) {
    self.solve_simplicial(x);
    return;
  }
  cholmod_dense b{};
  b.nrow = b.d = b.nzmax = n;
  b.ncol = 1;
  b.x = x;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  const OneThread one_thread;
  cholmod_solve2(CHOLMOD_A, self.factor, &b, nullptr, &self.solution, nullptr, &self.y, &self.e, &self.common.c);
  self.common.check();
  std::memcpy(x, self.solution->x, n * sizeof(double));
}

}  // namespace tanor
