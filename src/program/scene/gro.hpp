#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Reads the first frame of a GROMACS .gro file: positions (nm), velocities (nm/ps) and the periodic box. Elements are
/// guessed from the names of atoms, and there are no bonds in such a file. Later frames are named as unread. `name` is
/// the file's name for errors. Throws InputError (without a place) naming file and line.
Imported read_gro(const std::string& name, std::string_view text);

}  // namespace tanor::scene
