#include "scene/lammps_atoms.hpp"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "scene/name_list.hpp"

namespace tanor::scene {
namespace {

/// Reads the lines of a section Atoms; the driver is `read`.
class AtomsReader : LammpsLines {
 public:
  AtomsReader(const LammpsLines& file, const AtomsSection& section) : LammpsLines(file), section_(section) {}

  std::vector<LammpsAtom> read(std::vector<std::string>* unread) {
    use_columns(find_columns());
    for_each_line([&](const Words& words) { read_atom(words); });
    NameList names;
    for (std::size_t k = 0; k < has_content_.size(); ++k)
      if (has_content_[k] && !is_place(columns_->names[k])) names.add(columns_->names[k]);
    if (!names.empty()) unread->push_back(fmt::format("what stands in columns {} of Atoms", names.quote_all()));
    return std::move(atoms_);
  }

 private:
  /// Prepares the words for errors once, not in each of a million lines.
  void use_columns(const AtomColumns& columns) {
    columns_ = columns;
    const std::size_t size = columns.names.size();
    const std::string remark = fmt::format("(style {}{})", columns.style, section_.style.empty() ? ", guessed" : "");
    atom_columns_ = fmt::format("{} or {} {}", size, size + 3, remark);
    atom_type_ = "an atom type " + remark;
    image_flag_ = "an image flag " + remark;
    type_column_ = columns.find("type");
    x_column_ = columns.find("x");
    has_content_.assign(size, false);
  }

  template <class Use>
  void for_each_line(const Use& use) {
    lines_ = section_.title;
    for (std::size_t k = 0; k < section_.num_lines;) {
      lines_.next();
      if (content().empty() || is_letter(content()[0])) continue;  // a line may name the columns
      use(split_words(content()));
      ++k;
    }
  }

  AtomSurvey survey_atoms() {
    AtomSurvey survey([&](std::string_view word) {
      const auto number = parse_integer(word);
      return find_label(word, "Atom") || (number && *number >= 1 && *number <= section_.facts.num_types);
    });
    for_each_line([&](const Words& words) { survey.add(words); });
    return survey;
  }

  bool do_bonds_share_second() {
    std::unordered_map<std::int64_t, std::string_view> second;
    for_each_line([&](const Words& words) {
      if (words.size() > 1) second.emplace(parse_integer(words[0]).value_or(0), words[1]);
    });
    return std::ranges::all_of(section_.bonds, [&](const auto& bond) { return second[bond[0]] == second[bond[1]]; });
  }

  bool has_distinct_places(std::size_t x) {
    std::vector<std::array<std::string_view, 3>> places;
    for_each_line([&](const Words& words) { places.push_back({words[x], words[x + 1], words[x + 2]}); });
    std::ranges::sort(places);
    return std::ranges::adjacent_find(places) == places.end();
  }

  /// Finds the columns by the style's name, or else by what all lines allow.
  AtomColumns find_columns() {
    std::vector<AtomColumns> styles = find_atom_styles(section_.style);
    if (styles.size() == 1 && !styles[0].is_open) return styles[0];
    if (styles.empty()) {
      styles = all_atom_styles();
      // The density of a particle gives it a mass of its own, and LAMMPS then reads no masses of types.
      if (section_.facts.has_masses)
        std::erase_if(styles, [](const AtomColumns& each) { return each.has("density") || each.has("mass"); });
      if (!section_.bonds.empty()) {
        std::erase_if(styles, [](const AtomColumns& each) { return each.style == "dipole" || each.style == "spin"; });
        styles.push_back(find_atom_styles("hybrid molecular")[0]);
      }
    }
    AtomFacts facts = section_.facts;
    facts.bonds_share_second = !section_.bonds.empty() && do_bonds_share_second();
    facts.has_distinct_places = [&](std::size_t x) { return has_distinct_places(x); };
    const AtomSurvey survey = survey_atoms();
    const std::vector<AtomColumns> found = choose_columns(styles, survey, facts);
    if (found.empty()) blame_columns(styles);
    if (!section_.style.empty() && !found[0].is_open) return found[0];  // as LAMMPS itself orders the columns
    NameList names;
    for (const AtomColumns& each : found) names.add(each.style);
    for (const AtomColumns& each : found)
      if (!are_equivalent(each, found[0], survey, facts))
        complain(fmt::format("the columns of Atoms are those of several styles ({}), wanted a comment behind Atoms or "
                             "/import/atom_style, which names the style",
                             names.quote_all()),
                 section_.title.number());
    return unite_names(found);
  }

  /// Complains about the first line that does not have the columns of the first style that has as many.
  [[noreturn]] void blame_columns(const std::vector<AtomColumns>& styles) {
    for_each_line([&](const Words& words) {
      const auto has_as_many = [&](const AtomColumns& each) {
        return words.size() == each.names.size() || words.size() == each.names.size() + 3;
      };
      if (!columns_) {
        const auto style = std::ranges::find_if(styles, has_as_many);
        if (style == styles.end())
          lines_.complain(fmt::format("found {} columns, wanted {}", words.size(), list_widths(styles)));
        use_columns(*style);
      }
      read_atom(words);
    });
    complain("the columns of Atoms are those of no style that is known, wanted /import/atom_style",
             section_.title.number());
  }

  /// Returns how many columns lines of the named style may have, or those of the styles that are met most.
  std::string list_widths(const std::vector<AtomColumns>& styles) const {
    if (section_.style.empty()) return "5 or 8 (style atomic), 6 or 9 (molecular), 7 or 10 (full)";
    NameList widths;
    for (const AtomColumns& each : styles)
      widths.add(each.is_open ? fmt::format("{} or more", each.names.size())
                              : fmt::format("{} or {}", each.names.size(), each.names.size() + 3));
    return fmt::format("{} (style {})", widths.join(" or "), styles[0].style);
  }

  /// Returns columns that several styles share, with all names of each: "q/theta".
  static AtomColumns unite_names(const std::vector<AtomColumns>& styles) {
    AtomColumns united = styles[0];
    for (std::size_t k = 0; k < united.names.size(); ++k) {
      NameList names;
      for (const AtomColumns& each : styles)
        if (k < each.names.size()) names.add(each.names[k]);
      if (!is_place(united.names[k])) united.names[k] = names.join("/");
    }
    return united;
  }
  /// Returns true for columns that are read, and for the number of a molecule, which says nothing about its motion.
  static bool is_place(std::string_view column) {
    constexpr std::string_view names[] = {"id", "molecule", "type", "x", "y", "z"};
    return std::ranges::find(names, column) != std::end(names);
  }

  void read_atom(const Words& words) {
    const std::size_t size = has_content_.size();
    check_columns(words, {size, size + 3}, atom_columns_);
    LammpsAtom atom{.id = integer(words[0], "an atom id", 1, any),
                    .type = type(words[type_column_], "Atom", atom_type_, section_.facts.num_types),
                    .position = vector(words, x_column_)};
    if (words.size() == size + 3) {
      std::array<std::int64_t, 3> images;
      for (std::size_t k = 0; k < 3; ++k) images[k] = integer(words[size + k], image_flag_, -most, most);
      const Vector3 shift = shift_of(section_.cell, images);
      for (std::size_t k = 0; k < 3; ++k) atom.position[k] += shift[k];
    }
    for (std::size_t k = 0; k < size; ++k) has_content_[k] = has_content_[k] || parse_number(words[k]) != 0.0;
    atoms_.push_back(atom);
  }

  const AtomsSection& section_;
  std::optional<AtomColumns> columns_;
  std::size_t type_column_ = 0, x_column_ = 0;
  std::vector<bool> has_content_;  ///< of each column: it is not 0 everywhere
  std::string atom_columns_, atom_type_, image_flag_;
  std::vector<LammpsAtom> atoms_;
};

}  // namespace

std::vector<LammpsAtom> read_lammps_atoms(const LammpsLines& file, const AtomsSection& section,
                                          std::vector<std::string>* unread) {
  return AtomsReader(file, section).read(unread);
}

}  // namespace tanor::scene
