#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scene/periodic_cell.hpp"

namespace tanor::scene {

/// The columns of a section Atoms of LAMMPS. Three image flags may follow them.
struct AtomColumns {
  std::string style;               ///< "full", "hybrid bond ellipsoid"
  std::vector<std::string> names;  ///< "id", "molecule", "type", "q", "x", "y", "z"
  bool is_open = false;            ///< more columns follow, and the style does not tell how many

  /// Returns the position of a named column, 0, 1, …, or their number if there is none.
  std::size_t find(std::string_view name) const;
  bool has(std::string_view name) const { return find(name) < names.size(); }
};

/// Returns the columns of a style, as different versions of LAMMPS order them; nothing if there is no such style.
/// Behind its name may stand what the command atom_style takes: the sub-styles of `hybrid`, the number of species of
/// `tdpd`.
std::vector<AtomColumns> find_atom_styles(std::string_view name);
/// Returns the columns of the styles that are told by their columns, those first that are most in use.
std::vector<AtomColumns> all_atom_styles();
/// Returns the names of all styles.
std::vector<std::string> names_of_atom_styles();

/// A survey of the lines of a section Atoms: what they have in common, column by column.
class AtomSurvey {
 public:
  /// `is_type` tells whether a word is an atom type of the file.
  explicit AtomSurvey(std::function<bool(std::string_view)> is_type) : is_type_(std::move(is_type)) {}
  void add(const std::vector<std::string_view>& words);

  std::size_t num_columns() const { return columns_.size(); }
  /// Returns true if all lines can have these columns, with image flags behind them or without.
  bool fits(const AtomColumns& columns) const;
  bool has_images(const AtomColumns& columns) const { return columns_.size() == columns.names.size() + 3; }
  /// Returns the least and the largest image flag.
  std::array<double, 2> image_range() const;
  /// Returns true if a line has other image flags than 0.
  bool has_shift() const { return image_range() != std::array{0.0, 0.0}; }
  /// Returns true if x, y and z lie in the box, or less than an edge beside it. An edge from 0 to 0 is open.
  bool is_inside(std::size_t x, const Vector3& low, const Vector3& high) const;
  /// Returns how many of x, y and z have fractions somewhere.
  std::size_t num_fractional(std::size_t x) const;
  /// Returns true if atoms of one type have dipoles of one length, where these columns are those of style dipole.
  bool has_equal_dipoles() const { return has_equal_dipoles_; }
  double most(std::size_t column) const { return columns_[column].most; }

 private:
  struct Column {
    bool is_number = true, is_whole = true, is_type = true;
    double least = HUGE_VAL, most = -HUGE_VAL;
  };

  void add_moment(const std::vector<std::string_view>& words);

  std::function<bool(std::string_view)> is_type_;
  std::vector<Column> columns_;
  bool is_even_ = true;                                        ///< all lines have as many columns
  std::map<std::string, double, std::less<>> dipole_of_type_;  ///< squared length
  bool has_equal_dipoles_ = true;
  bool has_directions_ = true, has_spins_ = false;  ///< as style spin has them: of all atoms, of one at least
};

/// Facts that a file tells about its atoms elsewhere.
struct AtomFacts {
  bool has_masses = false;  ///< by type
  std::int64_t num_types = 0;
  Vector3 low{}, high{};            ///< ends of the box
  bool bonds_share_second = false;  ///< there are bonds, each between atoms with the same word in the second column
  /// Tells whether no two atoms stand at one place, if x is this column.
  std::function<bool(std::size_t)> has_distinct_places{};
};

/// Returns those of `candidates` which all lines fit. If they differ in what they make of the lines, the likely ones
/// are returned: atoms lie in the box and at places of their own, their coordinates have fractions and are written
/// alike, dipoles of one type have one length, and what bonded atoms share is their molecule.
std::vector<AtomColumns> choose_columns(std::vector<AtomColumns> candidates, const AtomSurvey& survey,
                                        const AtomFacts& facts);

/// Returns true if two choices give the atoms the same masses and places.
bool are_equivalent(const AtomColumns& a, const AtomColumns& b, const AtomSurvey& survey, const AtomFacts& facts);

}  // namespace tanor::scene
