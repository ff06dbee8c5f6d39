#include "ranks/cut_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "evaluate/family.hpp"
#include "ranks/replicated_rows.hpp"

namespace tanor::detail {

/// The rows of a rank in the order of elimination, shared rows last, by their place among those of all ranks.
struct CutSolver::Order {
  std::vector<Product> products;
  std::vector<int> permutation, place;    // [place] -> row and back
  std::vector<std::size_t> shared_place;  // [own shared row]
  std::vector<char> is_counted;           // likewise

  Order(const Model& model, const Part& part, Ordering wanted)
      : products(list_products(group_by_point(model.incidences, model.inverse_mass), model.inverse_mass, 0)) {
    const std::size_t num_rows = model.numbering.first_idle_row();
    std::vector<const Part::SharedRow*> shared_of(model.num_rows(), nullptr);  // [equation]
    for (const Part::SharedRow& shared : part.shared_rows) shared_of[shared.equation] = &shared;
    const auto shared_at = [&](std::size_t row) {
      return shared_of[static_cast<std::size_t>(model.numbering.user_row[row])];
    };
    std::vector<char> is_shared(num_rows);
    for (std::size_t a = 0; a < num_rows; ++a) is_shared[a] = shared_at(a) != nullptr ? 1 : 0;
    const GatherPlan unordered(products, num_rows, {}, Triangle::Lower);
    permutation = order_keeping({unordered.column_start(), unordered.rows()}, is_shared, wanted);
    const auto num_shared = std::ranges::count(is_shared, 1);
    std::sort(permutation.end() - num_shared, permutation.end(), [&](int a, int b) {
      return shared_at(static_cast<std::size_t>(a))->place < shared_at(static_cast<std::size_t>(b))->place;
    });
    place.resize(num_rows);
    for (std::size_t k = 0; k < num_rows; ++k) place[static_cast<std::size_t>(permutation[k])] = static_cast<int>(k);
    for (auto row = permutation.end() - num_shared; row != permutation.end(); ++row) {
      shared_place.push_back(shared_at(static_cast<std::size_t>(*row))->place);
      is_counted.push_back(shared_at(static_cast<std::size_t>(*row))->is_counted ? 1 : 0);
    }
  }
};

CutSolver::CutSolver(const Model& model, const Part& part, Ordering ordering, bool keeps_diagonal)
    : CutSolver(model, part, Order(model, part, ordering), keeps_diagonal) {}

CutSolver::CutSolver(const Model& model, const Part& part, Order order, bool keeps_diagonal)
    : threads_(model.parallel.threads()),
      num_all_shared_(part.num_shared_rows),
      permutation_(std::move(order.permutation)),
      is_counted_(std::move(order.is_counted)),
      plan_(order.products, permutation_.size(), order.place, Triangle::Lower),
      factor_({plan_.column_start(), plan_.rows()}, is_counted_.size()),
      ranks_(*part.ranks),
      shared_(part.ranks->make_shared_rows(part.num_shared_rows, order.shared_place)),
      shared_place_(std::move(order.shared_place)),
      triangle_(factor_.complement_size()),
      keeps_diagonal_(keeps_diagonal),
      diagonal_(part.num_shared_rows),
      shared_scale_(shared_place_.size()),
      x_(permutation_.size()) {
  if (shared_ == nullptr)
    shared_ = std::make_unique<ReplicatedRows>(*part.ranks, part.num_shared_rows, shared_place_, threads_);
}

void CutSolver::set_active(std::span<const char> rows) {
  knows_diagonal_ = false;
  is_active_.clear();
  for (std::size_t k = 0; !rows.empty() && k < permutation_.size(); ++k)
    is_active_.push_back(rows[static_cast<std::size_t>(permutation_[k])]);
}

/// Turns rows that take no part into rows of the identity.
void CutSolver::leave_out_rows() {
  double* value = factor_.values();
  for (std::size_t j = 0; j < is_active_.size(); ++j) {
    for (int e = plan_.column_start()[j]; e < plan_.column_start()[j + 1]; ++e, ++value) {
      const auto i = static_cast<std::size_t>(plan_.rows()[static_cast<std::size_t>(e)]);
      if (is_active_[i] == 0 || is_active_[j] == 0) *value = i == j ? 1.0 : 0.0;
    }
  }
}

CutSolver::Quality CutSolver::factorize(const double* blocks) {
  plan_.assemble(blocks, factor_.values());
  leave_out_rows();
  const Cholesky::Quality own = factor_.factorize(threads_);
  Quality result{own.positive_definite, true, 0, own.reciprocal_condition};
  if (factor_.num_eliminated() > 0) result.weakest_row = static_cast<std::size_t>(permutation_[own.weakest_column]);
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
  result.shared_is_definite = shared > 0.0;
  result.reciprocal_condition = std::min(result.reciprocal_condition, shared);
  return result;
}

/// Finds the scale that makes the diagonal of S one in the shared rows. On the diagonal of the complements' sum then
/// stands the part that elimination has left, and if all of that is rounding, it shows.
void CutSolver::scale_shared_rows() {
  if (knows_diagonal_) return;
  const double* const scale = plan_.scale().data() + factor_.num_eliminated();
  std::ranges::fill(diagonal_, 0.0);
  for (std::size_t k = 0; k < num_shared(); ++k) diagonal_[shared_place_[k]] = 1.0 / (scale[k] * scale[k]);
  ranks_.sum(diagonal_);
  for (std::size_t k = 0; k < num_shared(); ++k) shared_scale_[k] = 1.0 / std::sqrt(diagonal_[shared_place_[k]]);
  const auto is_finite = [](double x) { return std::isfinite(x); };
  knows_diagonal_ = keeps_diagonal_ && std::ranges::all_of(diagonal_, is_finite);
}

void CutSolver::solve_negative(const double* b, double* x) {
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
  factor_.eliminate(x_.data(), threads_);
  for (std::size_t k = first_shared; k < n; ++k) x_[k] *= rescaled(k);
  shared_->solve(std::span(x_).subspan(first_shared));
  for (std::size_t k = first_shared; k < n; ++k) x_[k] *= rescaled(k);
  factor_.substitute(x_.data(), threads_);
  for (std::size_t k = 0; k < n; ++k) x[row(k)] = scale[k] * x_[k];
}

}  // namespace tanor::detail
