#include "factor/rank_solver.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "base/numbers.hpp"

namespace tanor::detail {

RankSolver::RankSolver(SparseColumns C, double least_tolerance, QrFunction& factorize)
    : factorize_(factorize), C_(std::move(C)) {
  const std::size_t d = C_.num_columns();
  tolerance_ = std::max(least_tolerance, 20.0 * (static_cast<double>(C_.num_rows) + static_cast<double>(d)) * eps);
  scale_columns();
  null_space_.num_rows = static_cast<int>(d);
  find_dependences();
  (void)normalize_columns(&null_space_);
  null_factor_ = factorize_(null_space_, -1.0);
  drop_rounding();
}

RankSolver::RankSolver(SparseColumns C, const RankSolver& decided)
    : factorize_(decided.factorize_),
      C_(std::move(C)),
      tolerance_(decided.tolerance_),
      sigma_in_question_(decided.sigma_in_question_),
      dependences_(decided.dependences_),
      null_space_(decided.null_space_),
      null_factor_(decided.null_factor_) {
  scale_columns();
  // Coefficients are those of columns of unit length, which these have in another norm.
  const auto ratio = [&](int column) {
    const auto j = static_cast<std::size_t>(column);
    return decided.scale_[j] / scale_[j];
  };
  for (Dependence& dependence : dependences_) {
    for (Dependence::Term& term : dependence.terms) term.coefficient *= ratio(term.column) / ratio(dependence.column);
  }
}

void RankSolver::scale_columns() {
  for (const double length : normalize_columns(&C_)) scale_.push_back(1.0 / length);
}

void RankSolver::find_dependences() {
  std::vector<int> row_name(static_cast<std::size_t>(C_.num_rows), -1);
  for (const std::vector<int>& group : find_columns_in_question(C_, tolerance_)) {
    DependentColumns found = find_dependent_columns(take_group(group, &row_name), tolerance_, factorize_);
    sigma_in_question_ = std::min(sigma_in_question_, found.smallest_singular_value);
    for (std::vector<Dependence>* dependences : {&found.dependences, &found.short_dependences}) {
      for (Dependence& dependence : *dependences) {
        dependence.column = group[static_cast<std::size_t>(dependence.column)];
        for (Dependence::Term& term : dependence.terms) term.column = group[static_cast<std::size_t>(term.column)];
      }
    }
    std::ranges::move(found.dependences, std::back_inserter(dependences_));
    span_null_space(found.short_dependences);
    if (group.size() < num_columns()) continue;
    smallest_singular_value_ = found.smallest_singular_value;
    factor_ = std::move(found.factor);
  }
  std::ranges::sort(dependences_, {}, &Dependence::column);
}

/// Returns the columns of a group, with only the rows that they have. `row_name` is -1 before and after.
SparseColumns RankSolver::take_group(const std::vector<int>& group, std::vector<int>* row_name) const {
  SparseColumns own = columns_of(C_, group);
  std::vector<int> rows;
  own.num_rows = 0;
  for (int& row : own.rows) {
    int& name = (*row_name)[static_cast<std::size_t>(row)];
    if (name < 0) {
      name = own.num_rows++;
      rows.push_back(row);
    }
    row = name;
  }
  for (const int row : rows) (*row_name)[static_cast<std::size_t>(row)] = -1;
  return own;
}

const TriangularFactor& RankSolver::factor() {
  if (!factor_) {
    std::vector<int> dependent;
    for (const Dependence& dependence : dependences_) dependent.push_back(dependence.column);
    factor_ = factorize_without(dependent, C_, -1.0, factorize_);
  }
  return *factor_;
}

double RankSolver::smallest_singular_value() {
  if (!smallest_singular_value_) smallest_singular_value_ = find_smallest_singular_value(factor());
  return *smallest_singular_value_;
}

/// Appends the columns D [-x; 1] of Z.
void RankSolver::span_null_space(const std::vector<Dependence>& dependences) {
  for (const auto& [own, terms] : dependences) {
    for (const auto& [column, coefficient] : terms)
      null_space_.append(column, -coefficient * scale_[static_cast<std::size_t>(column)]);
    null_space_.append(own, scale_[static_cast<std::size_t>(own)]);
    null_space_.end_column();
  }
}

/// Drops coefficients near eps/sigma_min, to which X is known, since they may be zeros. Sorts the largest terms first.
void RankSolver::drop_rounding() {
  const double least = 1e3 * eps / sigma_in_question_;
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

void RankSolver::solve(double* x) {
  // S = D^-1 [1 X]' R'R [1 X] D^-1
  const TriangularFactor& R = factor();
  std::vector<double> y(R.rank());
  for (std::size_t k = 0; k < R.rank(); ++k) {
    const int j = R.independent[k];
    y[k] = x[j] * scale_[static_cast<std::size_t>(j)];
  }
  R.solve_transposed(y.data());
  R.solve(y.data());
  std::fill(x, x + num_columns(), 0.0);
  for (std::size_t k = 0; k < R.rank(); ++k) {
    const int j = R.independent[k];
    x[j] = y[k] * scale_[static_cast<std::size_t>(j)];
  }
}

void RankSolver::minimize_norm(double* x) const {
  // The second pass removes the rounding of the first.
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
  // With unit columns c_j = sum x_k c_k, so that b_j asks for as much as sum x_k b_k.
  std::vector<Contradiction> result;
  for (const auto& [own, terms] : dependences_) {
    const auto scaled = [&](int column) {
      return scale_[static_cast<std::size_t>(column)] * b[static_cast<std::size_t>(column)];
    };
    Contradiction contradiction{own, scaled(own), std::abs(scaled(own))};
    for (const Dependence::Term& term : terms) {
      const double part = term.coefficient * scaled(term.column);
      contradiction.excess -= part;
      contradiction.magnitude += std::abs(part);
    }
    contradiction.excess /= scale_[static_cast<std::size_t>(own)];
    contradiction.magnitude /= scale_[static_cast<std::size_t>(own)];
    result.push_back(contradiction);
  }
  return result;
}

std::unique_ptr<RankSolver> decide_rank(const std::function<SparseColumns(Scaling)>& make, double tolerance,
                                        const std::function<double()>& find_mass_ratio) {
  constexpr double unequal = 1e4;
  auto solver = std::make_unique<RankSolver>(make(Scaling::ByMasses), tolerance);
  const std::size_t found = solver->dependences().size();
  if (found == 0 || find_mass_ratio() < unequal) return solver;
  const RankSolver of_K(make(Scaling::None), tolerance);
  if (of_K.dependences().size() >= found) return solver;
  return std::make_unique<RankSolver>(make(Scaling::ByMasses), of_K);
}

}  // namespace tanor::detail
