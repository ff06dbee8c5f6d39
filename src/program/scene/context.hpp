#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "scene/cursor.hpp"
#include "scene/number_table.hpp"
#include "scene/periodic_cell.hpp"

namespace tanor::scene {

/// Reads values whose meaning depends on the scene: on the folder of its files, the constants of its formulas, and the
/// number of its points. The readers throw InputError like those of Cursor.
struct Context {
  std::filesystem::path directory;            ///< folder of the scene file
  std::vector<std::filesystem::path>* files;  ///< the list of all files that were read
  Constants parameters;
  std::size_t num_points = 0;
  double t_start = 0.0, t_end = 0.0;          ///< s; a table must reach from 0, or an earlier start, to the end
  std::optional<Cell> cell{};                 ///< cell of the file that the points come from
  std::span<const Constraint> constraints{};  ///< constraints that were read before
  std::size_t* num_named = nullptr;           ///< points that short words have named so far

  Index point(const Cursor& cursor) const;
  /// Throws length_error if the points that words such as "all" have named so far, with these, exceed the memory of
  /// this machine. A small file may ask for any number of them.
  void take_room(std::size_t num_points) const;

  /// Reads [0, 4, 7], "all" or {"first", "count", "stride"}.
  std::vector<Index> points(const Cursor& cursor) const;
  /// Reads [[0, 1], [1, 2]], [[0, 1, 2]], …
  template <std::size_t N>
  std::vector<std::array<Index, N>> tuples(const Cursor& cursor) const;

  /// Returns the path of a file to be read, given relative to the scene file.
  std::filesystem::path file(const Cursor& cursor) const { return files->emplace_back(directory / cursor.string()); }
  NumberTable number_table(const Cursor& file_name) const;

  /// Reads a number, {"formula": "0.1*sin(omega*t)"} or {"table": "drive.csv"}.
  ScalarFunction scalar_function(const Cursor& cursor) const;
  /// Reads three numbers, {"formula": [three strings]} or {"table": "drive.csv"}.
  VectorFunction vector_function(const Cursor& cursor) const;
  /// Reads "initial", one scalar function, or a list of them, one for each member of a group.
  Parameter parameter(const Cursor& cursor, std::size_t num_members, Parameter otherwise = {}) const;
  /// Reads the same without functions of time.
  Parameter constant_parameter(const Cursor& cursor, std::size_t num_members) const;
  /// Reads a number for all members, or a list of one for each.
  std::vector<double> numbers(const Cursor& cursor, std::size_t num_members) const;
  std::vector<Vector3> vectors(const Cursor& cursor) const;
};

}  // namespace tanor::scene
