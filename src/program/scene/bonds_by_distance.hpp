#pragma once

#include <vector>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Finds bonds between atoms that are closer than the sum of their covalent radii plus 0.45 angstrom, but farther than
/// 0.4 (the rule of Open Babel, O'Boyle et al., J. Cheminf. 3 (2011) 33), in the nearest image of a periodic cell.
/// Atoms without an element have no bonds. Time and memory grow with the number of atoms.
std::vector<Imported::Bond> find_bonds_by_distance(const Imported& data);

}  // namespace tanor::scene
