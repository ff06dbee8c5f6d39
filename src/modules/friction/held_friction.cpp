#include "friction/held_friction.hpp"

namespace tanor::detail {

Vec3 held_friction(const Tangents& tangents, const FrictionLaws& laws, std::size_t contact, const double* lambda) {
  const Tangents::Place& place = tangents[contact];
  Vec3 sum = laws.reference(contact);
  for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k)
    sum = sum + lambda[place.first_row + k] * tangents.directions(contact)[static_cast<std::size_t>(k)];
  return sum;
}

}  // namespace tanor::detail
