#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Reads atoms, bonds, angles and dihedrals of a LAMMPS data file, with the coefficients of their styles. The atoms are
/// sorted by their ids, so that ids 1 … n become points 0 … n - 1. Masses are 1 if the file has none. Types may have
/// labels. The columns of the section Atoms are those of `atom_style`, as the command of LAMMPS takes it, or else of
/// the comment behind `Atoms`, or else of the one style that all its lines fit. Other sections, columns that are not 0
/// and lines of the header are named as unread. `name` is the file's name for errors. Throws InputError (without a
/// place) naming file and line, also where the columns fit styles that differ in types or places.
Imported read_lammps_data(const std::string& name, std::string_view text, const std::string& atom_style = {});

/// Returns true if the text is that of a LAMMPS data file: its header tells the number of atoms.
bool is_lammps_data(const std::string& name, std::string_view text);

}  // namespace tanor::scene
