#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/document.hpp"
#include "scene/imported.hpp"
#include "scene/name_list.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

/// Reads one file; the driver is `read`. The columns are those of format version 3.3.
class PdbReader {
 public:
  PdbReader(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

  Imported read() {
    data_.angstrom = 1.0;
    while (lines_.next()) read_record(columns(lines_.line(), 1, 6));
    data_.bonds = edges_.take();
    name_unread();
    return std::move(data_);
  }

 private:
  static constexpr std::int32_t left_out = -1;  ///< an alternative position of an atom

  /// Frames end with ENDMDL, with the next MODEL, or with END, behind which a file of its own may follow: bonds are
  /// those of all models of the first file, whose atoms have the same numbers.
  void read_record(std::string_view record) {
    if (record == "END" || record == "ENDMDL" || record == "MODEL") {
      if (!data_.positions.empty()) is_between_frames_ = true;
      if (record == "END") has_end_ = !data_.positions.empty();
    } else if (is_atom(record)) {
      if (is_between_frames_) ++num_more_frames_;
      is_between_frames_ = false;
      if (num_more_frames_ == 0) read_atom();
      is_in_next_file_ = has_end_;
    } else if (record == "CONECT") {
      if (!is_in_next_file_) read_bonds();
    } else if (record == "CRYST1") {
      if (!is_between_frames_ && num_more_frames_ == 0) read_cell();
    } else if (!record.empty() && record != "TER" && record != "REMARK") {
      unread_.add(record);
    }
  }

  /// Returns true for ATOM and HETATM. A number of six digits and more may begin in column 6 or 5 of ATOM.
  static bool is_atom(std::string_view record) {
    return record == "HETATM" ||
           (record.starts_with("ATOM") && record.find_first_not_of(" 0123456789", 4) == std::string_view::npos);
  }

  void name_unread() {
    if (!unread_.empty()) data_.unread.push_back("what stands in records " + unread_.quote_all());
    if (num_more_frames_ > 0)
      data_.unread.push_back(fmt::format("what stands behind the first frame ({} more)", num_more_frames_));
    if (num_second_places_ > 0)
      data_.unread.push_back(fmt::format("what stands in second places of atoms ({})", num_second_places_));
  }

  /// Returns columns of an atom's line, counted as if its number had no more digits than have room.
  std::string_view atom_columns(std::size_t first, std::size_t last) const {
    return columns(lines_.line(), first + shift_, last + shift_);
  }
  /// Reads an atom's number, which ends in column 11. One of more than five digits begins earlier, or takes the blank
  /// column 12, or pushes the rest of the line to the right. The decimal points of x, y and z tell how far.
  std::string_view read_serial() {
    const std::string_view line = lines_.line();
    const std::size_t first = line.starts_with("ATOM") ? 5 : 7;
    const auto is_digit = [&](std::size_t column) {
      return column <= line.size() && line[column - 1] >= '0' && line[column - 1] <= '9';
    };
    bool is_full = true;
    for (std::size_t column = 7; column <= 11; ++column) is_full = is_full && is_digit(column);
    std::size_t num_more = 0;
    while (is_full && is_digit(12 + num_more)) ++num_more;
    const auto is_point = [&](std::size_t column) { return column <= line.size() && line[column - 1] == '.'; };
    shift_ = 0;
    while (num_more > 0 && !(is_point(35 + shift_) && is_point(43 + shift_) && is_point(51 + shift_)))
      if (++shift_ > num_more)
        lines_.complain(
            fmt::format("found no three decimal points in columns 35, 43 and 51, nor up to {} columns "
                        "behind these, where the number of the atom is long",
                        num_more));
    const std::string_view serial = columns(line, first, 11 + std::min(num_more, shift_ + 1));
    longest_serial_ = std::max(longest_serial_, serial.size());
    return serial;
  }

  double number(std::size_t first, std::size_t last) const {
    const std::string_view word = columns(lines_.line(), first, last);
    const auto number = parse_number(word);
    if (!number) lines_.fail(word, fmt::format("a finite number in columns {} to {}", first, last));
    return *number;
  }

  void read_atom() {
    const std::string_view serial = read_serial();
    if (is_second_place()) {
      ++num_second_places_;
      points_.emplace(serial, left_out);
      return;
    }
    if (data_.positions.size() == std::numeric_limits<std::int32_t>::max())
      lines_.complain("found more atoms than can be numbered");
    // Some programs have no numbers above 99999, and atoms then share numbers. Only CONECT refers to these.
    const auto point = static_cast<std::int32_t>(data_.positions.size());
    const bool is_new = points_.emplace(serial, point).second;
    if (!is_new) ambiguous_.emplace(serial);
    const auto coordinate = [&](std::size_t first) { return number(first + shift_, first + 7 + shift_); };
    data_.positions.push_back({coordinate(31), coordinate(39), coordinate(47)});
    data_.elements.push_back(find_atom_element());
    if (!data_.elements.back() && data_.without_element.empty())
      data_.without_element = fmt::format("{}, line {}: atom {}", name_, lines_.number(), quote(atom_columns(13, 16)));
  }

  /// Returns true if the atom, identified by chain, residue and name, was met before, and this position is an
  /// alternative (column 17).
  bool is_second_place() {
    if (atom_columns(17, 17).empty()) return false;
    std::string atom(lines_.line().substr(12 + shift_, 15));
    atom[4] = ' ';
    return !places_.insert(atom).second;
  }

  const Element* find_atom_element() const {
    if (const Element* element = find_element(atom_columns(77, 78))) return element;
    const std::string_view atom = atom_columns(13, 16), symbol = atom_columns(13, 14);
    // A symbol ends in column 14, and only the four-character names of hydrogen begin earlier.
    const bool starts_early = atom.size() == 4 && atom[0] == 'H';
    if (symbol.size() == 2 && !starts_early)
      if (const Element* element = find_element(symbol)) return element;
    if (symbol.size() == 1 && atom_columns(13, 13).empty())
      if (const Element* element = find_element(symbol)) return element;
    return guess_element(atom, atom_columns(18, 20));
  }

  void read_bonds() {
    const Serials serials = find_serials();
    if (serials.empty()) lines_.complain("found no numbers of atoms");
    const std::int32_t from = find_point(serials[0]);
    for (const std::string_view serial : std::span(serials).subspan(1)) {
      const std::int32_t to = find_point(serial);
      if (from == to && from != left_out) lines_.complain("found an atom bonded to itself");
      if (from != left_out && to != left_out) edges_.add(from, to);  // a double bond is listed twice
    }
  }

  using Serials = std::vector<std::string_view>;

  /// Adds all ways to part the rest of a line into numbers that end at the right of five columns, or have more digits.
  void part_serials(std::string_view rest, const Serials& parted, std::vector<Serials>* readings) const {
    if (rest.empty()) readings->push_back(parted);
    if (parted.size() == 5) return;
    for (std::size_t width = 5; width <= std::min(rest.size(), longest_serial_); ++width) {
      const std::string_view serial = trim(rest.substr(0, width));
      const bool is_false = width > 5 && (serial.size() < width || serial[0] == '0');
      if (is_false || serial.empty() || rest[width - 1] == ' ' || !points_.contains(std::string(serial))) continue;
      Serials longer = parted;
      longer.push_back(serial);
      part_serials(rest.substr(width), longer, readings);
    }
  }

  /// Returns the numbers of an atom and of up to four that are bonded to it, five columns each. In a file with longer
  /// numbers they may have more columns, or blanks between them; then all of them must be known.
  Serials find_serials() const {
    const std::string_view line = lines_.line();
    const auto cut = [&](std::size_t width) {
      Serials serials;
      for (std::size_t k = 0; k < 5; ++k)
        if (const auto serial = columns(line, 7 + k * width, 6 + (k + 1) * width); k == 0 || !serial.empty())
          serials.push_back(serial);
      return serials;
    };
    const Serials plain = cut(5);
    if (longest_serial_ <= 5) return plain;
    std::vector<Serials> readings{cut(longest_serial_), split_words(line.substr(6))};
    const std::size_t end = line.find_last_not_of(" \t");
    part_serials(line.substr(0, end + 1).substr(6), {}, &readings);
    std::erase_if(readings, [&](const auto& serials) {
      return std::ranges::any_of(serials, [&](auto serial) { return !points_.contains(std::string(serial)); });
    });
    for (const auto& each : readings)
      if (each != readings[0]) lines_.complain("found numbers of atoms that may be parted in several ways");
    return readings.empty() ? plain : readings[0];
  }

  std::int32_t find_point(std::string_view serial) const {
    if (ambiguous_.contains(std::string(serial)))
      lines_.fail(serial, "the number of one atom, which several atoms have");
    const auto found = points_.find(std::string(serial));
    if (found == points_.end()) lines_.fail(serial, "the number of an atom above");
    return found->second;
  }

  /// Reads the cell; edges that are all 1, or all 0 or blank, mean that there is no crystal.
  void read_cell() {
    const auto edge = [&](std::size_t first, std::size_t last) {
      return columns(lines_.line(), first, last).empty() ? 0.0 : number(first, last);
    };
    const auto is_nan = [&](std::size_t first) {
      const std::string_view word = columns(lines_.line(), first, first + 8);
      return spells_number(word) && !parse_number(word);
    };
    if (is_nan(7) && is_nan(16) && is_nan(25)) {
      data_.unread.emplace_back("the cell, which is not finite,");
      return;
    }
    const double a = edge(7, 15), b = edge(16, 24), c = edge(25, 33);
    if (a == b && b == c && (a == 1.0 || a == 0.0)) return;
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
  std::size_t shift_ = 0;           ///< of the columns behind the number of the present atom
  std::size_t longest_serial_ = 0;  ///< of all numbers, in digits
  bool is_between_frames_ = false;  ///< a frame with atoms has ended, and no other has begun
  bool has_end_ = false;            ///< END behind atoms
  bool is_in_next_file_ = false;    ///< atoms behind END
  std::size_t num_more_frames_ = 0, num_second_places_ = 0;
  NameList unread_;  ///< records
  Imported data_;
};

}  // namespace

Imported read_pdb(const std::string& name, std::string_view text) {
  return PdbReader(name, text).read();
}

}  // namespace tanor::scene
