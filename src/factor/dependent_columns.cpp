#include "factor/dependent_columns.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/numbers.hpp"
#include "factor/independent_columns.hpp"

namespace tanor {

namespace {

/// A dependent column as a combination of independent ones, with terms by increasing column.
struct Combination {
  std::vector<Dependence::Term> terms;
  bool is_settled = false;  // true if no column should be exchanged with it
};

/// Returns the column that should be dependent in place of column j, or -1 if there is none. It has the largest
/// coefficient above 2; otherwise it is the first later column whose coefficient is no smaller than j's own.
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

/// Computes terms += factor * others.
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

/// Decides which columns are dependent, in steps; each step leaves `found_` for the next.
class Decision {
 public:
  Decision(const SparseColumns& C, double tolerance, QrFunction& factorize)
      : C_(C), transposed_C_(transpose(C)), tolerance_(tolerance), factorize_(factorize) {}

  DependentColumns make() {
    IndependentColumns independent = find_independent_columns(C_, tolerance_, factorize_);
    found_ = {{}, std::move(independent.factor), independent.smallest_singular_value};
    combine_dependent_columns();
    if (exchange_columns()) combine_dependent_columns();
    return std::move(found_);
  }

 private:
  /// Finds X_j = argmin |C_I x - c_j| by the corrected seminormal equations (Bjorck, Linear Algebra Appl. 88/89, 1987).
  void combine_dependent_columns() {
    constexpr int num_corrections = 2;
    const TriangularFactor& R = found_.factor;
    std::vector<int> place(C_.num_columns(), -1);  // column of C -> column of R11
    for (std::size_t k = 0; k < R.rank(); ++k) place[static_cast<std::size_t>(R.independent[k])] = static_cast<int>(k);

    found_.dependences.clear();
    std::vector<double> residual(static_cast<std::size_t>(C_.num_rows));
    for (const int j : R.dependent) {
      std::vector<double> x(R.rank(), 0.0);
      std::fill(residual.begin(), residual.end(), 0.0);
      add_column(C_, j, 1.0, residual.data());
      for (int pass = 0; pass <= num_corrections; ++pass) {
        // R'R dx = C_I' (c_j - C_I x)
        std::vector<double> dx(R.rank(), 0.0);
        for (int row = 0; row < C_.num_rows; ++row) {
          const double r = residual[static_cast<std::size_t>(row)];
          if (r == 0.0) continue;
          for_each_entry(transposed_C_, row, [&](int column, double value) {
            const int k = place[static_cast<std::size_t>(column)];
            if (k >= 0) dx[static_cast<std::size_t>(k)] += value * r;
          });
        }
        R.solve_transposed(dx.data());
        R.solve(dx.data());
        for (std::size_t k = 0; k < R.rank(); ++k) {
          if (std::abs(dx[k]) < 0.1 * eps) continue;  // nothing beside unit columns, but it would fill the vector
          x[k] += dx[k];
          add_column(C_, R.independent[k], -dx[k], residual.data());
        }
      }
      Dependence& dependence = found_.dependences.emplace_back(Dependence{j, {}});
      for (std::size_t k = 0; k < R.rank(); ++k)
        if (x[k] != 0.0) dependence.terms.push_back({R.independent[k], x[k]});
    }
  }

  /// Returns true if it exchanged any column; R11 is then the factor of the new independent columns.
  bool exchange_columns() {
    std::map<int, Combination> X;  // dependent column -> its combination of independent ones
    for (const Dependence& dependence : found_.dependences) {
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
    found_.factor = factorize_columns(C_, all_but(dependent, C_.num_columns()), -1.0, factorize_);
    found_.factor.dependent = std::move(dependent);
    found_.smallest_singular_value = find_smallest_singular_value(found_.factor);
    return true;
  }

  const SparseColumns& C_;
  const SparseColumns transposed_C_;
  const double tolerance_;
  QrFunction& factorize_;
  DependentColumns found_;
};

}  // namespace

DependentColumns find_dependent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize) {
  return Decision(C, tolerance, factorize).make();
}

}  // namespace tanor
