#include "ranks/cut_energies.hpp"

namespace tanor {

CutEnergies::CutEnergies(Workspace& work, const Part& part, Agreement& agreement)
    : work_(work), model_(work.model()), is_rheonomic_(agreement.any(model_.is_rheonomic())) {
  for (const Index guest : part.guests)
    guests_.push_back(static_cast<std::size_t>(model_.numbering.inner_point[static_cast<std::size_t>(guest)]));
  if (part.energies_counted_elsewhere.empty()) return;
  System others = model_.system;
  others.forces.clear();
  for (const std::size_t f : part.energies_counted_elsewhere) others.forces.push_back(model_.system.forces[f]);
  counted_elsewhere_ = std::make_unique<Forces>(others, model_.numbering);
}

void CutEnergies::clear_guests(double* points) const {
  for (const std::size_t guest : guests_) store(points, guest, Vec3{});
}

Energy CutEnergies::energy(double t, const double* r, const double* v) {
  Energy result = work_.energy(t, r, v);
  if (counted_elsewhere_) result.potential -= counted_elsewhere_->potential(model_.parallel, t, r);
  return result;
}

double CutEnergies::potential(double t, const double* r) {
  const double own = work_.forces.potential(model_.parallel, t, r);
  return counted_elsewhere_ ? own - counted_elsewhere_->potential(model_.parallel, t, r) : own;
}

/// Of this rank's own points: reactions carry what supports do from rank to rank, also to ranks without any that move,
/// and so do forces; what these do to guests is no work of a support.
Power CutEnergies::power(const Kinematics& at, const double* reaction) {
  Power result;
  if (is_rheonomic_) {
    own_v_.assign(at.v, at.v + 3 * model_.num_points());
    clear_guests(own_v_.data());
    result.supports = work_.forces.elastic_power_of_supports(model_.parallel, at.x, own_v_.data()) +
                      model_.parallel.sum(model_.num_moving(), [&](std::size_t i) {
                        return model_.mass[i] * dot(load(reaction, i), load(at.v, i));
                      });
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

/// M^-1 eta = w - M^-1 f
Power CutEnergies::power_along(const Kinematics& at, const double* w) {
  if (!is_rheonomic_) {
    work_.forces.evaluate_powers(model_.parallel, at.t, at.x, at.v);
    return power(at, nullptr);
  }
  reaction_.resize(3 * model_.num_points());
  work_.evaluate_free(at.t, at.x, at.v, reaction_.data());
  for (std::size_t i = 0; i < reaction_.size(); ++i) reaction_[i] = w[i] - reaction_[i];
  return power(at, reaction_.data());
}

}  // namespace tanor
