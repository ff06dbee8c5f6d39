#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Atoms, bonds, angles and dihedrals of a LAMMPS data file, with the coefficients of their styles. The atoms stand in
/// the order of their ids, so that ids 1 … n become points 0 … n - 1; masses are 1 where the file has none. Reads atom
/// styles atomic, bond, angle, molecular, charge and full; the style is the comment behind `Atoms`, or else guessed
/// from the number of columns (atomic 5 or 8, molecular 6 or 9, full 7 or 10). Other sections are skipped and named.
/// `name` of the file, for errors: throws InputError (without a place) naming file and line.
Imported read_lammps_data(const std::string& name, std::string_view text);

}  // namespace tanor::scene
