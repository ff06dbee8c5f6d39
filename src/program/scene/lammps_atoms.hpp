#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/atom_styles.hpp"
#include "scene/lammps_lines.hpp"
#include "scene/periodic_cell.hpp"

namespace tanor::scene {

/// An atom of a LAMMPS file, with its image flags unwrapped.
struct LammpsAtom {
  std::int64_t id, type;
  Vector3 position;
};

/// A section Atoms, which is read when the rest of the file is known.
struct AtomsSection {
  LineReader title;
  std::size_t num_lines = 0;
  std::string style;  ///< as the scene or the file names it; empty if neither does
  AtomFacts facts{};
  Cell cell{};
  std::vector<std::array<std::int64_t, 2>> bonds{};  ///< ids
};

/// Reads the atoms. Their columns are those of the named style, or else those that all lines fit. Adds to `unread`
/// which columns are left out. Throws InputError (without a place) naming file and line.
std::vector<LammpsAtom> read_lammps_atoms(const LammpsLines& file, const AtomsSection& section,
                                          std::vector<std::string>* unread);

}  // namespace tanor::scene
