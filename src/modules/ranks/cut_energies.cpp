#include "ranks/cut_energies.hpp"

#include <algorithm>

namespace tanor::detail {

CutEnergies::CutEnergies(Workspace& work, const Part& part, Agreement& agreement)
    : work_(work), model_(work.model()), is_rheonomic_(agreement.any(model_.is_rheonomic())) {
  for (const Index guest : part.guests)
    guests_.push_back(static_cast<std::size_t>(model_.numbering.inner_point[static_cast<std::size_t>(guest)]));
  std::vector<char> is_elsewhere(model_.num_rows(), 0);  // [user row]
  for (const Part::SharedRow& shared : part.shared_rows) is_elsewhere[shared.equation] = shared.is_counted ? 0 : 1;
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    if (is_elsewhere[static_cast<std::size_t>(model_.numbering.user_row[a])] != 0) rows_counted_elsewhere_.push_back(a);
  }
  if (part.energies_counted_elsewhere.empty()) return;
  System others = model_.system;
  others.forces.clear();
  std::size_t num_pairs = 0;  // entries of pair forces so far
  for (std::size_t f = 0; f < model_.system.forces.size(); ++f) {
    const Force& force = model_.system.forces[f];
    const auto* const pairs = std::get_if<PairForces>(&force);
    const std::size_t entry = pairs != nullptr ? num_pairs++ : 0;
    if (std::ranges::find(part.energies_counted_elsewhere, f) == part.energies_counted_elsewhere.end()) continue;
    if (pairs != nullptr)
      add_pairs(entry, *pairs);
    else
      others.forces.push_back(force);
  }
  if (!others.forces.empty()) counted_elsewhere_ = std::make_unique<Forces>(others, model_.numbering);
}

void CutEnergies::add_pairs(std::size_t entry, const PairForces& pairs) {
  PairForces own = pairs;
  own.points.clear();
  const bool has_charges = pairs.charges.size() == pairs.points.size();
  if (has_charges) own.charges.clear();
  for (std::size_t k = 0; k < pairs.points.size(); ++k) {
    const Index inner = model_.numbering.inner_point[static_cast<std::size_t>(pairs.points[k])];
    if (static_cast<std::size_t>(inner) >= model_.num_moving()) continue;  // a guest
    own.points.push_back(pairs.points[k]);
    if (has_charges) own.charges.push_back(pairs.charges[k]);
  }
  pairs_with_guests_.push_back({entry, PairField(model_.system, own, model_.numbering)});
  work_.forces.leave_out_pairs_of_supports(entry);  // those of guests, which are their owners' business
}

/// Two ranks have each pair of a point and a guest, of whose energy each counts half.
double CutEnergies::potential_counted_elsewhere(double t, const double* r) {
  double result = counted_elsewhere_ ? counted_elsewhere_->potential(model_.parallel, t, r) : 0.0;
  for (auto& [entry, among_own] : pairs_with_guests_)
    result +=
        0.5 * (work_.forces.potential_of_pairs(model_.parallel, entry, r) - among_own.potential(model_.parallel, r));
  return result;
}

void CutEnergies::clear_guests(double* points) const {
  for (const std::size_t guest : guests_) store(points, guest, Vec3{});
}

Energy CutEnergies::energy(double t, const double* r, const double* v) {
  Energy result = work_.energy(t, r, v);
  result.potential -= potential_counted_elsewhere(t, r);
  return result;
}

double CutEnergies::potential(double t, const double* r) {
  return work_.forces.potential(model_.parallel, t, r) - potential_counted_elsewhere(t, r);
}

double CutEnergies::power_of_reactions(const double* accelerations, const double* v) const {
  return is_rheonomic_ ? model_.power(accelerations, v) : 0.0;
}

/// Guests move here as supports would, but what forces do to them is not counted as work of supports.
Power CutEnergies::power(const Kinematics& at, double of_constraints) {
  Power result;
  if (is_rheonomic_) {
    own_v_.assign(at.v, at.v + 3 * model_.num_points());
    clear_guests(own_v_.data());
    result.supports = of_constraints + work_.forces.elastic_power_of_supports(model_.parallel, at.x, own_v_.data());
  }
  if (work_.forces.has_work()) {
    result.forces = work_.forces.power(model_.parallel, at.x, at.v);
    result.potentials = work_.forces.energies().explicit_rate(model_.parallel);
  }
  if (counted_elsewhere_ && counted_elsewhere_->has_work()) {
    counted_elsewhere_->evaluate_powers(model_.parallel, at.t, at.x, at.v);
    result.potentials -= counted_elsewhere_->energies().explicit_rate(model_.parallel);
  }
  return result;
}

Power CutEnergies::power_along(const Kinematics& at, int terms, MotionSeries& series) {
  if (!is_rheonomic_) {
    work_.forces.evaluate_powers(model_.parallel, at.t, at.x, at.v);
    return power(at, 0.0);
  }
  points_.resize(3 * model_.num_points());
  work_.evaluate_free(at.t, at.x, at.v, points_.data());
  std::copy_n(at.v, points_.size(), points_.begin());
  std::fill_n(points_.begin(), 3 * model_.num_moving(), 0.0);
  clear_guests(points_.data());
  return power(at, series.power_of_constraints(at.t, at.x, points_.data(), terms, rows_counted_elsewhere_));
}

}  // namespace tanor::detail
