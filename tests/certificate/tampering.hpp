#pragma once

#include <vector>

#include "certificate/certified.hpp"
#include "friction/guide_contacts.hpp"

namespace tanor::detail {

/// Changes single numbers inside a solver. Certificates must find every change.
struct Tampering {
  static std::size_t num_slots(GramSolver& solver) {
    std::size_t count = 0;
    for (const auto& part : solver.assembled()) count += part.size();
    return count;
  }
  /// Changes one number of the scaled matrix, then factorizes it as usual.
  static void corrupt_slot(GramSolver& solver, std::size_t slot, double by) {
    for (const auto& part : solver.assembled()) {
      if (slot < part.size()) {
        part[slot] += by;
        break;
      }
      slot -= part.size();
    }
    (void)solver.factorize(Parallel(1));
  }
  static GramSolver& S(const Forms& forms) { return forms.normal->linearization().gram(); }  // of the general solver
  static GramSolver& H(const Forms& forms) { return forms.tangent->linearization().gram(); }
  static std::vector<double>& K(const Forms& forms) {
    return const_cast<std::vector<double>&>(forms.normal->linearization().blocks());
  }
  /// Eliminates once more with one point moved by `move`; K itself stays. Returns false if no composite of solvers
  /// serves the system.
  static bool corrupt_elimination(Forms& forms, std::vector<double> r, std::size_t point, Vec3 move) {
    auto* const composite = dynamic_cast<CompositeSolver*>(&forms.normal->linearization().factor());
    if (composite == nullptr) return false;
    std::vector<double> blocks = K(forms);
    add_to(r.data(), point, move);
    (void)composite->linearise(Parallel(1), r.data(), nullptr, blocks.data());
    return true;
  }
  /// Repeats the last check of contacts at rest, with multipliers of guides times `factor`.
  static Outcome check_rest(Case& solved, const std::vector<double>& w, double factor) {
    MultiplierForm& normal = *solved.forms.normal;
    const Tangents& tangents = solved.forms.work.constraints.tangents();
    std::vector<double>& lambda = normal.dynamics().multipliers();
    const std::vector<double> found = lambda;
    for (std::size_t c = 0; c < tangents.size(); ++c) {
      for (int g = 0; g < tangents[c].num_guides; ++g)
        lambda[static_cast<std::size_t>(tangents[c].guide_row[static_cast<std::size_t>(g)])] *= factor;
    }
    std::vector<double> accelerations = w;
    ModeSwitch at{0.0, solved.r.data(), solved.v.data(), accelerations.data(), {}};
    at.at_rest.assign(tangents.size(), 1);
    Outcome outcome = static_cast<const GuideContacts&>(*normal.contacts()).modes().check_rest(at);
    lambda = found;
    return outcome;
  }
  /// The kernels of the first helix that run on the definition, along the motion and around the place.
  static auto& along_helix(Forms& forms) { return *helices(forms).definitions()[0].along; }
  static auto& around_helix(Forms& forms) { return *helices(forms).definitions()[0].around; }
  static JetKernel<Helices>& helices(Forms& forms) {
    return const_cast<JetKernel<Helices>&>(forms.work.constraints.family<JetKernel<Helices>>().kernel);
  }
  static void refactorize(Forms& forms) {
    S(forms).assemble(Parallel(1), K(forms).data());
    (void)S(forms).factorize(Parallel(1));
  }
};

/// Makes three unequal rods on a driven support. The last bead is on a sphere whose radius changes with time.
inline System make_driven_chain() {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.1, 1.5, 0.6, 0.0, 1.2, 0.9, -0.7};
  system.masses = {1.0, 0.3, 2.0, 0.7};
  system.velocities.assign(12, 0.0);
  system.supports = {{"", {0}, VectorFunction(ScalarFunction::formula("0.1*t^2"), 0.0, 0.0)}};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 3}}, {}, {}},
                        Spheres{"ball", {3}, Vector3{1.0, 0.0, -2.0}, ScalarFunction::formula("sqrt(2.54)+0.3*t^2")}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}, Springs{"spring", {{1, 3}}, 5.0, 0.2, 0.5}};
  return system;
}

/// Makes the same rods alone, with directions in space as coordinates.
inline System make_chain_with_coordinates() {
  System system = make_driven_chain();
  system.constraints.pop_back();
  system.velocities = {0.0, 0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.4, 0.0, 0.0, 0.4, 0.0};
  system.coordinates = {ChainAngles{"chain", {1, 2, 3}, 0, {}, {}}};
  return system;
}

inline System only_coordinates() {
  System system = make_chain_with_coordinates();
  system.constraints.clear();
  return system;
}

}  // namespace tanor::detail
