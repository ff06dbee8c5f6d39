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

/// The content of another program's file, in the order of its points and in its own units. If the file has no cell,
/// bonds or angles, these are empty.
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
  /// A section of coefficients: the style named by the comment after its title, or an empty one, and the numbers of
  /// each type. What else stands there is an error only where energies are asked for.
  struct Coefficients {
    std::string style{};
    std::map<std::int64_t, std::vector<double>> of_type{};
    std::string error{};  ///< about the first line that cannot be used: "a.data, line 9: found …"
  };

  Cell cell;
  std::int64_t num_bond_types = 1, num_angle_types = 0, num_dihedral_types = 0;
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

}  // namespace tanor::scene
