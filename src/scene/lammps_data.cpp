#include "scene/lammps_data.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string_view>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/text_file.hpp"

namespace tanor::scene {

namespace {

using Words = std::vector<std::string_view>;

/// The columns of an Atoms section; x, y, z follow the last one that is named here.
struct AtomStyle {
  std::string_view name;
  std::size_t type_column, x_column;
};
constexpr AtomStyle atom_styles[] = {
    {"atomic", 1, 2},     // id type x y z
    {"molecular", 2, 3},  // id molecule type x y z
    {"full", 2, 4},       // id molecule type charge x y z
    {"bond", 2, 3},       // like molecular
    {"angle", 2, 3},      // like molecular
    {"charge", 1, 3},     // id type charge x y z
};

/// Reads one file; the driver is `read`.
class LammpsReader {
 public:
  LammpsReader(const std::string& name, std::string_view text) : name_(name), lines_(name, text) {}

  Imported read() {
    lines_.next();  // the first line is a comment
    find_units(split_words(lines_.line()));
    std::string section;
    while (lines_.next()) {
      const std::size_t hash = lines_.line().find('#');
      const std::string_view content = trim(lines_.line().substr(0, hash));
      if (content.empty()) continue;
      const Words words = split_words(content);
      if (is_letter(content[0])) {
        section = content;
        if (!is_read(section)) data_.unread.push_back(section);
        const std::string_view style = hash == std::string_view::npos ? "" : first_word(lines_.line().substr(hash + 1));
        if (section == "Atoms" && hash != std::string_view::npos) find_style(style);
        if (Imported::Coefficients* const coefficients = coefficients_of(section)) coefficients->style = style;
      } else if (section.empty()) {
        read_header(words);
      } else if (section == "Masses") {
        read_mass(words);
      } else if (section == "Atoms") {
        read_atom(words);
      } else if (section == "Velocities") {
        read_velocity(words);
      } else if (section == "Bonds") {
        read_bond(words);
      } else if (section == "Angles") {
        angles_.push_back(read_tuple<3>(words, "angle", data_.num_angle_types));
      } else if (section == "Dihedrals") {
        dihedrals_.push_back(read_tuple<4>(words, "dihedral", data_.num_dihedral_types));
      } else if (Imported::Coefficients* const coefficients = coefficients_of(section)) {
        read_coefficients(words, coefficients);
      }
    }
    return finish();
  }

 private:
  struct Atom {
    std::int64_t id, type;
    Vector3 position;
  };
  struct Velocity {
    std::int64_t id;
    Vector3 velocity;
  };
  struct NamedBond {
    std::int64_t type, i, j;  ///< ids
    std::size_t line;
  };
  template <std::size_t size>
  struct NamedTuple {
    std::int64_t id, type;
    std::array<std::int64_t, size> atoms;  ///< ids
    std::size_t line;
  };

  /// Finds "units = real" or "units real" anywhere in the first line.
  void find_units(const Words& words) {
    for (std::size_t k = 0; k + 1 < words.size(); ++k) {
      if (words[k] != "units") continue;
      const std::size_t next = words[k + 1] == "=" && k + 2 < words.size() ? k + 2 : k + 1;
      data_.units = words[next].substr(0, words[next].find_first_of(",.;)"));
    }
  }
  bool is_read(std::string_view section) {
    constexpr std::string_view sections[] = {"Masses", "Atoms", "Velocities", "Bonds", "Angles", "Dihedrals"};
    const bool is_name = section.ends_with("Type Labels");
    return is_name || std::ranges::find(sections, section) != std::end(sections) || coefficients_of(section) != nullptr;
  }

  static std::string_view first_word(std::string_view text) {
    const Words words = split_words(text);
    return words.empty() ? "" : words[0];
  }
  static bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

  std::int64_t integer(std::string_view word, std::string_view what, std::int64_t least, std::int64_t largest) const {
    const auto number = parse_integer(word);
    if (!number || *number < least || *number > largest)
      lines_.fail(word, fmt::format("{} from {} to {}", what, least, largest));
    return *number;
  }
  double number(std::string_view word) const {
    const auto number = parse_number(word);
    if (!number) lines_.fail(word, "a finite number");
    return *number;
  }
  Vector3 vector(const Words& words, std::size_t first) const {
    return {number(words[first]), number(words[first + 1]), number(words[first + 2])};
  }
  void check_columns(const Words& words, std::initializer_list<std::size_t> wanted, std::string_view what) const {
    if (std::find(wanted.begin(), wanted.end(), words.size()) == wanted.end())
      lines_.complain(fmt::format("found {} columns, wanted {}", words.size(), what));
  }

  static constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  static constexpr std::int64_t any = std::numeric_limits<std::int64_t>::max();

  /// Reads "32000 atoms", "-16.8 16.8 xlo xhi", …; other lines are skipped.
  void read_header(const Words& words) {
    const auto ends_with = [&](std::initializer_list<std::string_view> tail) {
      return words.size() >= tail.size() &&
             std::equal(tail.begin(), tail.end(), words.end() - static_cast<long>(tail.size()));
    };
    const auto count = [&] { return integer(words[0], "a count", 0, most); };
    const auto edge = [&] {
      const double length = number(words[1]) - number(words[0]);
      if (!(length > 0.0)) lines_.fail(words[1], "a higher end above the lower one");
      return length;
    };
    Cell& cell = data_.cell;
    if (words.size() == 2 && ends_with({"atoms"})) num_atoms_ = count();
    if (words.size() == 2 && ends_with({"bonds"})) num_bonds_ = count();
    if (words.size() == 2 && ends_with({"angles"})) num_angles_ = count();
    if (words.size() == 2 && ends_with({"dihedrals"})) num_dihedrals_ = count();
    if (words.size() == 3 && ends_with({"atom", "types"})) num_atom_types_ = count();
    if (words.size() == 3 && ends_with({"bond", "types"})) data_.num_bond_types = count();
    if (words.size() == 3 && ends_with({"angle", "types"})) data_.num_angle_types = count();
    if (words.size() == 3 && ends_with({"dihedral", "types"})) data_.num_dihedral_types = count();
    if (words.size() == 4 && ends_with({"xlo", "xhi"})) cell.xx = edge();
    if (words.size() == 4 && ends_with({"ylo", "yhi"})) cell.yy = edge();
    if (words.size() == 4 && ends_with({"zlo", "zhi"})) cell.zz = edge();
    if (words.size() == 6 && ends_with({"xy", "xz", "yz"})) {
      cell.xy = number(words[0]);
      cell.xz = number(words[1]);
      cell.yz = number(words[2]);
    }
    if (ends_with({"avec"}) || ends_with({"bvec"}) || ends_with({"cvec"}))
      lines_.complain("found a general triclinic box, wanted xlo xhi, ylo yhi, zlo zhi and xy xz yz");
  }

  /// Finds the style after `Atoms #`.
  void find_style(std::string_view name) {
    const auto style = std::find_if(std::begin(atom_styles), std::end(atom_styles),
                                    [&](const AtomStyle& s) { return s.name == name; });
    if (style == std::end(atom_styles)) lines_.fail(name, "one of atomic, molecular, full, bond, angle, charge");
    set_style(*style, "");
  }

  void guess_style(std::size_t num_columns) {
    for (const AtomStyle& style : {atom_styles[0], atom_styles[1], atom_styles[2]})
      if (num_columns == style.x_column + 3 || num_columns == style.x_column + 6) return set_style(style, ", guessed");
    lines_.complain(
        fmt::format("found {} columns, wanted 5 or 8 (style atomic), 6 or 9 (molecular), 7 or 10 (full)", num_columns));
  }

  /// Sets the style. The words for errors are made once, not in each of a million lines.
  void set_style(const AtomStyle& style, std::string_view remark) {
    style_ = style;
    const std::size_t x = style.x_column;
    atom_columns_ = fmt::format("{} or {} (style {}{})", x + 3, x + 6, style.name, remark);
    atom_type_ = fmt::format("an atom type (style {}{})", style.name, remark);
    image_flag_ = fmt::format("an image flag (style {}{})", style.name, remark);
  }

  void read_mass(const Words& words) {
    check_columns(words, {2}, "2: type mass");
    const std::int64_t type = integer(words[0], "an atom type", 1, num_atom_types_);
    const double mass = number(words[1]);
    if (!(mass > 0.0)) lines_.fail(words[1], "a mass > 0");
    masses_[type] = mass;
  }

  void read_atom(const Words& words) {
    if (!style_) guess_style(words.size());
    const std::size_t x = style_->x_column;
    check_columns(words, {x + 3, x + 6}, atom_columns_);
    Atom atom{.id = integer(words[0], "an atom id", 1, any),
              .type = integer(words[style_->type_column], atom_type_, 1, num_atom_types_),
              .position = vector(words, x)};
    if (words.size() == x + 6) {
      std::array<std::int64_t, 3> images;
      for (std::size_t k = 0; k < 3; ++k) images[k] = integer(words[x + 3 + k], image_flag_, -most, most);
      const Vector3 shift = data_.cell.shift(images);
      for (std::size_t k = 0; k < 3; ++k) atom.position[k] += shift[k];
    }
    atoms_.push_back(atom);
  }

  void read_velocity(const Words& words) {
    check_columns(words, {4}, "4: id vx vy vz");
    velocities_.push_back({integer(words[0], "an atom id", 1, any), vector(words, 1)});
  }

  void read_bond(const Words& words) {
    check_columns(words, {4}, "4: id type atom atom");
    const std::int64_t type = integer(words[1], "a bond type", 1, data_.num_bond_types);
    bonds_.push_back(
        {type, integer(words[2], "an atom id", 1, any), integer(words[3], "an atom id", 1, any), lines_.number()});
    if (bonds_.back().i == bonds_.back().j) lines_.fail(words[3], "two atoms that differ");
  }

  /// Reads "id type atom …" of angles and dihedrals; num_types is 0 if the header does not give it.
  template <std::size_t size>
  NamedTuple<size> read_tuple(const Words& words, const std::string& what, std::int64_t num_types) {
    std::string columns = fmt::format("{}: id type", size + 2);
    for (std::size_t k = 0; k < size; ++k) columns += " atom";
    check_columns(words, {size + 2}, columns);
    const std::string article = what[0] == 'a' ? "an " : "a ";
    NamedTuple<size> tuple{.id = integer(words[0], article + what + " id", 1, any),
                           .type = integer(words[1], article + what + " type", 1, num_types > 0 ? num_types : most),
                           .atoms = {},
                           .line = lines_.number()};
    for (std::size_t k = 0; k < size; ++k) {
      tuple.atoms[k] = integer(words[2 + k], "an atom id", 1, any);
      if (std::find(tuple.atoms.begin(), tuple.atoms.begin() + k, tuple.atoms[k]) != tuple.atoms.begin() + k)
        lines_.fail(words[2 + k], size == 3 ? "three atoms that differ" : "four atoms that differ");
    }
    return tuple;
  }

  Imported::Coefficients* coefficients_of(std::string_view section) {
    return section == "Bond Coeffs"       ? &data_.bond_coefficients
           : section == "Angle Coeffs"    ? &data_.angle_coefficients
           : section == "Dihedral Coeffs" ? &data_.dihedral_coefficients
                                          : nullptr;
  }
  /// Reads "type number …". In hybrid styles the name of each type's own style stands in between.
  void read_coefficients(const Words& words, Imported::Coefficients* coefficients) {
    const std::int64_t type = integer(words[0], "a type", 1, most);
    std::vector<double> numbers;
    for (const std::string_view word : std::span(words).subspan(1)) {
      if (is_letter(word[0])) lines_.fail(word, "a finite number (hybrid styles are not read)");
      numbers.push_back(number(word));
    }
    coefficients->of_type[type] = std::move(numbers);
  }

  /// Checks the counts, sorts the atoms by their ids, and lets bonds and angles refer to their positions in this order.
  Imported finish() {
    check_count("atoms", num_atoms_, atoms_.size());
    check_count("bonds", num_bonds_, bonds_.size());
    check_count("angles", num_angles_, angles_.size());
    check_count("dihedrals", num_dihedrals_, dihedrals_.size());
    if (!velocities_.empty()) check_count("velocities", num_atoms_, velocities_.size());
    std::sort(atoms_.begin(), atoms_.end(), [](const Atom& a, const Atom& b) { return a.id < b.id; });
    const auto twin =
        std::adjacent_find(atoms_.begin(), atoms_.end(), [](const Atom& a, const Atom& b) { return a.id == b.id; });
    if (twin != atoms_.end()) complain(fmt::format("found atom {} twice, wanted ids that differ", twin->id));

    for (const Atom& atom : atoms_) {
      data_.positions.push_back(atom.position);
      data_.masses.push_back(mass_of(atom));
    }
    data_.velocities.resize(velocities_.size());
    for (const Velocity& velocity : velocities_) {
      const auto atom = find(velocity.id);
      if (!atom) complain(fmt::format("found a velocity of atom {}, wanted one of the section Atoms", velocity.id));
      data_.velocities[static_cast<std::size_t>(*atom)] = velocity.velocity;
    }
    for (const NamedBond& bond : bonds_)
      data_.bonds.push_back({bond.type, {find(bond.i, "a bond", bond.line), find(bond.j, "a bond", bond.line)}});
    for (const NamedTuple<3>& angle : angles_) data_.angles.push_back({angle.id, angle.type, find(angle, "an angle")});
    for (const NamedTuple<4>& dihedral : dihedrals_)
      data_.dihedrals.push_back({dihedral.id, dihedral.type, find(dihedral, "a dihedral")});
    return std::move(data_);
  }
  template <std::size_t size>
  std::array<std::int32_t, size> find(const NamedTuple<size>& tuple, std::string_view owner) const {
    std::array<std::int32_t, size> atoms;
    for (std::size_t k = 0; k < size; ++k) atoms[k] = find(tuple.atoms[k], owner, tuple.line);
    return atoms;
  }

  [[noreturn]] void complain(const std::string& what, std::size_t line = 0) const {
    const std::string place = line > 0 ? fmt::format("{}, line {}", name_, line) : name_;
    throw InputError("", place + ": " + what);
  }

  void check_count(std::string_view things, std::int64_t header, std::size_t found) const {
    if (header != static_cast<std::int64_t>(found))
      complain(fmt::format("found {} {}, wanted {} as its header says", found, things, header));
  }

  double mass_of(const Atom& atom) const {
    if (masses_.empty()) return 1.0;
    const auto mass = masses_.find(atom.type);
    if (mass == masses_.end())
      complain(fmt::format("missing the mass of atom type {}, wanted in the section Masses", atom.type));
    return mass->second;
  }

  /// Returns the position of an atom in the order of ids.
  std::optional<std::int32_t> find(std::int64_t id) const {
    const auto found =
        std::lower_bound(atoms_.begin(), atoms_.end(), id, [](const Atom& a, std::int64_t b) { return a.id < b; });
    if (found == atoms_.end() || found->id != id) return {};
    return static_cast<std::int32_t>(found - atoms_.begin());
  }
  /// Returns the same for an atom that a line names.
  std::int32_t find(std::int64_t id, std::string_view owner, std::size_t line) const {
    const auto found = find(id);
    if (!found) complain(fmt::format("found atom {} in {}, wanted one of the section Atoms", id, owner), line);
    return *found;
  }

  const std::string name_;
  LineReader lines_;
  std::optional<AtomStyle> style_;
  std::string atom_columns_, atom_type_, image_flag_;
  std::int64_t num_atoms_ = 0, num_bonds_ = 0, num_angles_ = 0, num_dihedrals_ = 0, num_atom_types_ = 0;
  std::map<std::int64_t, double> masses_;  ///< by atom type
  std::vector<Atom> atoms_;
  std::vector<Velocity> velocities_;
  std::vector<NamedBond> bonds_;
  std::vector<NamedTuple<3>> angles_;
  std::vector<NamedTuple<4>> dihedrals_;
  Imported data_;
};

}  // namespace

Imported read_lammps_data(const std::string& name, std::string_view text) {
  return LammpsReader(name, text).read();
}

}  // namespace tanor::scene
