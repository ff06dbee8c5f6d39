#include "factor/dependent_columns.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "base/numbers.hpp"

namespace tanor::detail {

namespace {

/// Estimates from above of some of the smallest singular values, increasing, and orthonormal vectors that have them.
struct SmallestSingularValues {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;  ///< [rho x number]
};

/// Iterates `number` vectors with (R'R)^-1 (subspace iteration).
SmallestSingularValues find_smallest_singular_values(const TriangularFactor& R, Eigen::Index number,
                                                     int most_iterations) {
  const auto rank = static_cast<Eigen::Index>(R.rank());
  number = std::min(number, rank);
  SmallestSingularValues smallest{Eigen::VectorXd::Constant(number, std::numeric_limits<double>::infinity()),
                                  Eigen::MatrixXd(rank, number)};
  if (rank == 0) return smallest;
  // The start vectors are fixed, and no structure of a scene is orthogonal to them.
  for (Eigen::Index k = 0; k < rank; ++k) {
    for (Eigen::Index l = 0; l < number; ++l)
      smallest.vectors(k, l) = 1.0 + std::sin(12.9898 * static_cast<double>((k + 1) * (l + 1)));
  }
  Eigen::MatrixXd& V = smallest.vectors;
  const auto orthonormalize = [&] {
    V = Eigen::HouseholderQR<Eigen::MatrixXd>(V).householderQ() * Eigen::MatrixXd::Identity(rank, number);
  };
  orthonormalize();
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    // V := R^-T V, whose singular values are at most 1/sigma.
    for (Eigen::Index l = 0; l < number; ++l) R.solve_transposed(V.col(l).data());
    const Eigen::MatrixXd triangle =
        Eigen::HouseholderQR<Eigen::MatrixXd>(V).matrixQR().topRows(number).triangularView<Eigen::Upper>();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(triangle, Eigen::ComputeFullV);
    const Eigen::VectorXd values = svd.singularValues().cwiseInverse();
    V = V * svd.matrixV();
    for (Eigen::Index l = 0; l < number; ++l) R.solve(V.col(l).data());
    orthonormalize();
    const bool settled = (values.array() > 0.9 * smallest.values.array()).all();
    smallest.values = smallest.values.cwiseMin(values);
    if (settled) break;
  }
  return smallest;
}

/// Leaves out a column for each of the smallest singular values that is below the tolerance: the columns that pivots of
/// QR choose in the rows of their vectors.
void leave_out_columns(const TriangularFactor& R, double tolerance, std::vector<int>* left_out) {
  constexpr Eigen::Index most_at_once = 16;
  const auto [values, vectors] = find_smallest_singular_values(R, most_at_once, 3);
  const Eigen::Index number = std::max<Eigen::Index>(1, (values.array() < tolerance).count());
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivots(vectors.leftCols(number).transpose());
  for (Eigen::Index k = 0; k < number; ++k)
    left_out->push_back(R.independent[static_cast<std::size_t>(pivots.colsPermutation().indices()(k))]);
  std::ranges::sort(*left_out);
}

}  // namespace

double find_smallest_singular_value(const TriangularFactor& R) {
  if (R.rank() == 0) return std::numeric_limits<double>::infinity();
  return find_smallest_singular_values(R, 1, 30).values(0);
}

TriangularFactor factorize_without(const std::vector<int>& left_out, const SparseColumns& C, double tolerance,
                                   QrFunction& factorize) {
  std::vector<int> wanted;
  for (int j = 0; j < static_cast<int>(C.num_columns()); ++j)
    if (!std::ranges::binary_search(left_out, j)) wanted.push_back(j);
  TriangularFactor factor = factorize(columns_of(C, wanted), tolerance);
  for (std::vector<int>* names : {&factor.independent, &factor.dependent})
    for (int& j : *names) j = wanted[static_cast<std::size_t>(j)];
  return factor;
}

DependentColumns find_independent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize) {
  DependentColumns found{factorize(C, tolerance), 0.0};
  std::vector<int> left_out;
  while (true) {
    found.smallest_singular_value = find_smallest_singular_value(found.factor);
    // A number that is not finite ends the loop, too.
    if (!(found.smallest_singular_value < tolerance)) break;
    leave_out_columns(found.factor, tolerance, &left_out);
    found.factor = factorize_without(left_out, C, tolerance, factorize);
  }
  std::vector<int>& dependent = found.factor.dependent;
  dependent.insert(dependent.end(), left_out.begin(), left_out.end());
  std::ranges::sort(dependent);
  return found;
}

namespace {

using Terms = std::vector<Dependence::Term>;  // by increasing column

double largest_of(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

/// Returns the column that should be dependent in place of column j, or -1 if there is none. It has the largest
/// coefficient above 2; otherwise it is the first later column whose coefficient is no smaller than j's own.
int find_exchange(int j, const Terms& terms) {
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

/// The combinations of all dependent columns. Terms below the tolerance are rounding. They are left out, so that
/// columns that have nothing to do with each other stay apart.
class Combinations {
 public:
  Combinations(const std::vector<Dependence>& dependences, std::size_t num_columns, double tolerance)
      : tolerance_(tolerance), terms_(num_columns), dependents_(num_columns) {
    for (const Dependence& dependence : dependences) {
      Terms terms = dependence.terms;
      std::erase_if(terms, [&](const auto& term) { return std::abs(term.coefficient) <= tolerance_; });
      std::ranges::sort(terms, {}, &Dependence::Term::column);
      insert(dependence.column, std::move(terms));
    }
  }

  /// Exchanges columns until none should be, in the shortest combinations first, since an exchange makes others longer.
  /// Returns true if it exchanged any.
  bool settle() {
    bool has_exchanged = false;
    while (!unsettled_.empty()) {
      const int j = unsettled_.begin()->second;
      unsettled_.erase(unsettled_.begin());
      const int i = find_exchange(j, terms_of(j));
      if (i < 0) continue;
      exchange(j, i);
      has_exchanged = true;
    }
    return has_exchanged;
  }

  /// The dependent columns, increasing.
  std::vector<int> columns() const { return {columns_.begin(), columns_.end()}; }
  const Terms& terms_of(int dependent) const { return terms_[static_cast<std::size_t>(dependent)]; }

 private:
  static Terms::iterator find(Terms& terms, int column) {
    const auto found = std::ranges::lower_bound(terms, column, {}, &Dependence::Term::column);
    return found != terms.end() && found->column == column ? found : terms.end();
  }

  void note(int independent, int dependent) { dependents_[static_cast<std::size_t>(independent)].push_back(dependent); }

  void insert(int column, Terms terms) {
    for (const Dependence::Term& term : terms) note(term.column, column);
    columns_.insert(column);
    unsettled_.emplace(terms.size(), column);
    terms_[static_cast<std::size_t>(column)] = std::move(terms);
  }

  /// Makes column i dependent in place of j in all combinations.
  void exchange(int j, int i) {
    // c_j = sum x_k c_k  =>  c_i = c_j/x_i - sum over k != i of x_k/x_i c_k
    Terms terms = std::exchange(terms_[static_cast<std::size_t>(j)], {});
    columns_.erase(j);
    const auto at = find(terms, i);
    const double pivot = at->coefficient;
    terms.erase(at);
    for (Dependence::Term& term : terms) term.coefficient /= -pivot;
    terms.insert(std::ranges::lower_bound(terms, j, {}, &Dependence::Term::column), {j, 1.0 / pivot});
    for (const int other : std::exchange(dependents_[static_cast<std::size_t>(i)], {})) substitute(i, terms, other);
    insert(i, std::move(terms));
  }

  /// Replaces column i in the combination of `other` by its own terms, if it is there.
  void substitute(int i, const Terms& own, int other) {
    Terms& terms = terms_[static_cast<std::size_t>(other)];
    const auto at = find(terms, i);
    if (at == terms.end()) return;
    const double factor = at->coefficient;
    unsettled_.erase({terms.size(), other});
    terms.erase(at);
    sum_.clear();
    auto term = terms.begin();
    for (const auto& [column, coefficient] : own) {
      while (term != terms.end() && term->column < column) sum_.push_back(*term++);
      const bool is_there = term != terms.end() && term->column == column;
      const double value = (is_there ? (term++)->coefficient : 0.0) + factor * coefficient;
      if (std::abs(value) <= tolerance_) continue;
      sum_.push_back({column, value});
      if (!is_there) note(column, other);
    }
    sum_.insert(sum_.end(), term, terms.end());
    terms.swap(sum_);
    unsettled_.emplace(terms.size(), other);
  }

  const double tolerance_;
  std::set<int> columns_;                            // dependent columns
  std::set<std::pair<std::size_t, int>> unsettled_;  // those to be looked at, with the numbers of their terms
  std::vector<Terms> terms_;                         // [column] empty if it is independent
  std::vector<std::vector<int>> dependents_;         // [column] dependent ones that it is, or was, a part of
  Terms sum_;                                        // scratch
};

/// Decides which columns are dependent, in steps; each step leaves `found_` for the next.
class Decision {
 public:
  Decision(const SparseColumns& C, double tolerance, QrFunction& factorize)
      : C_(C), transposed_C_(transpose(C)), tolerance_(tolerance), factorize_(factorize) {}

  DependentColumns make() {
    found_ = find_independent_columns(C_, tolerance_, factorize_);
    combine_dependent_columns();
    exchange_columns();
    return std::move(found_);
  }

 private:
  /// Finds X_j = argmin |C_I x - c_j|.
  void combine_dependent_columns() {
    const TriangularFactor& R = found_.factor;
    transposed_R_ = transpose(R);
    place_.assign(C_.num_columns(), -1);
    for (std::size_t k = 0; k < R.rank(); ++k) place_[static_cast<std::size_t>(R.independent[k])] = static_cast<int>(k);
    for (const int j : R.dependent) {
      solve(j);
      Dependence& dependence = found_.short_dependences.emplace_back(Dependence{j, {}});
      for (std::size_t k = 0; k < R.rank(); ++k)
        if (x_[k] != 0.0) dependence.terms.push_back({R.independent[k], x_[k]});
    }
  }

  /// Solves for x by the corrected seminormal equations (Bjorck, Linear Algebra Appl. 88/89, 1987). Terms below the
  /// tolerance are left out, unless c_j is no combination of the others to rounding.
  void solve(int j) {
    constexpr double enough = 16.0 * eps, nothing = 0.1 * eps;
    x_.assign(found_.factor.rank(), 0.0);
    set_residual(j);
    correct([&](std::size_t, double dx) { return std::abs(dx) > tolerance_; });
    const auto is_there = [&](std::size_t k, double) { return x_[k] != 0.0; };
    for (int pass = 0; pass < 2; ++pass) correct(is_there);
    set_residual(j);
    if (largest_of(residual_) <= enough * std::max(1.0, largest_of(x_))) return;
    for (int pass = 0; pass < 2; ++pass) correct([&](std::size_t, double dx) { return std::abs(dx) > nothing; });
  }

  /// Computes c_j - C_I x.
  void set_residual(int j) {
    residual_.assign(static_cast<std::size_t>(C_.num_rows), 0.0);
    add_column(C_, j, 1.0, residual_.data());
    for (std::size_t k = 0; k < x_.size(); ++k)
      if (x_[k] != 0.0) add_column(C_, found_.factor.independent[k], -x_[k], residual_.data());
  }

  /// Adds dx with R'R dx = C_I' (c_j - C_I x) to x, as far as the numbers dx_k count. Others would fill the vectors.
  template <class Counts>
  void correct(const Counts& counts) {
    dx_.assign(x_.size(), 0.0);
    for (int row = 0; row < C_.num_rows; ++row) {
      const double r = residual_[static_cast<std::size_t>(row)];
      if (r == 0.0) continue;
      for_each_entry(transposed_C_, row, [&](int column, double value) {
        const int k = place_[static_cast<std::size_t>(column)];
        if (k >= 0) dx_[static_cast<std::size_t>(k)] += value * r;
      });
    }
    // R' y = dx
    for (std::size_t k = 0; k < dx_.size(); ++k) {
      if (dx_[k] == 0.0) continue;
      const double y = dx_[k] / diagonal(k);
      add_column(transposed_R_, static_cast<int>(k), -y, dx_.data());
      dx_[k] = y;
    }
    // R dx = y
    for (std::size_t k = dx_.size(); k-- > 0;) {
      if (dx_[k] == 0.0) continue;
      const double dx = dx_[k] / diagonal(k);
      if (!counts(k, dx)) continue;
      x_[k] += dx;
      add_column(found_.factor, static_cast<int>(k), -dx, dx_.data());
      add_column(C_, found_.factor.independent[k], -dx, residual_.data());
    }
  }

  double diagonal(std::size_t k) const {
    return found_.factor.values[static_cast<std::size_t>(found_.factor.start[k + 1]) - 1];
  }

  /// Exchanges columns until |X| <= 2; R11 is then the factor of the new independent columns.
  void exchange_columns() {
    Combinations combinations(found_.short_dependences, C_.num_columns(), tolerance_);
    const bool has_exchanged = combinations.settle();
    std::vector<int> dependent = combinations.columns();
    for (const int j : dependent) found_.dependences.push_back({j, combinations.terms_of(j)});
    if (!has_exchanged) return;
    found_.factor = factorize_without(dependent, C_, -1.0, factorize_);
    found_.factor.dependent = std::move(dependent);
    found_.smallest_singular_value = find_smallest_singular_value(found_.factor);
  }

  const SparseColumns& C_;
  const SparseColumns transposed_C_;
  const double tolerance_;
  QrFunction& factorize_;
  DependentColumns found_;
  SparseColumns transposed_R_;
  std::vector<int> place_;                 // [column] its place among the independent ones, or -1
  std::vector<double> x_, dx_, residual_;  // of the present dependent column
};

}  // namespace

DependentColumns find_dependent_columns(const SparseColumns& C, double tolerance, QrFunction& factorize) {
  return Decision(C, tolerance, factorize).make();
}

}  // namespace tanor::detail
