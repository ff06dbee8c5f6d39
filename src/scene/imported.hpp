#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <tanor/time_function.hpp>

#include "scene/elements.hpp"
#include "scene/periodic_cell.hpp"

namespace tanor::scene {

/// What a file of another program holds, in the order of its points and in its own units. A file without a cell, bonds
/// or angles leaves them empty.
struct Imported {
  struct Bond {
    std::int64_t type;
    std::array<std::int32_t, 2> atoms;
  };
  struct Angle {
    std::int64_t id, type;
    std::array<std::int32_t, 3> atoms;  ///< the corner in the middle
  };
  struct Dihedral {
    std::int64_t id, type;
    std::array<std::int32_t, 4> atoms;
  };
  /// A section of coefficients: the style that the comment behind its title names, or empty; the numbers of each type.
  struct Coefficients {
    std::string style{};
    std::map<std::int64_t, std::vector<double>> of_type{};
  };

  Cell cell;
  std::int64_t num_bond_types = 1, num_angle_types = 0, num_dihedral_types = 0;
  std::vector<Vector3> positions;        ///< with image flags unwrapped
  std::vector<Vector3> velocities;       ///< empty: the file has none
  std::vector<double> masses;            ///< empty: the file has none
  std::vector<const Element*> elements;  ///< of each atom, null where nothing tells; empty: the file knows no elements
  std::string without_element;           ///< the first atom of those: "a.gro, line 6: atom MW"
  double angstrom = 0.0;                 ///< in the file's unit, where elements are known
  std::vector<Bond> bonds;
  std::vector<Angle> angles;
  std::vector<Dihedral> dihedrals;
  Coefficients bond_coefficients, angle_coefficients, dihedral_coefficients;
  std::string units;                ///< of a LAMMPS file, as its first line says: "real"; empty: it says none
  std::vector<std::string> unread;  ///< titles of sections that are not read
};

}  // namespace tanor::scene
