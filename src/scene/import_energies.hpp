#pragma once

#include <vector>

#include "scene/context.hpp"
#include "scene/imported.hpp"

namespace tanor::scene {

/// What an "import" makes of a LAMMPS file's bonds, angles and dihedrals.
struct ImportChoices {
  bool bonds_are_energies, angles_are_energies, dihedrals_are_energies;
  bool pairs_repel;                     ///< along FENE bonds, in place of their own repulsion
  std::vector<std::int64_t> rod_types;  ///< bond types that become rods instead; empty: none
};

/// Energies of a LAMMPS data file, a group for each type, by the coefficients of its styles: those that `import` names,
/// or else those of the comments behind the sections' titles. Our k is the number in front of ½(…)²: that of LAMMPS'
/// squares is doubled. `data`: of molecules that are joined. Throws InputError naming style, type and what is missing.
std::vector<Force> make_energies(const Imported& data, const ImportChoices& choices, const Cursor& import);

}  // namespace tanor::scene
