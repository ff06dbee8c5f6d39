#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// The first frame of a GROMACS .gro file: positions (nm), velocities (nm/ps), periodic box; elements are guessed from
/// the names of atoms. There are no bonds in such a file. `name` of the file, for errors: throws InputError (without a
/// place) naming file and line.
Imported read_gro(const std::string& name, std::string_view text);

}  // namespace tanor::scene
