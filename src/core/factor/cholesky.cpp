#include "factor/cholesky.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/counts.hpp"
#include "factor/cholmod_common.hpp"
#include "factor/multifrontal.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

/// Analyzes a pattern with one ordering. `given`, [place] -> row, is an ordering that CHOLMOD does not know.
SymbolicAnalysis analyze_with(const TrianglePattern& lower, Ordering ordering, std::vector<int> given = {}) {
  CholmodCommon common;
  cholmod_common& c = common.c;
  c.postorder = ordering != Ordering::Natural;
  c.method[0].ordering = ordering == Ordering::Amd       ? CHOLMOD_AMD
                         : ordering == Ordering::Metis   ? CHOLMOD_METIS
                         : ordering == Ordering::Nesdis  ? CHOLMOD_NESDIS
                         : ordering == Ordering::Natural ? CHOLMOD_NATURAL
                                                         : CHOLMOD_GIVEN;
  cholmod_sparse a = cholmod_view(lower, -1);
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

std::vector<int> order_keeping(const TrianglePattern& lower, std::span<const char> is_kept, Ordering wanted) {
  std::vector<int> place(lower.size(), -1), eliminated, kept;
  for (std::size_t row = 0; row < lower.size(); ++row) {
    if (is_kept[row] == 0) place[row] = static_cast<int>(eliminated.size());
    (is_kept[row] != 0 ? kept : eliminated).push_back(static_cast<int>(row));
  }
  TrianglePattern others;
  for (const int column : eliminated) {
    const auto j = static_cast<std::size_t>(column);
    for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]); ++e) {
      if (const int row = place[static_cast<std::size_t>(lower.rows[e])]; row >= 0) others.rows.push_back(row);
    }
    others.start.push_back(static_cast<int>(others.rows.size()));
  }
  std::vector<int> result = eliminated;
  if (const std::vector<int> order = analyze(others, wanted).permutation; !order.empty()) {
    for (std::size_t k = 0; k < order.size(); ++k) result[k] = eliminated[static_cast<std::size_t>(order[k])];
  }
  result.insert(result.end(), kept.begin(), kept.end());
  return result;
}

std::optional<std::size_t> count_negative_eigenvalues(const TrianglePattern& upper, std::vector<double> values) {
  CholmodCommon common;
  cholmod_common& c = common.c;
  c.final_ll = 0;  // L D L', which an indefinite matrix may have too
  c.quick_return_if_not_posdef = 0;
  cholmod_sparse matrix = cholmod_view(upper, 1, values.data());
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

namespace {

/// The supernodal factor.
struct Fronts final : Cholesky::Method {
  Multifrontal fronts;

  explicit Fronts(TrianglePattern lower)
      : Method(std::move(lower), Factorization::Multifrontal), fronts(this->pattern) {}
  Cholesky::Quality factorize(int threads) override { return fronts.factorize(values.data(), threads); }
  void solve(double* x, int threads) override { fronts.solve(x, threads); }
  bool factorizes_by_threads() const override { return fronts.factorizes_by_threads(); }
  bool solves_by_threads() const override { return fronts.solves_by_threads(); }
};

/// Serves S that is diagonal (beads on surfaces of their own), or that belongs to one point, which has at most three
/// rows.
struct ClosedForm final : Cholesky::Method {
  static constexpr std::size_t most_rows = 3;
  std::vector<double> inverse;                               // 1/S_ii of a diagonal S
  std::array<std::array<double, most_rows>, most_rows> L{};  // L of any other S

  static bool is_diagonal(const TrianglePattern& upper) { return upper.rows.size() == upper.size(); }
  static bool serves(const TrianglePattern& upper) { return is_diagonal(upper) || upper.size() <= most_rows; }

  explicit ClosedForm(TrianglePattern upper)
      : Method(std::move(upper), Factorization::ClosedForm), inverse(is_diagonal(pattern) ? pattern.size() : 0) {}
  Cholesky::Quality factorize(int threads) override;
  void solve(double* x, int threads) override;
};

Cholesky::Quality ClosedForm::factorize(int) {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  std::size_t weakest = 0;
  // A pivot that is zero, negative or NaN ends the factorization.
  const auto see = [&](double pivot, std::size_t row) {
    if (!(pivot > 0.0)) return false;
    if (pivot < smallest) weakest = row;
    smallest = std::min(smallest, pivot);
    largest = std::max(largest, pivot);
    return true;
  };
  for (std::size_t i = 0; i < inverse.size(); ++i) {
    if (!see(values[i], i)) return {false, i, 0.0};
    inverse[i] = 1.0 / values[i];
  }
  // L_ij = (S_ij - sum over k < j of L_ik L_jk)/L_jj
  for (std::size_t i = 0; i < pattern.size() && inverse.empty(); ++i) {
    L[i] = {};
    for (int e = pattern.start[i]; e < pattern.start[i + 1]; ++e)
      L[i][static_cast<std::size_t>(pattern.rows[static_cast<std::size_t>(e)])] = values[static_cast<std::size_t>(e)];
    for (std::size_t j = 0; j <= i; ++j) {
      for (std::size_t k = 0; k < j; ++k) L[i][j] -= L[i][k] * L[j][k];
      if (j < i) L[i][j] /= L[j][j];
    }
    if (!see(L[i][i], i)) return {false, i, 0.0};
    L[i][i] = std::sqrt(L[i][i]);
  }
  return {true, weakest, smallest / largest};
}

void ClosedForm::solve(double* x, int) {
  for (std::size_t i = 0; i < inverse.size(); ++i) x[i] *= inverse[i];
  if (!inverse.empty()) return;
  const std::size_t n = pattern.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
}

/// CHOLMOD's simplicial factor. CHOLMOD itself solves with it if that was asked for.
struct Simplicial final : Cholesky::Method {
  CholmodCommon common;
  cholmod_sparse matrix;
  cholmod_factor* factor;
  const bool solves_by_cholmod;
  std::vector<double> unit_lower, inverse_pivots;  // L D^-1 beside L's entries, D^-2
  cholmod_dense *solution = nullptr, *rooms[2] = {nullptr, nullptr};

  /// CHOLMOD's arrays. Column j has the entries [start[j], start[j] + count[j]), its diagonal first.
  struct Columns {
    std::size_t n;
    const int *start, *count, *rows;
    const double* values;
  };
  Columns columns() const {
    return {factor->n, static_cast<const int*>(factor->p), static_cast<const int*>(factor->nz),
            static_cast<const int*>(factor->i), static_cast<const double*>(factor->x)};
  }

  Simplicial(TrianglePattern upper, bool by_cholmod)
      : Method(std::move(upper), Factorization::Simplicial),
        matrix(cholmod_view(pattern, 1, values.data())),
        factor(cholmod_analyze(&matrix, &common.c)),
        solves_by_cholmod(by_cholmod) {
    common.check();
  }
  ~Simplicial() override {
    for (cholmod_dense** dense : {&solution, &rooms[0], &rooms[1]}) cholmod_free_dense(dense, &common.c);
    cholmod_free_factor(&factor, &common.c);
  }

  Cholesky::Quality factorize(int threads) override;
  void solve(double* x, int threads) override;
  void split();
  void solve_by_cholmod(double* x);
};

Cholesky::Quality Simplicial::factorize(int) {
  cholmod_common& c = common.c;
  cholmod_factorize(&matrix, factor, &c);
  common.check();
  // Read the status first: cholmod_rcond overwrites it.
  if (c.status == CHOLMOD_NOT_POSDEF || factor->minor < factor->n) return {false, factor->minor, 0.0};
  // A matrix that is singular to rounding shows it at its smallest pivot.
  const auto [n, start, count, rows, l] = columns();
  std::size_t weakest = 0;
  for (std::size_t j = 1; j < n; ++j)
    if (l[start[j]] < l[start[weakest]]) weakest = j;
  if (!solves_by_cholmod) split();
  return {true, weakest, cholmod_rcond(factor, &c)};
}

/// Splits L = (L D^-1) D with its diagonal D. Solves then need no division, and the chain of dependent operations along
/// a path has one multiplication and one subtraction for each row.
void Simplicial::split() {
  const auto [n, start, count, rows, l] = columns();
  unit_lower.resize(factor->nzmax);
  inverse_pivots.resize(n);
  for (std::size_t j = 0; j < n; ++j) {
    const double inverse = 1.0 / l[start[j]];
    inverse_pivots[j] = inverse * inverse;
    for (int k = start[j] + 1; k < start[j] + count[j]; ++k) unit_lower[static_cast<std::size_t>(k)] = l[k] * inverse;
  }
}

/// Solves in place; cholmod_solve2 would copy x twice.
void Simplicial::solve(double* x, int) {
  if (solves_by_cholmod) return solve_by_cholmod(x);
  const auto [n, start, count, rows, l] = columns();
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

void Simplicial::solve_by_cholmod(double* x) {
  cholmod_dense b{};
  b.nrow = b.d = b.nzmax = pattern.size();
  b.ncol = 1;
  b.x = x;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_solve2(CHOLMOD_A, factor, &b, nullptr, &solution, nullptr, &rooms[0], &rooms[1], &common.c);
  common.check();
  std::copy_n(static_cast<const double*>(solution->x), b.nrow, x);
}

}  // namespace

Cholesky::Cholesky(TrianglePattern pattern, bool supernodal, bool by_cholmod) {
  if (supernodal)
    method_ = std::make_unique<Fronts>(std::move(pattern));
  else if (!by_cholmod && ClosedForm::serves(pattern))
    method_ = std::make_unique<ClosedForm>(std::move(pattern));
  else
    method_ = std::make_unique<Simplicial>(std::move(pattern), by_cholmod);
}

}  // namespace tanor::detail
