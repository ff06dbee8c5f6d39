#include "simulation/acceleration_split.hpp"

#include <algorithm>
#include <limits>
#include <random>

namespace tanor::detail {

namespace {

/// Fixed-seed random vector, so that no identity holds by accident.
std::vector<double> random_numbers(std::size_t count) {
  std::mt19937 generator(44);
  std::normal_distribution<double> normal;
  std::vector<double> result(count);
  for (double& number : result) number = normal(generator);
  return result;
}

constexpr double smallest_number = std::numeric_limits<double>::min();

}  // namespace

Outcome AccelerationSplit::find(const SolvedInstant& at, double* w_N, double* f_N) {
  tau_.resize(3 * model_.num_points());
  tau_N_.assign(3 * model_.num_points(), 0.0);
  forms_.main->write_friction(at.found, tau_.data());
  return forms_.normal != nullptr ? find_by_constraints(at, w_N, f_N) : find_by_coordinates(at, w_N, f_N);
}

Outcome AccelerationSplit::find_by_constraints(const SolvedInstant& at, double* w_N, double* f_N) {
  MultiplierForm& normal = *forms_.normal;
  // The factor of S includes contacts that stick, the split does not.
  const bool one_mass_serves = has_one_mass(model_) && normal.events() == nullptr;
  if (!normal_space_)
    normal_space_ = std::make_unique<NormalSpace>(work_, one_mass_serves ? &normal.linearization() : nullptr);
  if (normal.events() != nullptr) blocks_ = work_.without_contacts(normal.linearization().blocks());
  const std::vector<double>& blocks = normal.events() != nullptr ? blocks_ : normal.linearization().blocks();
  if (Outcome outcome = normal_space_->factorize(at.t, at.r.data(), blocks.data()); !outcome.ok()) return outcome;
  std::vector<double> c(model_.num_rows()), mu(model_.num_rows()), given(3 * model_.num_points(), 0.0);
  work_.write_support_accelerations(at.t, given.data());
  // K'w_N = -phi, with the supports' accelerations in phi (21)
  work_.constraints.evaluate_right_side(model_.parallel, at.r.data(), at.v.data(), given.data(), c.data(), nullptr);
  for (double& each : c) each = -each;
  for (std::size_t a = 0; a < c.size(); ++a) {
    if (model_.numbering.is_contact_row(a)) c[a] = 0.0;
  }
  normal_space_->find_least(c.data(), w_N, mu.data());
  normal_space_->project(work_.f.data(), f_N, mu.data());
  normal_space_->project(tau_.data(), tau_N_.data(), mu.data());

  // (44): measures how far M^-1 K x leaves N.
  std::vector<double> u(3 * model_.num_points(), 0.0), u_N(3 * model_.num_points());
  const std::vector<double> any = random_numbers(model_.num_rows());
  model_.gather.add_scaled(model_.parallel, blocks.data(), any.data(), model_.inverse_mass.data(), model_.num_moving(),
                           u.data());
  normal_space_->project(u.data(), u_N.data(), mu.data());
  mass_coupling_ = model_.largest_move(u.data(), u_N.data()) / std::max(model_.largest_norm(u.data()), smallest_number);
  return {};
}

Outcome AccelerationSplit::find_by_coordinates(const SolvedInstant& at, double* w_N, double* f_N) {
  TangentForm& tangent = *forms_.tangent;
  if (!tangent_space_) tangent_space_ = std::make_unique<TangentSpace>(work_);
  if (Outcome outcome = tangent_space_->factorize(at.t, tangent.dynamics().blocks().data()); !outcome.ok())
    return outcome;
  // u_N = (I - A G^-1 A') u (22)
  const auto normal_part = [&](const std::vector<double>& u, double* u_N) {
    tangent_space_->project(u.data(), u_N);
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) u_N[i] = u[i] - u_N[i];
  };
  normal_part(tangent.dynamics().psi(), w_N);
  normal_part(work_.f, f_N);
  std::fill(tau_N_.begin(), tau_N_.end(), 0.0);  // coordinates alone have no guides

  // (44): measures how far M A x leaves T.
  std::vector<double> u(3 * model_.num_points(), 0.0), u_N(3 * model_.num_points(), 0.0);
  const std::vector<double> any = random_numbers(tangent.size());
  work_.coordinates.apply(model_.parallel, tangent.dynamics().blocks().data(), any.data(), u.data());
  for (std::size_t i = 0; i < u.size(); ++i) u[i] *= model_.mass[i / 3];
  normal_part(u, u_N.data());
  mass_coupling_ = model_.largest_norm(u_N.data()) / std::max(model_.largest_norm(u.data()), smallest_number);
  return {};
}

}  // namespace tanor::detail
