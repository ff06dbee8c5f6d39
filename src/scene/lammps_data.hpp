#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <tanor/time_function.hpp>

#include "scene/periodic_cell.hpp"

namespace tanor::scene {

/// Atoms, bonds, angles and dihedrals of a LAMMPS data file. The atoms stand in the order of their ids, so that ids
/// 1 … n become points 0 … n - 1.
struct LammpsData {
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
  std::int64_t num_bond_types = 0, num_angle_types = 0, num_dihedral_types = 0;
  std::vector<Vector3> positions;   ///< m, with the file's image flags unwrapped
  std::vector<Vector3> velocities;  ///< m/s; empty where the file has none
  std::vector<double> masses;       ///< kg; 1 where the file has no masses
  std::vector<Bond> bonds;
  std::vector<Angle> angles;
  std::vector<Dihedral> dihedrals;
  Coefficients bond_coefficients, angle_coefficients, dihedral_coefficients;
};

/// Reads atom styles atomic, bond, angle, molecular, charge and full; the style is the comment behind `Atoms`, or else
/// guessed from the number of columns (atomic 5 or 8, molecular 6 or 9, full 7 or 10). Other sections are skipped.
/// Throws InputError (without a place) naming file and line.
LammpsData read_lammps_data(const std::filesystem::path& file);

}  // namespace tanor::scene
