#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

#include <tanor/time_function.hpp>

#include "scene/elements.hpp"
#include "scene/periodic_cell.hpp"

namespace tanor::scene {

/// The content of another program's file, in the order of its points and in its own units. If the file has no cell,
/// bonds or angles, these are empty.
struct Imported {
  /// Atoms that are joined; the corner of an angle is in the middle.
  template <std::size_t size>
  struct Member {
    std::int64_t type;
    std::array<std::int32_t, size> atoms;
    std::int64_t id = 0;
  };
  using Bond = Member<2>;
  using Angle = Member<3>;
  using Dihedral = Member<4>;
  /// A section of coefficients: the style named by the comment after its title, or an empty one, and the numbers of
  /// each type. What else stands there is an error only where energies are asked for.
  struct Coefficients {
    std::string style{};
    std::map<std::int64_t, std::vector<double>> of_type{};
    std::string error{};  ///< about the first line that cannot be used: "a.data, line 9: found …"
  };

  Cell cell;
  std::int64_t num_bond_types = 1;
  std::vector<Vector3> positions;        ///< with image flags unwrapped
  std::vector<Vector3> velocities;       ///< empty if the file has none
  std::vector<double> masses;            ///< empty if the file has none
  std::vector<const Element*> elements;  ///< of each atom, null if unknown; empty if the file has no elements
  std::string without_element;           ///< the first atom without an element: "a.gro, line 6: atom MW"
  double angstrom = 0.0;                 ///< in the file's unit, if elements are known
  std::vector<Bond> bonds;
  std::vector<Angle> angles;
  std::vector<Dihedral> dihedrals;
  Coefficients bond_coefficients, angle_coefficients, dihedral_coefficients;
  std::string units;                ///< of a LAMMPS file, from its first line: "real"; empty if not given
  std::vector<std::string> unread;  ///< what the file has and the import leaves out: "the section Impropers"
};

/// Collects the edges of a file as bonds, each once, although faces and lists name many of them twice.
class Edges {
 public:
  void add(std::int32_t i, std::int32_t j) {
    const auto low = static_cast<std::uint64_t>(i < j ? i : j), high = static_cast<std::uint64_t>(i < j ? j : i);
    if (known_.insert(high << 32 | low).second) bonds_.push_back({1, {i, j}});
  }
  std::vector<Imported::Bond> take() { return std::move(bonds_); }

 private:
  std::unordered_set<std::uint64_t> known_;
  std::vector<Imported::Bond> bonds_;
};

// ---- readers ----
// `name` is the file's name for errors. All throw InputError (without a place) naming file, and line or element.

/// Reads atoms, bonds, angles and dihedrals of a LAMMPS data file, with the coefficients of their styles. The atoms are
/// sorted by their ids, so that ids 1 … n become points 0 … n - 1. Masses are 1 if the file has none. Types may have
/// labels. The columns of the section Atoms are those of `atom_style`, as the command of LAMMPS takes it, or else of
/// the comment behind `Atoms`, or else of the one style that all its lines fit. Other sections, columns that are not 0
/// and lines of the header are named as unread. Throws also where the columns fit styles that differ in types or
/// places.
Imported read_lammps_data(const std::string& name, std::string_view text, const std::string& atom_style = {});

/// Returns true if the text is that of a LAMMPS data file: its header tells the number of atoms.
bool is_lammps_data(const std::string& name, std::string_view text);

/// Reads the vertices of a Wavefront .obj file, with the edges of its lines (`l`) and faces (`f`), each once. Indices
/// may be relative (negative), lines may be continued by a backslash, and `#` begins a comment anywhere. Other lines,
/// such as normals, textures, groups, curves and surfaces, are named as unread.
Imported read_obj(const std::string& name, std::string_view text);

/// Reads the vertices (x, y, z) of a Stanford .ply file, ascii or binary of either byte order, with its edges
/// (`vertex1`, `vertex2`) and those of its faces and strips of triangles (`vertex_indices` or `vertex_index` of `face`
/// and `tristrips`), each once. Other elements and properties may hold anything, and are named as unread.
Imported read_ply(const std::string& name, std::string_view text);

/// Reads the first frame of a GROMACS .gro file: positions (nm), velocities (nm/ps) and the periodic box. Elements are
/// guessed from the names of atoms, and there are no bonds in such a file. Later frames are named as unread.
Imported read_gro(const std::string& name, std::string_view text);

/// Reads the atoms (ATOM, HETATM) of the first frame of a PDB file, in angstroms, with the bonds of CONECT, each once,
/// and the cell of CRYST1. A frame ends with ENDMDL, MODEL or END. Of alternative positions of an atom the first one is
/// used. Elements are read from columns 77 and 78, or guessed from the names. Other records, frames and positions are
/// named as unread.
Imported read_pdb(const std::string& name, std::string_view text);

/// Finds bonds between atoms that are closer than the sum of their covalent radii plus 0.45 angstrom, but farther than
/// 0.4 (the rule of Open Babel, O'Boyle et al., J. Cheminf. 3 (2011) 33), in the nearest image of a periodic cell.
/// Atoms without an element have no bonds. Time and memory grow with the number of atoms.
std::vector<Imported::Bond> find_bonds_by_distance(const Imported& data);

}  // namespace tanor::scene
