#include "statics/forces_without_potential.hpp"

#include <variant>

#include "statics/stiffness_matrix.hpp"

namespace tanor::detail {

namespace {

/// Calls visit(name, work, r) for each formula alone. All other forces have a potential, or are zero at rest.
template <class Visit>
void for_each_formula(const System& system, const std::vector<double>& positions, double t, const Visit& visit) {
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
    visit(force_name(system, k), work, r);
  }
}

}  // namespace

std::string name_forces_without_potential(const System& system, const std::vector<double>& positions, double t,
                                          double largest) {
  std::string names;
  for_each_formula(system, positions, t, [&](const std::string& name, Workspace& work, const std::vector<double>& r) {
    StiffnessMatrix stiffness(work);
    stiffness.evaluate(t, r.data(), nullptr);
    if (stiffness.asymmetry() * stiffness.largest() > symmetric_to * largest)
      names += (names.empty() ? "" : ", ") + name;
  });
  return names;
}

std::vector<std::string> list_formulas_on_velocities(const System& system, const std::vector<double>& positions,
                                                     double t) {
  std::vector<std::string> names;
  for_each_formula(system, positions, t, [&](std::string name, Workspace& work, const std::vector<double>& r) {
    if (StiffnessMatrix(work).find_damping(t, r.data()).norm() > 0.0) names.push_back(std::move(name));
  });
  return names;
}

}  // namespace tanor::detail
