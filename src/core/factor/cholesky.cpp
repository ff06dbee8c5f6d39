#include "factor/cholesky.hpp"

#include <cholmod.h>

#include <algorithm>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "base/check.hpp"
#include "base/counts.hpp"
#include "factor/inertia.hpp"
#include "factor/multifrontal.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

/// A cholmod_common with every choice made by us.
struct Common {
  cholmod_common c;

  Common() {
    cholmod_start(&c);
    c.print = 0;
    c.final_ll = 1;  // LL', because with LDL' an indefinite matrix would pass as CHOLMOD_OK
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

/// Returns CHOLMOD's view of our arrays. Nothing is copied.
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

/// Analyzes a pattern with one ordering. `given`, [place] -> row, is an ordering that CHOLMOD does not know.
SymbolicAnalysis analyze_with(const TrianglePattern& lower, Ordering ordering, std::vector<int> given = {}) {
  Common common;
  cholmod_common& c = common.c;
  c.supernodal = CHOLMOD_SIMPLICIAL;
  c.postorder = ordering != Ordering::Natural;
  c.method[0].ordering = ordering == Ordering::Amd       ? CHOLMOD_AMD
                         : ordering == Ordering::Metis   ? CHOLMOD_METIS
                         : ordering == Ordering::Nesdis  ? CHOLMOD_NESDIS
                         : ordering == Ordering::Natural ? CHOLMOD_NATURAL
                                                         : CHOLMOD_GIVEN;
  cholmod_sparse a = view(lower, nullptr, true);
  cholmod_factor* factor = cholmod_analyze_p(&a, given.empty() ? nullptr : given.data(), nullptr, 0, &c);
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

SymbolicAnalysis analyze_with(const TrianglePattern& lower, Ordering wanted, const RowsInSpace& points) {
  const bool needs_points = wanted == Ordering::Axes || wanted == Ordering::Points;
  if (!needs_points) return analyze_with(lower, wanted);
  if (points.num_rows() != lower.size()) return analyze_with(lower, Ordering::Metis);
  const bool along_axes = wanted == Ordering::Axes;
  return analyze_with(lower, wanted, along_axes ? dissect_along_axes(points).order : dissect_graph(points).order);
}

/// Returns the ordering of fewest flops among those that are worth their time, for a pattern that has fill in the order
/// of `natural`.
SymbolicAnalysis find_best(const TrianglePattern& lower, const SymbolicAnalysis& natural,
                           const FindPoints& find_points) {
  SymbolicAnalysis best;
  best.flops = std::numeric_limits<double>::infinity();
  const auto keep_better = [&](SymbolicAnalysis other) {
    if (other.flops < best.flops) best = std::move(other);
  };
  const auto is_worth_dissection = [](const SymbolicAnalysis& result) {
    return result.flops > plan::flops_for_dissection * result.factor_nonzeros;
  };
  const auto is_worth = [&](double flops_a_nonzero) {
    return best.flops > flops_a_nonzero * static_cast<double>(lower.rows.size());
  };
  bool has_amd = false;
  const auto try_amd = [&] {
    if (!std::exchange(has_amd, true)) keep_better(analyze_with(lower, Ordering::Amd));
  };
  // On many rows AMD takes as long as cuts along axes do, and does better only where these are bad or there is little
  // to cut.
  if (lower.size() < plan::rows_worth_axes_first || !is_worth_dissection(natural)) {
    try_amd();
    if (!is_worth_dissection(best)) return best;
  }
  const RowsInSpace points = find_points ? find_points() : RowsInSpace{};
  if (points.num_rows() != lower.size()) {
    try_amd();
    if (is_worth_dissection(best)) keep_better(analyze_with(lower, Ordering::Metis));
    return best;
  }
  const Dissection along_axes = dissect_along_axes(points);
  keep_better(analyze_with(lower, Ordering::Axes, along_axes.order));
  if (!is_worth_dissection(best)) try_amd();
  if (has_amd && !is_worth(plan::flops_worth_metis)) return best;
  if (first_cut_of_graph(points) >= plan::clearly_better_cut * along_axes.first_cut) return best;
  try_amd();
  if (!is_worth(plan::flops_worth_metis)) return best;
  keep_better(analyze_with(lower, Ordering::Points, points));
  if (is_worth(plan::flops_worth_metis_on_rows)) keep_better(analyze_with(lower, Ordering::Metis));
  return best;
}

}  // namespace

SymbolicAnalysis analyze(const TrianglePattern& lower, Ordering wanted, const FindPoints& find_points) {
  const bool is_free = wanted == Ordering::Auto;
  SymbolicAnalysis result = is_free ? analyze_with(lower, Ordering::Natural)
                                    : analyze_with(lower, wanted, find_points ? find_points() : RowsInSpace{});
  if (is_free && result.factor_nonzeros > static_cast<double>(lower.rows.size())) {
    SymbolicAnalysis best = find_best(lower, result, find_points);
    if (best.flops < result.flops) result = std::move(best);
  }
  result.supernodal = result.flops > plan::flops_for_fronts * result.factor_nonzeros;
  // Fronts count what they store by size_t; CHOLMOD counts the entries of a simplicial L by int.
  if (!result.supernodal)
    check_count(result.factor_nonzeros, "S of " + std::to_string(lower.size()) + " rows", "nonzeros of L");
  return result;
}

std::optional<std::size_t> count_negative_eigenvalues(const TrianglePattern& upper, std::vector<double> values) {
  Common common;
  cholmod_common& c = common.c;
  c.final_ll = 0;  // L D L', which an indefinite matrix may have too
  c.supernodal = CHOLMOD_SIMPLICIAL;
  c.quick_return_if_not_posdef = 0;
  c.method[0].ordering = CHOLMOD_NATURAL;
  c.postorder = 0;
  cholmod_sparse matrix = view(upper, values.data(), false);
  cholmod_factor* factor = cholmod_analyze(&matrix, &c);
  common.check();
  cholmod_factorize(&matrix, factor, &c);
  common.check();
  std::optional<std::size_t> negative = 0;
  if (c.status == CHOLMOD_NOT_POSDEF || factor->minor < factor->n || factor->is_ll) negative.reset();
  for (std::size_t j = 0; negative && j < factor->n; ++j) {
    const double pivot = static_cast<const double*>(factor->x)[static_cast<const int*>(factor->p)[j]];
    if (pivot < 0.0) ++*negative;
  }
  cholmod_free_factor(&factor, &c);
  return negative;
}

struct Cholesky::Implementation {
  TrianglePattern pattern;
  std::vector<double> values;
  std::optional<Multifrontal> fronts;  // the supernodal factor; the members below belong to a simplicial one
  Common common;
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;
  std::vector<double> unit_lower, inverse_pivots;  // L D^-1 beside L's entries, D^-2; empty if CHOLMOD solves
  bool is_solved_by_cholmod = false;
  cholmod_dense *solution = nullptr, *rooms[2] = {nullptr, nullptr};  // of CHOLMOD's solves

  /// CHOLMOD's arrays of a simplicial L. Column j has the entries [start[j], start[j] + count[j]), its diagonal first.
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
  void solve_simplicial(double* x) const;
  void solve_by_cholmod(double* x);
  std::size_t find_weakest_column() const;

  ~Implementation() {
    cholmod_free_factor(&factor, &common.c);
    for (cholmod_dense** dense : {&solution, &rooms[0], &rooms[1]}) cholmod_free_dense(dense, &common.c);
  }
};

/// Splits L = (L D^-1) D with its diagonal D. Solves then need no division, and the chain of dependent operations along
/// a path has one multiplication and one subtraction for each row.
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

/// Solves in place; cholmod_solve2 would copy x twice.
void Cholesky::Implementation::solve_simplicial(double* x) const {
  const auto [n, start, count, rows, l] = simplicial();
  const double* const u = unit_lower.data();
  // (L D^-1) y = x
  for (std::size_t j = 0; j < n; ++j) {
    const double xj = x[j];
    for (int k = start[j] + 1; k < start[j] + count[j]; ++k) x[rows[k]] -= u[k] * xj;
  }
  // (L D^-1)' x = D^-2 y from the last row on. Only the last subtraction of a row waits for the number found just
  // before.
  for (std::size_t j = n; j-- > 0;) {
    double sum = x[j] * inverse_pivots[j];
    for (int k = start[j] + count[j]; --k > start[j];) sum -= u[k] * x[rows[k]];
    x[j] = sum;
  }
}

void Cholesky::Implementation::solve_by_cholmod(double* given) {
  cholmod_dense b{};
  b.nrow = b.d = b.nzmax = pattern.size();
  b.ncol = 1;
  b.x = given;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_solve2(CHOLMOD_A, factor, &b, nullptr, &solution, nullptr, &rooms[0], &rooms[1], &common.c);
  common.check();
  std::copy_n(static_cast<const double*>(solution->x), b.nrow, given);
}

/// Returns the column of the smallest number on the diagonal of CHOLMOD's L.
std::size_t Cholesky::Implementation::find_weakest_column() const {
  const Columns columns = simplicial();
  std::size_t weakest = 0;
  for (std::size_t j = 1; j < columns.n; ++j) {
    if (columns.values[columns.start[j]] < columns.values[columns.start[weakest]]) weakest = j;
  }
  return weakest;
}

Cholesky::Cholesky(TrianglePattern pattern, bool supernodal, bool by_cholmod)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  self.pattern = std::move(pattern);
  self.values.resize(self.pattern.rows.size());
  self.is_solved_by_cholmod = by_cholmod;
  if (supernodal) {
    self.fronts.emplace(self.pattern);
    return;
  }
  cholmod_common& c = self.common.c;
  c.supernodal = CHOLMOD_SIMPLICIAL;
  c.method[0].ordering = CHOLMOD_NATURAL;
  c.postorder = 0;
  self.matrix = view(self.pattern, self.values.data(), false);
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

Cholesky::Quality Cholesky::factorize(int threads) {
  Implementation& self = *implementation_;
  if (self.fronts) {
    const std::size_t done = self.fronts->factorize(self.pattern, self.values.data(), threads);
    if (done < self.pattern.size()) return {false, done, 0.0};
    const auto [weakest, strongest] = std::minmax_element(self.fronts->pivots().begin(), self.fronts->pivots().end());
    const double ratio = *weakest / *strongest;
    return {true, static_cast<std::size_t>(weakest - self.fronts->pivots().begin()), ratio * ratio};
  }
  cholmod_common& c = self.common.c;
  cholmod_factorize(&self.matrix, self.factor, &c);
  self.common.check();
  // Read the status first: cholmod_rcond overwrites it.
  if (c.status == CHOLMOD_NOT_POSDEF || self.factor->minor < self.factor->n) {
    return {false, self.factor->minor, 0.0};
  }
  if (self.is_solved_by_cholmod) return {true, self.find_weakest_column(), cholmod_rcond(self.factor, &c)};
  self.prepare_solves();
  // A matrix that is singular to rounding shows it at its smallest pivot.
  const auto weakest = std::max_element(self.inverse_pivots.begin(), self.inverse_pivots.end());
  return {true, static_cast<std::size_t>(weakest - self.inverse_pivots.begin()), cholmod_rcond(self.factor, &c)};
}

void Cholesky::solve(double* x, int threads) {
  if (implementation_->fronts) {
    implementation_->fronts->solve(x, threads);
  } else if (implementation_->is_solved_by_cholmod) {
    implementation_->solve_by_cholmod(x);
  } else {
    implementation_->solve_simplicial(x);
  }
}

bool Cholesky::factorizes_by_threads() const {
  return implementation_->fronts && implementation_->fronts->factorizes_by_threads();
}
bool Cholesky::solves_by_threads() const {
  return implementation_->fronts && implementation_->fronts->solves_by_threads();
}

}  // namespace tanor::detail
