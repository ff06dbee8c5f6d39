#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include <tanor/error.hpp>
#include <tanor/time_function.hpp>

#include "scene/atom_styles.hpp"
#include "scene/periodic_cell.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {

/// The lines of a LAMMPS data file, and the ways in which all its sections are read: comments, checked numbers, types
/// that may have labels.
class LammpsLines {
 public:
  LammpsLines(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

 protected:
  using Words = std::vector<std::string_view>;

  static constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int64_t any = std::numeric_limits<std::int64_t>::max();

  /// Returns the current line without its comment.
  std::string_view content() const { return lines_.content(); }
  std::string_view comment() const {
    const std::size_t hash = lines_.line().find('#');
    return hash == std::string_view::npos ? "" : trim(lines_.line().substr(hash + 1));
  }
  static bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

  std::int64_t integer(std::string_view word, std::string_view what, std::int64_t least, std::int64_t largest) const {
    const auto number = parse_integer(word);
    if (!number || *number < least || *number > largest)
      lines_.fail(word, fmt::format("{} from {} to {}", what, least, largest));
    return *number;
  }
  double number(std::string_view word) const { return lines_.read_number(word); }
  /// Reads a number from 1 on or a label of "Atom", "Bond", … types.
  std::int64_t type(std::string_view word, std::string_view kind, std::string_view what, std::int64_t largest) const {
    const auto label = find_label(word, kind);
    return label ? *label : integer(word, what, 1, largest);
  }
  std::optional<std::int64_t> find_label(std::string_view word, std::string_view kind) const {
    const auto labels = labels_.find(kind);
    if (labels == labels_.end()) return {};
    const auto found = labels->second.find(word);
    return found == labels->second.end() ? std::nullopt : std::optional(found->second);
  }
  Vector3 vector(const Words& words, std::size_t first) const {
    return {number(words[first]), number(words[first + 1]), number(words[first + 2])};
  }
  void check_columns(const Words& words, std::initializer_list<std::size_t> wanted, std::string_view what) const {
    if (std::find(wanted.begin(), wanted.end(), words.size()) == wanted.end())
      lines_.complain(fmt::format("found {} columns, wanted {}", words.size(), what));
  }

  [[noreturn]] void complain(const std::string& what, std::size_t line = 0) const {
    const std::string place = line > 0 ? fmt::format("{}, line {}", name_, line) : name_;
    throw InputError("", place + ": " + what);
  }

  std::string name_;
  LineReader lines_;
  /// Types by their labels, of "Atom", "Bond", …
  std::map<std::string, std::map<std::string, std::int64_t, std::less<>>, std::less<>> labels_;
};

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
