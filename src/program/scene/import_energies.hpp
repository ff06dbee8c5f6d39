#pragma once

#include <vector>

#include "scene/context.hpp"
#include "scene/imported.hpp"

namespace tanor::scene {

/// The use that an "import" makes of a LAMMPS file's bonds, angles and dihedrals.
struct ImportChoices {
  bool bonds_are_energies, angles_are_energies, dihedrals_are_energies;
  bool pairs_repel;                     ///< along FENE bonds, in place of their own repulsion
  std::vector<std::int64_t> rod_types;  ///< bond types that become rods instead; empty if none
};

/// Returns the energies of a LAMMPS data file, a group for each type, from the coefficients of its styles. The styles
/// are those that `import` names, or else those of the comments after the sections' titles. The stiffness k of tanor
/// stands in ½ k(…)², so that the coefficients of LAMMPS' squares are doubled. `data` must hold joined molecules.
/// Throws InputError naming style, type and what is missing.
std::vector<Force> make_energies(const Imported& data, const ImportChoices& choices, const Cursor& import);

}  // namespace tanor::scene
