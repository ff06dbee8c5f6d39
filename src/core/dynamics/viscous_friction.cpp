#include "dynamics/viscous_friction.hpp"

#include <variant>

#include "system/members.hpp"

namespace tanor::detail {

bool is_friction_viscous(const System& system) {
  for (std::size_t k = 0; k < system.friction.size(); ++k)
    if (!std::holds_alternative<Viscous>(system.friction[k]) && num_contacts(system, k) > 0) return false;
  return true;
}

ViscousFriction::ViscousFriction(const System& system, const Tangents& tangents) : tangents_(tangents) {
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Friction& law = system.friction[static_cast<std::size_t>(tangents[c].friction)];
    coefficients_.push_back(std::get<Viscous>(law).coefficient);
  }
}

void ViscousFriction::add_accelerations(const double* v, std::span<const double> inverse_mass, double* w) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const Index point = tangents_[c].point;
    add_to(w, point, inverse_mass[static_cast<std::size_t>(point)] * force(c, v));
  }
}

void ViscousFriction::add_derivatives(std::span<Block3> derivatives) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    Block3& own = derivatives[static_cast<std::size_t>(tangents_[c].point)];
    for (const Vec3& t : tangents_.directions(c)) own.add_product(-coefficients_[c], t, t);
  }
}

double ViscousFriction::power(const double* v) const {
  double sum = 0.0;
  for (std::size_t c = 0; c < tangents_.size(); ++c) sum += dot(force(c, v), load(v, tangents_[c].point));
  return sum;
}

}  // namespace tanor::detail
