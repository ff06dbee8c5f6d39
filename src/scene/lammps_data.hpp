#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Reads atoms, bonds, angles and dihedrals of a LAMMPS data file, with the coefficients of their styles. The atoms are
/// sorted by their ids, so that ids 1 … n become points 0 … n - 1. Masses are 1 if the file has none. The atom styles
/// atomic, bond, angle, molecular, charge and full are supported. The style is the comment after `Atoms`, or else
/// guessed from the number of columns (atomic 5 or 8, molecular 6 or 9, full 7 or 10). Other sections are skipped and
/// named. `name` is the file's name for errors. Throws InputError (without a place) naming file and line.
Imported read_lammps_data(const std::string& name, std::string_view text);

}  // namespace tanor::scene
