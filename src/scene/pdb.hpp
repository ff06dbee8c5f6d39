#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Atoms (ATOM, HETATM) of the first model of a PDB file, in angstroms, with the bonds of CONECT, each once, and the
/// cell of CRYST1. Of an atom with alternative places the first one counts. Elements stand in columns 77 and 78, or are
/// guessed from the names. `name` of the file, for errors: throws InputError (without a place) naming file and line.
Imported read_pdb(const std::string& name, std::string_view text);

}  // namespace tanor::scene
