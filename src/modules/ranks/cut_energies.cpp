#include "ranks/cut_energies.hpp"

#include <algorithm>

namespace tanor::detail {

CutEnergies::CutEnergies(Workspace& work, const Part& part) : work_(work), model_(work.model()) {
  std::vector<char> is_elsewhere(model_.num_rows(), 0);  // [user row]
  for (const Part::SharedRow& shared : part.shared_rows) is_elsewhere[shared.equation] = shared.is_counted ? 0 : 1;
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    if (is_elsewhere[static_cast<std::size_t>(model_.numbering.user_row[a])] != 0) rows_elsewhere_.push_back(a);
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
double CutEnergies::potential_elsewhere(double t, const double* r) {
  double result = counted_elsewhere_ ? counted_elsewhere_->potential(model_.parallel, t, r) : 0.0;
  for (auto& [entry, among_own] : pairs_with_guests_)
    result +=
        0.5 * (work_.forces.potential_of_pairs(model_.parallel, entry, r) - among_own.potential(model_.parallel, r));
  return result;
}

double CutEnergies::rate_elsewhere(const Kinematics& at) {
  if (!counted_elsewhere_ || !counted_elsewhere_->has_work()) return 0.0;
  counted_elsewhere_->evaluate_powers(model_.parallel, at.t, at.x, at.v);
  return counted_elsewhere_->energies().explicit_rate(model_.parallel);
}

}  // namespace tanor::detail
