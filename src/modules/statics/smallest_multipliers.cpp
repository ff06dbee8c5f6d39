#include "statics/smallest_multipliers.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/self_stress.hpp"

namespace tanor::detail {

namespace {

/// A row counts as dependent below this singular value of the unit columns of K. Collapsed nets have singular values up
/// to 1e-6, as far as roots of rounding errors determine their positions, and then none below 1e-2. Singular values of
/// long chains fall with their length by nature.
constexpr double dependent = 1e-5;
constexpr double short_chain = 1e3;
/// Up to this number of rows QR always decides the rank; with more rows it does if S looks singular.
constexpr std::size_t most_rows = 3000;
constexpr double suspect_below = 1e-9;

}  // namespace

Outcome SmallestMultipliers::find(const std::vector<double>& r, const std::vector<double>& given,
                                  std::vector<double>* lambda) {
  const Model& model = equations_.model();
  const double t = equations_.time();
  for (std::vector<double>* each : {&xi_, &b_}) each->resize(model.num_rows());
  for (std::vector<double>* each : {&w_, &dw_}) each->assign(3 * model.num_points(), 0.0);
  g_.resize(equations_.size());
  if (Outcome outcome = linearization_.update(t, r.data()); !outcome.ok()) return outcome;
  // S (lambda - given) = -K'M^-1(f + K given)
  if (!std::isfinite(evaluate(r, given))) return model.not_finite(t);
  lambda->assign(model.num_rows(), 0.0);
  linearization_.solve_refined(b_.data(), lambda->data(), dw_.data());
  linearization_.minimize_multiplier_norm(r.data(), lambda->data());
  for (std::size_t a = 0; a < lambda->size(); ++a) (*lambda)[a] += given[a];
  return {};
}

/// Computes b = K'M^-1(f + K lambda). Returns the scale of forces, N.
double SmallestMultipliers::evaluate(const std::vector<double>& r, const std::vector<double>& lambda) {
  const double scale = equations_.evaluate(r.data(), lambda.data(), g_.data(), xi_.data());
  for (std::size_t i = 0; i < g_.size(); ++i) w_[i] = equations_.model().inverse_mass[i / 3] * g_[i];
  (void)linearization_.apply_transposed(w_.data(), nullptr, b_.data());
  return scale;
}

Outcome SmallestMultipliers::find_and_decide(const std::vector<double>& r, const std::vector<double>& given,
                                             std::vector<double>* lambda, RankReport* rank) {
  *rank = {};
  rank->rank = equations_.num_rows();
  rank->degrees_of_freedom = equations_.size() - std::min(rank->rank, equations_.size());
  if (equations_.model().num_rows() == 0) return {};
  if (Outcome outcome = find(r, given, lambda); !outcome.ok()) return outcome;
  dependences_.reset();
  const std::size_t num_rows = equations_.num_rows();
  if (num_rows == 0 || (num_rows > most_rows && linearization_.reciprocal_condition() > suspect_below)) {
    *rank = this->rank();
    return {};
  }
  const Model& model = equations_.model();
  const auto rows = static_cast<Index>(num_rows);
  const double tolerance = dependent * std::min(1.0, short_chain / static_cast<double>(rows));
  dependences_.emplace(equations_.work());
  (void)dependences_->decide(linearization_.blocks().data(), {0, rows},
                             std::vector<double>(model.num_rows(), tolerance));
  if (dependences_->is_found()) {
    dependences_->take_qr({0, rows});
    *lambda = given;
    solve_by_qr(r, lambda);
  }
  *rank = dependences_->report();
  return {};
}

std::vector<double> SmallestMultipliers::keep_self_stress(std::vector<double> lambda) const {
  std::vector<double> rest = lambda;
  if (dependences_ && dependences_->is_found()) dependences_->minimize_norm(rest.data());
  for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] -= rest[a];
  return lambda;
}

std::vector<double> SmallestMultipliers::find_self_stress() const {
  return dependences_ ? detail::find_self_stress(*dependences_, equations_.model().numbering) : std::vector<double>();
}

/// Solves S dlambda = -K'M^-1(f + K lambda) without the dependent rows, and repeats that with the remaining residual.
void SmallestMultipliers::solve_by_qr(const std::vector<double>& r, std::vector<double>* lambda) {
  constexpr int rounds = 3;
  const std::vector<double> given = *lambda;
  for (int round = 0; round < rounds; ++round) {
    (void)evaluate(r, *lambda);
    dependences_->solve_negative(b_.data(), b_.data());
    for (std::size_t a = 0; a < equations_.num_rows(); ++a) (*lambda)[a] += b_[a];
  }
  for (std::size_t a = 0; a < lambda->size(); ++a) (*lambda)[a] -= given[a];
  dependences_->minimize_norm(lambda->data());
  for (std::size_t a = 0; a < lambda->size(); ++a) (*lambda)[a] += given[a];
}

std::vector<std::size_t> list_dependent_rows(const Model& model, const RankReport& rank) {
  std::vector<char> depends(model.numbering.num_user_rows, 0);
  for (const RowDependence& each : rank.dependences) depends[each.row] = each.terms.empty() ? 0 : 1;
  std::vector<std::size_t> result;
  for (std::size_t a = 0; a < model.num_rows(); ++a) {
    if (depends[static_cast<std::size_t>(model.numbering.user_row[a])] != 0) result.push_back(a);
  }
  return result;
}

}  // namespace tanor::detail
