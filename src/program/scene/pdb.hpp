#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Reads the atoms (ATOM, HETATM) of the first frame of a PDB file, in angstroms, with the bonds of CONECT, each once,
/// and the cell of CRYST1. A frame ends with ENDMDL, MODEL or END. Of alternative positions of an atom the first one is
/// used. Elements are read from columns 77 and 78, or guessed from the names. Other records, frames and positions are
/// named as unread. `name` is the file's name for errors. Throws InputError (without a place) naming
/// file and line.
Imported read_pdb(const std::string& name, std::string_view text);

}  // namespace tanor::scene
