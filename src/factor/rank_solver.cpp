#include "factor/rank_solver.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/numbers.hpp"
#include "factor/independent_columns.hpp"

namespace tanor {

namespace {

double norm(std::span<const double> x) {
  double sum = 0.0;
  for (const double value : x) sum += value * value;
  return std::sqrt(sum);
}

void normalize(std::span<double> x) {
  const double length = norm(x);
  for (double& value : x) value /= length;
}

/// Calls visit(row, value) for column j.
template <class Visit>
void for_each_entry(const SparseColumns& A, int j, Visit&& visit) {
  for (int k = A.start[static_cast<std::size_t>(j)]; k < A.start[static_cast<std::size_t>(j) + 1]; ++k)
    visit(A.rows[static_cast<std::size_t>(k)], A.values[static_cast<std::size_t>(k)]);
}

/// y += factor * (column j of A)
void add_column(const SparseColumns& A, int j, double factor, double* y) {
  for_each_entry(A, j, [&](int row, double value) { y[row] += factor * value; });
}

/// (column j of A)' y
double dot_column(const SparseColumns& A, int j, const double* y) {
  double sum = 0.0;
  for_each_entry(A, j, [&](int row, double value) { sum += value * y[row]; });
  return sum;
}

SparseColumns transpose(const SparseColumns& A) {
  SparseColumns result;
  result.num_rows = static_cast<int>(A.num_columns());
  result.start.assign(static_cast<std::size_t>(A.num_rows) + 2, 0);
  for (const int row : A.rows) ++result.start[static_cast<std::size_t>(row) + 2];
  std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
  result.rows.resize(A.rows.size());
  result.values.resize(A.rows.size());
  for (int j = 0; j < result.num_rows; ++j) {
    for_each_entry(A, j, [&](int row, double value) {
      const auto place = static_cast<std::size_t>(result.start[static_cast<std::size_t>(row) + 1]++);
      result.rows[place] = j;
      result.values[place] = value;
    });
  }
  result.start.pop_back();
  return result;
}

/// A dependent column as a combination of independent ones, by increasing column.
struct Combination {
  std::vector<Dependence::Term> terms;
  bool is_settled = false;  // has no column that it should be exchanged with
};

/// The term that should be dependent in place of column j: the largest above 2, or else the first later one that is no
/// smaller than j's own; -1: none.
int find_exchange(int j, const std::vector<Dependence::Term>& terms) {
  constexpr double largest_coefficient = 2.0, rounding = 1e-6;
  double largest = largest_coefficient;
  int result = -1;
  for (const auto& [column, coefficient] : terms) {
    const bool is_equal_and_later = result < 0 && column > j && std::abs(coefficient) > 1.0 - rounding;
    if (std::abs(coefficient) <= largest && !is_equal_and_later) continue;
    largest = std::max(largest, std::abs(coefficient));
    result = column;
  }
  return result;
}

/// terms += factor * others
void add_terms(double factor, const std::vector<Dependence::Term>& others, std::vector<Dependence::Term>* terms) {
  std::vector<Dependence::Term> sum;
  sum.reserve(terms->size() + others.size());
  auto term = terms->begin();
  for (const auto& [column, coefficient] : others) {
    while (term != terms->end() && term->column < column) sum.push_back(*term++);
    const double before = term != terms->end() && term->column == column ? (term++)->coefficient : 0.0;
    sum.push_back({column, before + factor * coefficient});
  }
  sum.insert(sum.end(), term, terms->end());
  *terms = std::move(sum);
}

/// Makes column i dependent in place of j in all combinations.
void exchange(int j, int i, std::map<int, Combination>* X) {
  const auto find = [](std::vector<Dependence::Term>& terms, int column) {
    const auto found = std::ranges::lower_bound(terms, column, {}, &Dependence::Term::column);
    return found != terms.end() && found->column == column ? found : terms.end();
  };
  // c_j = sum x_k c_k  =>  c_i = c_j/x_i - sum over k != i of x_k/x_i c_k
  std::vector<Dependence::Term> terms = std::move(X->at(j).terms);
  X->erase(j);
  const auto at = find(terms, i);
  const double pivot = at->coefficient;
  terms.erase(at);
  for (Dependence::Term& term : terms) term.coefficient /= -pivot;
  terms.insert(std::ranges::lower_bound(terms, j, {}, &Dependence::Term::column), {j, 1.0 / pivot});
  for (auto& [column, other] : *X) {
    const auto found = find(other.terms, i);
    if (found == other.terms.end()) continue;
    const double factor = found->coefficient;
    other.terms.erase(found);
    add_terms(factor, terms, &other.terms);
    other.is_settled = false;
  }
  X->emplace(i, Combination{std::move(terms)});
}

}  // namespace

RankSolver::RankSolver(SparseColumns C, double least_tolerance, QrFunction& factorize)
    : factorize_(factorize), C_(std::move(C)) {
  const std::size_t d = C_.num_columns();
  tolerance_ = std::max(least_tolerance, 20.0 * (static_cast<double>(C_.num_rows) + static_cast<double>(d)) * eps);
  for (std::size_t j = 0; j < d; ++j) {
    const std::span<double> column(C_.values.begin() + C_.start[j], C_.values.begin() + C_.start[j + 1]);
    const double length = norm(column);
    scale_.push_back(length > 0.0 ? 1.0 / length : 1.0);
    for (double& value : column) value *= scale_[j];
  }
  transposed_C_ = transpose(C_);

  find_independent_columns();
  combine_dependent_columns();
  if (exchange_columns()) combine_dependent_columns();
  span_null_space();
  drop_rounding();
}

void RankSolver::find_independent_columns() {
  IndependentColumns found = tanor::find_independent_columns(C_, tolerance_, factorize_);
  factor_ = std::move(found.factor);
  smallest_singular_value_ = found.smallest_singular_value;
}

/// (R'R)^-1 y, [rho]
std::vector<double> RankSolver::solve_normal(std::vector<double> y) const {
  factor_.solve_transposed(y.data());
  factor_.solve(y.data());
  return y;
}

/// X_j = argmin |C_I x - c_j|, by the corrected seminormal equations (Bjorck, Linear Algebra Appl. 88/89, 1987).
void RankSolver::combine_dependent_columns() {
  constexpr int num_corrections = 2;
  std::vector<int> place(num_columns(), -1);  // column of C -> column of R11
  for (std::size_t k = 0; k < rank(); ++k)
    place[static_cast<std::size_t>(factor_.independent[k])] = static_cast<int>(k);

  dependences_.clear();
  std::vector<double> residual(static_cast<std::size_t>(C_.num_rows));
  for (const int j : factor_.dependent) {
    std::vector<double> x(rank(), 0.0);
    std::fill(residual.begin(), residual.end(), 0.0);
    add_column(C_, j, 1.0, residual.data());
    for (int pass = 0; pass <= num_corrections; ++pass) {
      // R'R dx = C_I' (c_j - C_I x)
      std::vector<double> dx(rank(), 0.0);
      for (int row = 0; row < C_.num_rows; ++row) {
        const double r = residual[static_cast<std::size_t>(row)];
        if (r == 0.0) continue;
        for_each_entry(transposed_C_, row, [&](int column, double value) {
          const int k = place[static_cast<std::size_t>(column)];
          if (k >= 0) dx[static_cast<std::size_t>(k)] += value * r;
        });
      }
      dx = solve_normal(std::move(dx));
      for (std::size_t k = 0; k < rank(); ++k) {
        if (std::abs(dx[k]) < 0.1 * eps) continue;  // of unit columns: nothing, but a full vector of it
        x[k] += dx[k];
        add_column(C_, factor_.independent[k], -dx[k], residual.data());
      }
    }
    Dependence& dependence = dependences_.emplace_back(Dependence{j, {}});
    for (std::size_t k = 0; k < rank(); ++k)
      if (x[k] != 0.0) dependence.terms.push_back({factor_.independent[k], x[k]});
  }
}

/// Returns whether it exchanged any column; R11 is then that of the new independent columns.
bool RankSolver::exchange_columns() {
  std::map<int, Combination> X;  // dependent column -> its combination of independent ones
  for (const Dependence& dependence : dependences_) {
    std::vector<Dependence::Term>& terms = X[dependence.column].terms;
    for (const Dependence::Term& term : dependence.terms)
      if (std::abs(term.coefficient) > tolerance_) terms.push_back(term);
    std::ranges::sort(terms, {}, &Dependence::Term::column);
  }
  bool exchanged = false;
  for (auto next = X.begin(); next != X.end();) {
    const auto& [j, combination] = *next;
    const int i = combination.is_settled ? -1 : find_exchange(j, combination.terms);
    if (i < 0) {
      next++->second.is_settled = true;
      continue;
    }
    exchanged = true;
    exchange(j, i, &X);
    next = X.begin();
  }
  if (!exchanged) return false;

  std::vector<int> dependent;
  for (const auto& [column, combination] : X) dependent.push_back(column);
  factor_ = factorize_columns(C_, all_but(dependent, num_columns()), -1.0, factorize_);
  factor_.dependent = std::move(dependent);
  smallest_singular_value_ = find_smallest_singular_value(factor_);
  return true;
}

/// Z = D [-X; 1] with unit columns, and its QR.
void RankSolver::span_null_space() {
  null_space_.num_rows = static_cast<int>(num_columns());
  for (const Dependence& dependence : dependences_) {
    const auto append = [&](int column, double value) {
      null_space_.rows.push_back(column);
      null_space_.values.push_back(value * scale_[static_cast<std::size_t>(column)]);
    };
    for (const Dependence::Term& term : dependence.terms) append(term.column, -term.coefficient);
    append(dependence.column, 1.0);
    normalize({null_space_.values.begin() + null_space_.start.back(), null_space_.values.end()});
    null_space_.start.push_back(static_cast<int>(null_space_.rows.size()));
  }
  null_factor_ = factorize_(null_space_, -1.0);
}

/// X is known to eps/sigma_min, so a coefficient near that may be a zero. The largest terms come first.
void RankSolver::drop_rounding() {
  const double least = 1e3 * eps / std::min(smallest_singular_value_, 1.0);
  for (Dependence& dependence : dependences_) {
    std::erase_if(dependence.terms, [&](const Dependence::Term& term) { return std::abs(term.coefficient) < least; });
    std::stable_sort(dependence.terms.begin(), dependence.terms.end(),
                     [](const Dependence::Term& a, const Dependence::Term& b) {
                       return std::abs(a.coefficient) > std::abs(b.coefficient);
                     });
  }
}

std::vector<bool> RankSolver::unique() const {
  std::vector<bool> result(num_columns(), true);
  for (const Dependence& dependence : dependences_) {
    result[static_cast<std::size_t>(dependence.column)] = false;
    for (const Dependence::Term& term : dependence.terms) result[static_cast<std::size_t>(term.column)] = false;
  }
  return result;
}

void RankSolver::solve(double* x) const {
  // S = D^-1 [1 X]' R'R [1 X] D^-1
  std::vector<double> y(rank());
  for (std::size_t k = 0; k < rank(); ++k) {
    const int j = factor_.independent[k];
    y[k] = x[j] * scale_[static_cast<std::size_t>(j)];
  }
  y = solve_normal(std::move(y));
  std::fill(x, x + num_columns(), 0.0);
  for (std::size_t k = 0; k < rank(); ++k) {
    const int j = factor_.independent[k];
    x[j] = y[k] * scale_[static_cast<std::size_t>(j)];
  }
}

void RankSolver::minimize_norm(double* x) const {
  // The second pass takes away the rounding of the first.
  for (int pass = 0; pass < 2; ++pass) {
    // x -= Z (Z'Z)^-1 Z' x
    std::vector<double> y;
    for (const int j : null_factor_.independent) y.push_back(dot_column(null_space_, j, x));
    null_factor_.solve_transposed(y.data());
    null_factor_.solve(y.data());
    for (std::size_t k = 0; k < y.size(); ++k) add_column(null_space_, null_factor_.independent[k], -y[k], x);
  }
}

std::vector<RankSolver::Contradiction> RankSolver::contradictions(std::span<const double> b) const {
  std::vector<Contradiction> result;
  for (std::size_t k = 0; k < dependences_.size(); ++k) {
    // b is in the range of C' if Z' b = 0
    Contradiction contradiction{dependences_[k].column, 0.0, 0.0};
    double own = 1.0;  // coefficient of the dependent column
    for_each_entry(null_space_, static_cast<int>(k), [&](int column, double coefficient) {
      const double part = coefficient * b[static_cast<std::size_t>(column)];
      contradiction.excess += part;
      contradiction.magnitude += std::abs(part);
      if (column == contradiction.column) own = coefficient;
    });
    contradiction.excess /= own;
    contradiction.magnitude /= own;
    result.push_back(contradiction);
  }
  return result;
}

}  // namespace tanor
