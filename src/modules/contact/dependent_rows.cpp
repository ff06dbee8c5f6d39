#include "contact/dependent_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "contact/exchange.hpp"
#include "contact/unilateral_rows.hpp"

namespace tanor::detail {

namespace {

constexpr double compliance = 1e-8;      // over the largest number on the diagonal of S
constexpr double rounding = 1e-4;        // of what the compliance does
constexpr std::size_t most_rows = 1000;  // S is dense here

/// Solves A x = b for a positive definite A [n x n] by Cholesky's method; A becomes its factor.
void solve_dense(std::vector<double>* A, std::vector<double>* x) {
  const std::size_t n = x->size();
  const auto a = [&](std::size_t i, std::size_t j) -> double& { return (*A)[i * n + j]; };
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t i = j; i < n; ++i) {
      const double* const row_i = &a(i, 0);
      const double sum = a(i, j) - std::inner_product(row_i, row_i + j, &a(j, 0), 0.0);
      a(i, j) = i == j ? std::sqrt(sum) : sum / a(j, j);
    }
    (*x)[j] = ((*x)[j] - std::inner_product(x->begin(), x->begin() + static_cast<std::ptrdiff_t>(j), &a(j, 0), 0.0)) /
              a(j, j);
  }
  for (std::size_t j = n; j-- > 0;) {
    for (std::size_t i = j + 1; i < n; ++i) (*x)[j] -= a(i, j) * (*x)[i];
    (*x)[j] /= a(j, j);
  }
}

/// The rows of all islands with dependent ones in which some may close, signed so that one-sided ones have p >= 0.
struct Rows {
  std::vector<std::size_t> row;                       // of the model
  std::vector<std::optional<std::size_t>> one_sided;  // its number among these
  std::vector<double> S, b;                           // dense

  std::size_t size() const { return row.size(); }
};

Rows collect_rows(const Model& model, const ConstrainedSystem& system, const DependentProblem& problem) {
  const Numbering& numbering = model.numbering;
  std::vector<std::optional<std::size_t>> number(model.num_rows()), place(model.num_rows());
  for (std::size_t k = 0; k < numbering.one_sided.size(); ++k)
    number[static_cast<std::size_t>(numbering.one_sided[k].row)] = k;
  Rows rows;
  for (std::size_t island = 0; island < numbering.num_islands(); ++island) {
    const auto first = static_cast<std::size_t>(numbering.island_start[island]),
               end = static_cast<std::size_t>(numbering.island_start[island + 1]);
    bool depend = false, may_change = false;
    for (std::size_t row = first; row < end; ++row) {
      depend = depend || system.redundancy().is_dependent(row);
      may_change = may_change || (number[row] && problem.may_close[*number[row]] != 0);
    }
    for (std::size_t row = first; row < end && depend && may_change; ++row) {
      if (number[row] && problem.may_close[*number[row]] == 0) continue;
      place[row] = rows.size();
      rows.row.push_back(row);
      rows.one_sided.push_back(number[row]);
    }
  }
  const std::size_t n = rows.size();
  if (n > most_rows) return {};
  // S = K'M^-1K, point by point
  rows.S.assign(n * n, 0.0);
  rows.b.assign(n, 0.0);
  std::map<Index, std::vector<std::pair<std::size_t, Vec3>>> at_point;
  for (const Incidence& each : model.incidences) {
    const auto row = static_cast<std::size_t>(each.row);
    if (!place[row] || model.inverse_mass[static_cast<std::size_t>(each.point)] == 0.0) continue;
    const double side = number[row] ? numbering.one_sided[*number[row]].sign : 1.0;
    at_point[each.point].emplace_back(*place[row], side * each.sign * load(system.blocks().data(), each.block));
  }
  for (const auto& [point, arms] : at_point)
    for (const auto& [i, g] : arms)
      for (const auto& [j, h] : arms)
        rows.S[i * n + j] += model.inverse_mass[static_cast<std::size_t>(point)] * dot(g, h);
  double size = 0.0;
  for (std::size_t i = 0; i < n; ++i) size = std::max(size, rows.S[i * n + i]);
  for (std::size_t i = 0; i < n; ++i) {
    const double c = compliance * size;
    rows.S[i * n + i] += c;
    rows.b[i] = problem.b[rows.row[i]];
    if (rows.one_sided[i])
      rows.b[i] *= numbering.one_sided[*rows.one_sided[i]].sign;
    else if (!problem.multipliers.empty())
      rows.b[i] += c * problem.multipliers[rows.row[i]];
  }
  return rows;
}

}  // namespace

std::optional<std::vector<char>> close_dependent_rows(const Model& model, const ConstrainedSystem& system,
                                                      const DependentProblem& problem) {
  if (!system.redundancy().is_found()) return {};
  const Rows rows = collect_rows(model, system, problem);
  const std::size_t n = rows.size();
  if (std::ranges::none_of(rows.one_sided, [](const auto& each) { return each.has_value(); })) return {};
  std::vector<bool> open(n, false);
  for (Exchange exchange; !exchange.is_stuck();) {
    std::vector<std::size_t> closed;
    for (std::size_t i = 0; i < n; ++i)
      if (!open[i]) closed.push_back(i);
    std::vector<double> A, x;
    for (const std::size_t i : closed) {
      x.push_back(-rows.b[i]);
      for (const std::size_t j : closed) A.push_back(rows.S[i * n + j]);
    }
    solve_dense(&A, &x);
    double largest = 0.0;
    for (const double each : x) largest = std::max(largest, std::abs(each));
    std::vector<double> p(n, 0.0), rates = rows.b;
    for (std::size_t k = 0; k < closed.size(); ++k) p[closed[k]] = x[k];
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < n; ++i) {
      if (!rows.one_sided[i]) continue;
      const double diagonal = rows.S[i * n + i], little = rounding * compliance * largest;
      rates[i] += std::inner_product(p.begin(), p.end(), rows.S.begin() + static_cast<std::ptrdiff_t>(i * n), 0.0);
      if (open[i] ? rates[i] < -little * diagonal : p[i] < -little) wrong.push_back(i);
    }
    if (wrong.empty()) break;
    for (const std::size_t i : exchange.choose(wrong, open)) open[i] = !open[i];
  }
  std::vector<char> result(problem.may_close.begin(), problem.may_close.end());
  for (std::size_t i = 0; i < n; ++i)
    if (rows.one_sided[i]) result[*rows.one_sided[i]] = open[i] ? 0 : 1;
  return result;
}

/// Measures b = K'w + phi of all rows with the w of open ones.
void UnilateralRows::measure_free(const double* r, const double* v) {
  free_.b.resize(model_.num_rows());
  (void)workspace_.constraints.evaluate_right_side(model_.parallel, r, v, free_.w.data(), free_.b.data(), nullptr);
  (void)workspace_.constraints.evaluate_right_side(model_.parallel, selection_, r, v, free_.w.data(), all_rows_.data(),
                                                   nullptr);
  for (const OneSidedRow& each : rows_) {
    const auto row = static_cast<std::size_t>(each.row);
    free_.b[row] = all_rows_[row];
  }
}

/// Ropes of different length on one line do the same where points rest, and differ as soon as these move. Takes b of a
/// moment later if the points of rows that touch rest.
bool UnilateralRows::look_ahead(const Instant& at, const std::vector<char>& may_close) {
  constexpr double part = 0.03, at_rest = 0.01;  // of the time in which a row would turn; of the speed reached then
  if (free_.w.empty()) return false;
  double time = std::numeric_limits<double>::infinity(), speed = 0.0, fastest = 0.0;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    for (const Incidence& arm : arms_[k]) {
      if (may_close[k] == 0) continue;
      const double a = norm(load(at.to.a, arm.point));
      if (a > 0.0) time = std::min(time, part * std::sqrt(length(k) / a));
      fastest = std::max(fastest, a);
      speed = std::max(speed, norm(load(at.v, arm.point)));
    }
  }
  if (!std::isfinite(time) || speed > at_rest * time * fastest) return false;
  std::vector<double> v(at.v, at.v + 3 * model_.num_points());
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) v[i] += time * at.to.a[i];
  close_smooth(std::vector<char>(rows_.size(), 0));
  measure_free(at.r, v.data());
  return true;
}

}  // namespace tanor::detail
