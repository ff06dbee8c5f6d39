#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <tanor/error.hpp>

#include "scene/imported.hpp"
#include "scene/lammps_atoms.hpp"
#include "scene/name_list.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {

namespace {

using Words = std::vector<std::string_view>;

/// Reads one file; the driver is `read`.
class LammpsReader : LammpsLines {
 public:
  LammpsReader(const std::string& name, std::string_view text, const std::string& atom_style)
      : LammpsLines(name, text), atoms_section_{.title = lines_, .style = atom_style} {}

  Imported read() {
    lines_.next();  // the first line is a comment
    find_units(split_words(lines_.line()));
    read_labels();
    std::string section;
    bool is_behind_title = false;
    while (lines_.next()) {
      const std::string_view content = this->content();
      const bool may_name_columns = std::exchange(is_behind_title, false);
      if (content.empty()) continue;
      if (section == "Atoms" && !is_letter(content[0])) {
        ++atoms_section_.num_lines;  // they are read at the end, when all bonds and masses are known
        continue;
      }
      const Words words = split_words(content);
      // LAMMPS skips the line behind a title. Some files name the columns there.
      if (may_name_columns && is_letter(content[0]) && !parse_number(words.back())) continue;
      if (is_title(section, words)) {
        section = content;
        is_behind_title = true;
        start(section);
      } else if (section.empty()) {
        read_header(words);
      } else if (read_line_) {
        read_line_(words);
      }
    }
    read_atoms();
    return finish();
  }

 private:
  struct Velocity {
    std::int64_t id;
    Vector3 velocity;
  };
  template <std::size_t size>
  struct NamedMember {
    std::int64_t id, type;
    std::array<std::int64_t, size> atoms;  ///< ids
    std::size_t line;
  };
  /// The bonds, angles or dihedrals of a file, and what its header tells about them.
  template <std::size_t size>
  struct Section {
    std::string what, kind;  ///< "bond", "Bond"
    std::vector<Imported::Member<size>>& members;
    Imported::Coefficients& coefficients;
    std::int64_t num_types = 0;  ///< 0 if the header does not tell
    std::int64_t count = 0;
    std::vector<NamedMember<size>> named{};
    // Words for errors, made once.
    std::string one = (what[0] == 'a' ? "an " : "a ") + what, id = one + " id", type = one + " type";
    std::string columns =
        fmt::format("{}: id type{}", size + 2, std::string_view(" atom atom atom atom").substr(0, 5 * size));
  };
  template <class Use>
  void for_each_section(const Use& use) {
    use(bonds_);
    use(angles_);
    use(dihedrals_);
  }

  /// Finds "units = real" or "units real" anywhere in the first line, which else is prose.
  void find_units(const Words& words) {
    for (std::size_t k = 0; k + 1 < words.size(); ++k) {
      if (words[k] != "units") continue;
      const std::size_t next = words[k + 1] == "=" && k + 2 < words.size() ? k + 2 : k + 1;
      const std::string_view said = words[next].substr(0, words[next].find_first_of(",.;)"));
      constexpr std::string_view known[] = {"lj", "real", "metal", "si", "cgs", "electron", "micro", "nano"};
      if (words[k + 1] == "=" || std::ranges::count(known, said) > 0) data_.units = said;
    }
  }

  /// Reads the labels of all types, which may stand behind the lines that use them.
  void read_labels() {
    if (lines_.rest().find(type_labels) == std::string_view::npos) return;
    const LineReader first = lines_;
    std::string kind;
    while (lines_.next()) {
      const Words words = split_words(content());
      if (words.empty()) continue;
      if (is_letter(words[0][0]))
        kind = content().ends_with(type_labels) ? words[0] : "";
      else if (!kind.empty() && words.size() == 2)
        labels_[kind].emplace(words[1], integer(words[0], "a type", 1, most));
    }
    lines_ = first;
  }

  /// Titles begin with a letter, but so do lines of masses and coefficients whose type has a label. These end in
  /// numbers, if not in the name of a style.
  bool is_title(std::string_view section, const Words& words) const {
    const bool may_have_label = section == "Masses" || section.ends_with(" Coeffs");
    const auto is_label = [&](const auto& labels) { return labels.second.contains(words[0]); };
    return is_letter(words[0][0]) &&
           !(may_have_label && (parse_number(words.back()) || std::ranges::any_of(labels_, is_label)));
  }

  /// Chooses how the lines of a section are read.
  void start(std::string_view section) {
    read_line_ = nullptr;
    if (section == "Atoms") {
      atoms_section_.title = lines_;
      atoms_section_.num_lines = 0;
      if (atoms_section_.style.empty()) find_style(comment());
    } else if (section == "Masses") {
      read_line_ = [this](const Words& words) { read_mass(words); };
    } else if (section == "Velocities") {
      read_line_ = [this](const Words& words) { read_velocity(words); };
    } else if (!section.ends_with(type_labels)) {
      for_each_section([&](auto& each) {
        if (section == each.kind + "s") read_line_ = [this, &each](const Words& words) { read_member(words, &each); };
        if (section != each.kind + " Coeffs") return;
        const Words words = split_words(comment());
        each.coefficients.style = words.empty() ? "" : words[0];
        read_line_ = [this, &each](const Words& line) { read_coefficients(line, each.kind, &each.coefficients); };
      });
      if (!read_line_) data_.unread.push_back("the section " + std::string(section));
    }
  }

  static constexpr std::string_view type_labels = " Type Labels";

  /// Reads "32000 atoms", "-16.8 16.8 xlo xhi", …
  void read_header(const Words& words) {
    const auto is = [&](std::size_t num_numbers, std::string_view name) {
      const Words tail = split_words(name);
      return words.size() == num_numbers + tail.size() &&
             std::equal(tail.begin(), tail.end(), words.end() - tail.size());
    };
    std::int64_t* count = is(1, "atoms") ? &num_atoms_ : is(1, "atom types") ? &num_atom_types_ : nullptr;
    for_each_section([&](auto& each) {
      if (is(1, each.what + "s")) count = &each.count;
      if (is(1, each.what + " types")) count = &each.num_types;
    });
    if (count != nullptr) {
      *count = integer(words[0], "a count", 0, most);
    } else if (is(2, "xlo xhi")) {
      data_.cell.xx = read_edge(words, 0);
    } else if (is(2, "ylo yhi")) {
      data_.cell.yy = read_edge(words, 1);
    } else if (is(2, "zlo zhi")) {
      data_.cell.zz = read_edge(words, 2);
    } else if (is(3, "xy xz yz")) {
      data_.cell.xy = number(words[0]);
      data_.cell.xz = number(words[1]);
      data_.cell.yz = number(words[2]);
    } else if (is(3, "avec") || is(3, "bvec") || is(3, "cvec")) {
      lines_.complain("found a general triclinic box, wanted xlo xhi, ylo yhi, zlo zhi and xy xz yz");
    } else if (!is_told_by_section(words)) {
      unread_header_.add(content());
    }
  }

  double read_edge(const Words& words, std::size_t axis) {
    atoms_section_.facts.low[axis] = number(words[0]);
    atoms_section_.facts.high[axis] = number(words[1]);
    const double length = atoms_section_.facts.high[axis] - atoms_section_.facts.low[axis];
    if (!(length > 0.0)) lines_.fail(words[1], "a higher end above the lower one");
    data_.cell.origin[axis] = atoms_section_.facts.low[axis];
    return length;
  }

  /// Returns true for counts of what a section of its own lists, which is named where it is not read, and for room that
  /// is left for later bonds.
  static bool is_told_by_section(const Words& words) {
    constexpr std::string_view lists[] = {"impropers", "ellipsoids", "lines", "triangles", "bodies"};
    if (words.size() == 2) return std::ranges::find(lists, words[1]) != std::end(lists);
    return words.back() == "types" || (words.size() == 5 && words[1] == "extra" && words.back() == "atom");
  }

  /// Finds the style after `Atoms #`.
  void find_style(std::string_view comment) {
    const Words words = split_words(comment);
    if (!words.empty() && find_atom_styles(comment).empty())
      lines_.fail(words[0],
                  fmt::format("one of {}, or else /import/atom_style", fmt::join(names_of_atom_styles(), ", ")));
    atoms_section_.style = comment;
  }

  void read_atoms() {
    if (atoms_section_.num_lines == 0) return;
    atoms_section_.facts.has_masses = !masses_.empty();
    atoms_section_.facts.num_types = num_atom_types_;
    atoms_section_.cell = data_.cell;
    for (const NamedMember<2>& bond : bonds_.named) atoms_section_.bonds.push_back(bond.atoms);
    atoms_ = read_lammps_atoms(*this, atoms_section_, &data_.unread);
  }

  void read_mass(const Words& words) {
    check_columns(words, {2}, "2: type mass");
    const std::int64_t type = this->type(words[0], "Atom", "an atom type", num_atom_types_);
    const double mass = number(words[1]);
    if (!(mass > 0.0)) lines_.fail(words[1], "a mass > 0");
    masses_[type] = mass;
  }

  void read_velocity(const Words& words) {
    if (words.size() < 4) lines_.complain(fmt::format("found {} columns, wanted 4: id vx vy vz", words.size()));
    has_spins_ = has_spins_ || words.size() > 4;
    velocities_.push_back({integer(words[0], "an atom id", 1, any), vector(words, 1)});
  }

  /// Reads "id type atom …".
  template <std::size_t size>
  void read_member(const Words& words, Section<size>* section) {
    check_columns(words, {size + 2}, section->columns);
    const bool is_bond = size == 2;  // whose id is not read, and whose types the header tells
    NamedMember<size>& member = section->named.emplace_back();
    if (!is_bond) member.id = integer(words[0], section->id, 1, any);
    member.type =
        type(words[1], section->kind, section->type, is_bond || section->num_types > 0 ? section->num_types : most);
    member.line = lines_.number();
    for (std::size_t k = 0; k < size; ++k) {
      constexpr std::array<std::string_view, 5> numbers{"", "", "two", "three", "four"};
      member.atoms[k] = integer(words[2 + k], "an atom id", 1, any);
      if (std::find(member.atoms.begin(), member.atoms.begin() + k, member.atoms[k]) != member.atoms.begin() + k)
        lines_.fail(words[2 + k], fmt::format("{} atoms that differ", numbers[size]));
    }
  }

  /// Reads "type number …". In hybrid styles the name of each type's own style stands in between.
  void read_coefficients(const Words& words, std::string_view kind, Imported::Coefficients* coefficients) {
    if (!coefficients->error.empty()) return;
    try {
      const std::int64_t type = this->type(words[0], kind, "a type", most);
      std::vector<double> numbers;
      for (const std::string_view word : std::span(words).subspan(1)) {
        if (is_letter(word[0])) lines_.fail(word, "a finite number (hybrid styles are not read)");
        numbers.push_back(number(word));
      }
      coefficients->of_type[type] = std::move(numbers);
    } catch (const InputError& error) {
      coefficients->error = error.what();
    }
  }

  /// Checks the counts, sorts the atoms by their ids, and lets bonds and angles refer to their positions in this order.
  Imported finish() {
    if (!unread_header_.empty()) data_.unread.push_back("what stands in header lines " + unread_header_.quote_all());
    if (has_spins_) data_.unread.emplace_back("what stands behind vx, vy and vz of Velocities");
    check_count("atoms", num_atoms_, atoms_.size());
    for_each_section([&](const auto& each) { check_count(each.what + "s", each.count, each.named.size()); });
    if (!velocities_.empty()) check_count("velocities", num_atoms_, velocities_.size());
    std::sort(atoms_.begin(), atoms_.end(), [](const LammpsAtom& a, const LammpsAtom& b) { return a.id < b.id; });
    const auto twin = std::adjacent_find(atoms_.begin(), atoms_.end(),
                                         [](const LammpsAtom& a, const LammpsAtom& b) { return a.id == b.id; });
    if (twin != atoms_.end()) complain(fmt::format("found atom {} twice, wanted ids that differ", twin->id));

    for (const LammpsAtom& atom : atoms_) {
      data_.positions.push_back(atom.position);
      data_.masses.push_back(mass_of(atom));
    }
    data_.velocities.resize(velocities_.size());
    for (const Velocity& velocity : velocities_) {
      const auto atom = find(velocity.id);
      if (!atom) complain(fmt::format("found a velocity of atom {}, wanted one of the section Atoms", velocity.id));
      data_.velocities[static_cast<std::size_t>(*atom)] = velocity.velocity;
    }
    for_each_section([&]<std::size_t size>(const Section<size>& section) {
      for (const NamedMember<size>& named : section.named) {
        Imported::Member<size>& member = section.members.emplace_back();
        member.type = named.type;
        member.id = named.id;
        for (std::size_t k = 0; k < size; ++k) member.atoms[k] = find(named.atoms[k], section.one, named.line);
      }
    });
    data_.num_bond_types = bonds_.num_types;
    return std::move(data_);
  }

  void check_count(std::string_view things, std::int64_t header, std::size_t found) const {
    if (header != static_cast<std::int64_t>(found))
      complain(fmt::format("found {} {}, wanted {} as its header says", found, things, header));
  }

  double mass_of(const LammpsAtom& atom) const {
    if (masses_.empty()) return 1.0;
    const auto mass = masses_.find(atom.type);
    if (mass == masses_.end())
      complain(fmt::format("missing the mass of atom type {}, wanted in the section Masses", atom.type));
    return mass->second;
  }

  /// Returns the position of an atom in the order of ids.
  std::optional<std::int32_t> find(std::int64_t id) const {
    const auto found = std::lower_bound(atoms_.begin(), atoms_.end(), id,
                                        [](const LammpsAtom& a, std::int64_t b) { return a.id < b; });
    if (found == atoms_.end() || found->id != id) return {};
    return static_cast<std::int32_t>(found - atoms_.begin());
  }
  /// Returns the same for an atom that a line names.
  std::int32_t find(std::int64_t id, std::string_view owner, std::size_t line) const {
    const auto found = find(id);
    if (!found) complain(fmt::format("found atom {} in {}, wanted one of the section Atoms", id, owner), line);
    return *found;
  }

  AtomsSection atoms_section_;
  std::function<void(const Words&)> read_line_;  ///< of the present section; null if nothing is read
  NameList unread_header_;
  bool has_spins_ = false;  ///< velocities are followed by other numbers
  std::int64_t num_atoms_ = 0, num_atom_types_ = 0;
  std::map<std::int64_t, double> masses_;  ///< by atom type
  std::vector<LammpsAtom> atoms_;
  std::vector<Velocity> velocities_;
  Imported data_;
  Section<2> bonds_{"bond", "Bond", data_.bonds, data_.bond_coefficients, 1};
  Section<3> angles_{"angle", "Angle", data_.angles, data_.angle_coefficients};
  Section<4> dihedrals_{"dihedral", "Dihedral", data_.dihedrals, data_.dihedral_coefficients};
};

}  // namespace

Imported read_lammps_data(const std::string& name, std::string_view text, const std::string& atom_style) {
  return LammpsReader(name, text, atom_style).read();
}

bool is_lammps_data(const std::string& name, std::string_view text) {
  LineReader lines(name, text.substr(0, text.find('\0')));
  while (lines.next()) {
    const Words words = split_words(lines.content());
    if (words.size() == 2 && words[1] == "atoms" && parse_integer(words[0])) return true;
  }
  return false;
}

}  // namespace tanor::scene
