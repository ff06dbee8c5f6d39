#include "statics/forces_without_potential.hpp"

#include <variant>

#include "statics/stiffness_matrix.hpp"

namespace tanor {

/// Each formula alone: all other forces have a potential, or are at rest nothing.
std::string name_forces_without_potential(const System& system, const std::vector<double>& positions, double t,
                                          double largest) {
  std::string names;
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    if (!std::holds_alternative<FormulaForce>(system.forces[k])) continue;
    System alone;
    alone.positions = positions;
    alone.masses = system.masses;
    alone.supports = system.supports;
    alone.forces = {system.forces[k]};
    Workspace work(std::move(alone), {}, t);
    std::vector<double> r(positions.size());
    work.model().numbering.gather_points(positions, r);
    StiffnessMatrix stiffness(work);
    stiffness.evaluate(t, r.data(), nullptr);
    if (stiffness.asymmetry() * stiffness.largest() > symmetric_to * largest)
      names += (names.empty() ? "" : ", ") + force_name(system, k);
  }
  return names;
}

}  // namespace tanor
