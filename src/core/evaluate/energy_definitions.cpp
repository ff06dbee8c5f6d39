#include "evaluate/energy_definitions.hpp"

#include "base/rounded.hpp"
#include "base/vec3.hpp"
#include "evaluate/dual.hpp"
#include "kinds/energy_groups.hpp"

namespace tanor::detail {

namespace {

/// Subtracts the gradients of a group, found along one coordinate after the other.
template <HasEnergy Group>
void subtract_gradients(const System& system, const Group& group, std::span<const double> r, DefinedForces* to) {
  using Number = Dual<Rounded>;
  constexpr std::size_t p = points_of_member<Group>();
  const typename KindOf<Group>::template Definition<Number> definition(group);
  for (std::size_t k = 0; k < num_members(group); ++k) {
    const std::span<const Index> points = member_points(group, k);
    std::array<TripleOf<Number>, p> places;
    for (std::size_t i = 0; i < p; ++i) {
      const Vec3 at = load(r.data(), points[i]);
      places[i] = {at.x, at.y, at.z};
    }
    std::array<Number, KindOf<Group>::most_numbers> numbers;
    const auto given = law_numbers_of(system, group, k);
    std::copy(given.begin(), given.end(), numbers.begin());
    for (std::size_t i = 0; i < p; ++i) {
      Vec3 gradient, error;
      for (const auto& [in_place, in_gradient] :
           {std::pair{&TripleOf<Number>::x, &Vec3::x}, std::pair{&TripleOf<Number>::y, &Vec3::y},
            std::pair{&TripleOf<Number>::z, &Vec3::z}}) {
        Number& coordinate = places[i].*in_place;
        coordinate.d = 1.0;
        const Rounded slope = definition.energy(places, numbers).d;
        gradient.*in_gradient = slope.v;
        error.*in_gradient = slope.error;
        coordinate.d = 0.0;
      }
      add_to(to->f.data(), points[i], -gradient);
      add_to(to->rounding.data(), points[i], error);
    }
  }
}

void subtract_gradients(const System& system, const Potential& given, double t, std::span<const double> r, double* f) {
  const EnergyGroup group = make_energy_group(system, given);
  const auto p = static_cast<std::size_t>(group.kernel.num_points),
             c = static_cast<std::size_t>(group.kernel.num_constants);
  std::vector<double> places(3 * p), gradient(3 * p);
  for (std::size_t k = 0; k < given.points.size(); ++k) {
    for (std::size_t i = 0; i < p; ++i) store(places.data(), i, load(r.data(), given.points[k][i]));
    double energy = 0.0;
    group.kernel.evaluate(group.kernel.context.get(),
                          {1, t, places.data(), group.constants.data() + c * k, &energy, gradient.data()});
    for (std::size_t i = 0; i < p; ++i) add_to(f, given.points[k][i], -load(gradient.data(), i));
  }
}

}  // namespace

DefinedForces find_defined_forces(const System& system, double t, std::span<const double> r) {
  DefinedForces result{std::vector<double>(r.size(), 0.0), std::vector<double>(r.size(), 0.0)};
  for (const Force& force : system.forces) {
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (std::is_same_v<Group, Potential>) {
            subtract_gradients(system, group, t, r, result.f.data());
          } else if constexpr (HasEnergy<Group>) {
            if constexpr (std::is_same_v<Group, Bonds>) {
              if (group.law == BondLaw::Harmonic) return;
            }
            subtract_gradients(system, group, r, &result);
          }
        },
        force);
  }
  return result;
}

}  // namespace tanor::detail
