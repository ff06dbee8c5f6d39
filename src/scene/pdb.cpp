#include "scene/pdb.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/document.hpp"
#include "scene/edges.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

/// Reads one file; the driver is `read`. The columns are those of format version 3.3.
class PdbReader {
 public:
  PdbReader(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

  Imported read() {
    data_.angstrom = 1.0;
    bool is_first_model = true;
    while (lines_.next()) {
      const std::string_view record = columns(lines_.line(), 1, 6);
      if (record == "ENDMDL") is_first_model = false;
      if (is_first_model && (record == "ATOM" || record == "HETATM")) read_atom();
      if (record == "CONECT") read_bonds();
      if (record == "CRYST1") read_cell();
    }
    data_.bonds = edges_.take();
    return std::move(data_);
  }

 private:
  static constexpr std::int32_t left_out = -1;  ///< an alternative position of an atom

  double number(std::size_t first, std::size_t last) const {
    const std::string_view word = columns(lines_.line(), first, last);
    const auto number = parse_number(word);
    if (!number) lines_.fail(word, fmt::format("a finite number in columns {} to {}", first, last));
    return *number;
  }

  void read_atom() {
    const std::string_view line = lines_.line(), serial = columns(line, 7, 11);
    if (is_second_place()) {
      points_.emplace(serial, left_out);
      return;
    }
    if (data_.positions.size() == std::numeric_limits<std::int32_t>::max())
      lines_.complain("found more atoms than can be numbered");
    // Some programs have no numbers above 99999, and atoms then share numbers. Only CONECT refers to these.
    const auto point = static_cast<std::int32_t>(data_.positions.size());
    const bool is_new = points_.emplace(serial, point).second;
    if (!is_new) ambiguous_.emplace(serial);
    data_.positions.push_back({number(31, 38), number(39, 46), number(47, 54)});
    data_.elements.push_back(find_atom_element());
    if (!data_.elements.back() && data_.without_element.empty())
      data_.without_element = fmt::format("{}, line {}: atom {}", name_, lines_.number(), quote(columns(line, 13, 16)));
  }

  /// Returns true if the atom, identified by chain, residue and name, was met before, and this position is an
  /// alternative (column 17).
  bool is_second_place() {
    const std::string_view line = lines_.line();
    if (columns(line, 17, 17).empty()) return false;
    std::string atom(line.substr(12, 15));
    atom[4] = ' ';
    return !places_.insert(atom).second;
  }

  const Element* find_atom_element() const {
    const std::string_view line = lines_.line();
    if (const Element* element = find_element(columns(line, 77, 78))) return element;
    const std::string_view atom = columns(line, 13, 16), symbol = columns(line, 13, 14);
    // A symbol ends in column 14, and only the four-character names of hydrogen begin earlier.
    const bool starts_early = atom.size() == 4 && atom[0] == 'H';
    if (symbol.size() == 2 && !starts_early)
      if (const Element* element = find_element(symbol)) return element;
    if (symbol.size() == 1 && columns(line, 13, 13).empty())
      if (const Element* element = find_element(symbol)) return element;
    return guess_element(atom, columns(line, 18, 20));
  }

  void read_bonds() {
    const std::int32_t from = find_point(7, 11);
    for (std::size_t first = 12; first <= 27; first += 5) {
      if (columns(lines_.line(), first, first + 4).empty()) continue;
      const std::int32_t to = find_point(first, first + 4);
      if (from == to && from != left_out) lines_.complain("found an atom bonded to itself");
      if (from != left_out && to != left_out) edges_.add(from, to);  // a double bond is listed twice
    }
  }

  std::int32_t find_point(std::size_t first, std::size_t last) const {
    const std::string_view serial = columns(lines_.line(), first, last);
    if (ambiguous_.contains(std::string(serial)))
      lines_.fail(serial, "the number of one atom, which several atoms have");
    const auto found = points_.find(std::string(serial));
    if (found == points_.end()) lines_.fail(serial, "the number of an atom above");
    return found->second;
  }

  /// Reads the cell; CRYST1 1 1 1 means that there is no crystal.
  void read_cell() {
    const double a = number(7, 15), b = number(16, 24), c = number(25, 33);
    if (a == 1.0 && b == 1.0 && c == 1.0) return;
    if (!(a >= 0.0 && b >= 0.0 && c >= 0.0)) lines_.complain("found an edge of the cell below 0");
    const auto cosine = [&](double degrees) {
      return degrees == 90.0 ? 0.0 : std::cos(degrees * (std::numbers::pi / 180.0));
    };
    const double alpha = cosine(number(34, 40)), beta = cosine(number(41, 47)), gamma = cosine(number(48, 54));
    // The edge a is along x, and b in the x-y plane.
    const double sine = std::sqrt(1.0 - gamma * gamma), yz = (alpha - beta * gamma) / sine;
    const double height = 1.0 - beta * beta - yz * yz;
    if (!(sine > 0.0) || !(height > 0.0)) lines_.complain("found angles between which no cell has room");
    data_.cell = {.xx = a, .yy = b * sine, .zz = c * std::sqrt(height), .xy = b * gamma, .xz = c * beta, .yz = c * yz};
  }

  const std::string name_;
  LineReader lines_;
  std::unordered_map<std::string, std::int32_t> points_;  ///< by an atom's number as written in the file
  std::unordered_set<std::string> places_, ambiguous_;
  Edges edges_;
  Imported data_;
};

}  // namespace

Imported read_pdb(const std::string& name, std::string_view text) {
  return PdbReader(name, text).read();
}

}  // namespace tanor::scene
