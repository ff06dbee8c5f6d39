#include "ranks/cut_factor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "dynamics/motion_series.hpp"
#include "evaluate/family.hpp"

namespace tanor::detail {

/// The rows of a rank in the order of elimination, shared rows last, by their place among those of all ranks.
struct CutFactor::Order {
  std::vector<Product> products;
  std::vector<int> permutation, place;    // [place] -> row and back
  std::vector<std::size_t> shared_place;  // [own shared row]
  std::vector<char> is_counted;           // likewise

  Order(const Model& model, const Part& part, Ordering wanted)
      : products(list_products(group_by_point(model.incidences, model.inverse_mass), model.inverse_mass, 0)) {
    const std::size_t num_rows = model.numbering.first_idle_row();
    const std::vector<const Part::SharedRow*> shared = find_shared_rows(model, part);
    const auto shared_at = [&](int row) { return shared[static_cast<std::size_t>(row)]; };
    std::vector<char> is_shared(num_rows);
    for (std::size_t a = 0; a < num_rows; ++a) is_shared[a] = shared[a] != nullptr ? 1 : 0;
    const GatherPlan unordered(products, num_rows, {}, Triangle::Lower);
    permutation = order_keeping({unordered.column_start(), unordered.rows()}, is_shared, wanted);
    const auto num_shared = std::ranges::count(is_shared, 1);
    std::sort(permutation.end() - num_shared, permutation.end(),
              [&](int a, int b) { return shared_at(a)->place < shared_at(b)->place; });
    place.resize(num_rows);
    for (std::size_t k = 0; k < num_rows; ++k) place[static_cast<std::size_t>(permutation[k])] = static_cast<int>(k);
    for (auto row = permutation.end() - num_shared; row != permutation.end(); ++row) {
      shared_place.push_back(shared_at(*row)->place);
      is_counted.push_back(shared_at(*row)->is_counted ? 1 : 0);
    }
  }
};

CutFactor::CutFactor(Workspace& work, const Part& part, const SolverOptions& options, const std::vector<double>& blocks)
    : CutFactor(work, part, options, blocks, Order(work.model(), part, options.ordering)) {}

CutFactor::CutFactor(Workspace& work, const Part& part, const SolverOptions& options, const std::vector<double>& blocks,
                     Order order)
    : RankRevealingFactor(work, options, blocks, nullptr),
      rank_(work, part),
      permutation_(std::move(order.permutation)),
      is_counted_(std::move(order.is_counted)),
      plan_(order.products, permutation_.size(), order.place, Triangle::Lower),
      factor_({plan_.column_start(), plan_.rows()}, is_counted_.size()),
      values_(plan_.rows().size()),
      ranks_(*part.ranks),
      shared_(part.ranks->make_shared_rows(part.num_shared_rows, order.shared_place)),
      shared_place_(std::move(order.shared_place)),
      triangle_(factor_.complement_size()),
      keeps_diagonal_(work.team().all(work.constraints.gradient_norms_are_constant())),
      diagonal_(part.num_shared_rows),
      shared_scale_(shared_place_.size()),
      x_(permutation_.size()) {
  if (shared_ == nullptr)
    shared_ = make_replicated_rows(*part.ranks, part.num_shared_rows, shared_place_, model_.parallel.threads());
}

SchurSolver::Summary CutFactor::summarize() {
  return {{LinearSolver::General},
          text(diagonal_.size()) + " equations are shared by several ranks",
          {.parts = 1,
           .pattern_nonzeros = plan_.rows().size(),
           .factor_nonzeros = static_cast<std::size_t>(factor_.num_stored()),
           .factorizations = {Factorization::Multifrontal}}};
}

Outcome CutFactor::factorize(double t, const double* r) {
  if (factorize_rows()) return {};
  if (!work_.team().all(is_finite(blocks_)))
    return {Status::Singular, "some constraint has no gradient at t = " + text(t)};
  // If rows depend on others, S has pivots of the size of rounding.
  if (rank_.decide(blocks_, r) && factorize_without_dependent_rows()) return {};
  return {Status::Singular,
          "constraints that several ranks share are singular to rounding at t = " + text(t) + "; take one rank"};
}

bool CutFactor::decide_rank_again(const double* r, RankScope scope) {
  if (scope == RankScope::DependentIslands && !rank_.is_found()) return false;
  return rank_.decide(blocks_, r) && factorize_without_dependent_rows();
}

bool CutFactor::factorize_without_dependent_rows() {
  knows_diagonal_ = false;
  is_active_.clear();
  for (const int row : permutation_) is_active_.push_back(rank_.is_dependent(static_cast<std::size_t>(row)) ? 0 : 1);
  return factorize_rows();
}

/// Turns rows that take no part into rows of the identity.
void CutFactor::leave_out_rows() {
  double* value = values_.data();
  for (std::size_t j = 0; j < is_active_.size(); ++j) {
    for (int e = plan_.column_start()[j]; e < plan_.column_start()[j + 1]; ++e, ++value) {
      const auto i = static_cast<std::size_t>(plan_.rows()[static_cast<std::size_t>(e)]);
      if (is_active_[i] == 0 || is_active_[j] == 0) *value = i == j ? 1.0 : 0.0;
    }
  }
}

/// Assembles and factorizes S. Returns true if it is definite, and not singular to rounding, on all ranks.
bool CutFactor::factorize_rows() {
  constexpr double poor = 1e-12;
  const Stopwatch watch(&work_.times.factor);
  ++work_.counters.factorizations;
  plan_.assemble(blocks_.data(), values_.data());
  leave_out_rows();
  const Cholesky::Quality own = factor_.factorize(values_.data(), model_.parallel.threads());
  // Every rank takes part in the sum, also one that has failed.
  scale_shared_rows();
  factor_.write_complement(triangle_.data());
  const double* const scale = plan_.scale().data() + factor_.num_eliminated();
  const auto rescaled = [&](std::size_t k) { return shared_scale_[k] / scale[k]; };
  double* entry = triangle_.data();
  for (std::size_t j = 0; j < num_shared(); ++j)
    for (std::size_t i = j; i < num_shared(); ++i) *entry++ *= rescaled(i) * rescaled(j);
  if (!own.positive_definite) std::fill(triangle_.begin(), triangle_.end(), 0.0);
  const double shared = shared_->factorize(triangle_);
  reciprocal_condition_ = std::min(own.reciprocal_condition, shared);
  return work_.team().all(own.positive_definite && shared > 0.0 && reciprocal_condition_ > poor);
}

/// Finds the scale that makes the diagonal of S one in the shared rows. On the diagonal of the complements' sum then
/// stands the part that elimination has left, and if all of that is rounding, it shows.
void CutFactor::scale_shared_rows() {
  if (knows_diagonal_) return;
  const double* const scale = plan_.scale().data() + factor_.num_eliminated();
  std::ranges::fill(diagonal_, 0.0);
  for (std::size_t k = 0; k < num_shared(); ++k) diagonal_[shared_place_[k]] = 1.0 / (scale[k] * scale[k]);
  ranks_.sum(diagonal_);
  for (std::size_t k = 0; k < num_shared(); ++k) shared_scale_[k] = 1.0 / std::sqrt(diagonal_[shared_place_[k]]);
  const auto is_finite = [](double x) { return std::isfinite(x); };
  knows_diagonal_ = keeps_diagonal_ && std::ranges::all_of(diagonal_, is_finite);
}

void CutFactor::solve_negative(const Parallel&, const double* b, double* x) {
  std::fill(x + model_.numbering.first_idle_row(), x + model_.num_rows(), 0.0);
  const std::size_t n = permutation_.size(), first_shared = factor_.num_eliminated();
  const double* const scale = plan_.scale().data();
  const auto rescaled = [&](std::size_t k) { return shared_scale_[k - first_shared] / scale[k]; };
  const auto row = [&](std::size_t k) { return static_cast<std::size_t>(permutation_[k]); };
  // S = D^-1 (scaled S) D^-1 with D = diag(scale).
  for (std::size_t k = 0; k < n; ++k) x_[k] = -scale[k] * b[row(k)];
  for (std::size_t k = first_shared; k < n; ++k) {
    if (is_counted_[k - first_shared] == 0) x_[k] = 0.0;
  }
  for (std::size_t k = 0; k < is_active_.size(); ++k) {
    if (is_active_[k] == 0) x_[k] = 0.0;
  }
  factor_.eliminate(x_.data(), model_.parallel.threads());
  for (std::size_t k = first_shared; k < n; ++k) x_[k] *= rescaled(k);
  shared_->solve(std::span(x_).subspan(first_shared));
  for (std::size_t k = first_shared; k < n; ++k) x_[k] *= rescaled(k);
  factor_.substitute(x_.data(), model_.parallel.threads());
  for (std::size_t k = 0; k < n; ++k) x[row(k)] = scale[k] * x_[k];
}

}  // namespace tanor::detail
