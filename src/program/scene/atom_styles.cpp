#include "scene/atom_styles.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

/// Columns that are rare, and could be taken for those of `full`, are known by their name alone.
enum class Known { ByColumns, ByName, OpenByName };
struct Style {
  std::string_view name, columns;
  Known known = Known::ByColumns;
};

// https://docs.lammps.org/read_data.html. The manual and the code order some columns differently: both are here.
constexpr Style styles[] = {
    {"atomic", "id type x y z"},
    {"molecular", "id molecule type x y z"},
    {"charge", "id type q x y z"},
    {"full", "id molecule type q x y z"},
    {"bond", "id molecule type x y z"},
    {"angle", "id molecule type x y z"},
    {"amoeba", "id molecule type q x y z"},
    {"body", "id type bodyflag mass x y z"},
    {"bpm/sphere", "id molecule type diameter density x y z"},
    {"dielectric", "id type q x y z mux muy muz area ed em epsilon curvature"},
    {"dielectric", "id molecule type q x y z mux muy muz area ed em epsilon curvature"},
    {"dipole", "id type q x y z mux muy muz"},
    {"dpd", "id type theta x y z"},
    {"edpd", "id type edpd_temp edpd_cv x y z", Known::ByName},
    {"electron", "id type q espin eradius x y z"},
    {"ellipsoid", "id type ellipsoidflag density x y z"},
    {"line", "id molecule type lineflag density x y z"},
    {"mdpd", "id type rho x y z"},
    {"mesont", "id molecule type bond1 bond2 tube_mass mradius mlength buckling x y z"},
    {"oxdna", "id type x y z"},
    {"peri", "id type volume density x y z"},
    {"rheo", "id type status rho x y z", Known::ByName},
    {"rheo/thermal", "id type status rho energy x y z", Known::ByName},
    {"smd", "id type molecule volume mass kradius cradius x0 y0 z0 x y z"},
    {"sph", "id type rho esph cv x y z"},
    {"sphere", "id type diameter density x y z"},
    {"spin", "id type x y z spx spy spz sp"},
    {"tdpd", "id type x y z", Known::OpenByName},
    {"template", "id molecule template_index template_atom type x y z"},
    {"template", "id type molecule template_index template_atom x y z"},
    {"tri", "id molecule type triangleflag density x y z"},
    {"wavepacket", "id type q espin eradius etag cs_re cs_im x y z"},
    {"hybrid", "id type x y z", Known::OpenByName},
};

constexpr std::string_view whole_columns[] = {
    "id",    "molecule", "template_index", "template_atom", "espin",    "etag",         "bond1",
    "bond2", "buckling", "bodyflag",       "ellipsoidflag", "lineflag", "triangleflag", "status"};

/// Columns that are not below 0, as coordinates of a style that is not known may be.
constexpr std::string_view amounts[] = {"mass", "density", "diameter", "volume", "rho", "cv", "eradius"};

AtomColumns columns_of(const Style& style) {
  const std::vector<std::string_view> names = split_words(style.columns);
  return {std::string(style.name), {names.begin(), names.end()}, style.known == Known::OpenByName};
}

/// Adds the columns of the sub-styles that are not there yet. Other words are arguments of these.
void add_sub_styles(const std::vector<std::string_view>& words, AtomColumns* hybrid) {
  bool is_open = false;
  for (const std::string_view word : words) {
    const auto* const style = std::ranges::find(styles, word, &Style::name);
    if (style == std::end(styles) || word == "hybrid") continue;
    hybrid->style += " " + std::string(word);
    for (const std::string_view name : split_words(style->columns))
      if (std::ranges::find(hybrid->names, name) == hybrid->names.end()) hybrid->names.emplace_back(name);
    is_open = is_open || style->known == Known::OpenByName;
  }
  if (hybrid->style != "hybrid") hybrid->is_open = is_open;
}

/// Removes what does not satisfy a condition, unless nothing does.
template <class Condition>
void prefer(std::vector<AtomColumns>* candidates, const Condition& condition) {
  if (std::ranges::any_of(*candidates, condition)) std::erase_if(*candidates, std::not_fn(condition));
}

/// Replaces columns of which more follow by those that fill the lines, with image flags and without.
std::vector<AtomColumns> fill_open(const std::vector<AtomColumns>& candidates, std::size_t num_columns) {
  std::vector<AtomColumns> filled;
  for (const AtomColumns& each : candidates) {
    for (const std::size_t num_images : {3, 0}) {
      if (each.is_open && each.names.size() + num_images <= num_columns) {
        AtomColumns& longer = filled.emplace_back(each);
        while (longer.names.size() + num_images < num_columns)
          longer.names.push_back(std::to_string(longer.names.size() + 1));
      }
    }
    if (!each.is_open) filled.push_back(each);
  }
  return filled;
}

}  // namespace

std::size_t AtomColumns::find(std::string_view name) const {
  return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
}

std::vector<AtomColumns> find_atom_styles(std::string_view name) {
  const std::vector<std::string_view> words = split_words(name);
  if (words.empty()) return {};
  const std::string_view first = words[0].substr(0, words[0].find_first_of(":,;"));
  std::vector<AtomColumns> found;
  for (const Style& style : styles)
    if (style.name == first) found.push_back(columns_of(style));
  if (first == "hybrid") add_sub_styles(words, &found[0]);
  const auto count = first == "tdpd" && words.size() > 1 ? parse_integer(words[1]) : std::nullopt;
  if (count && *count >= 0 && *count < 1000) {
    found[0].is_open = false;
    for (std::int64_t k = 1; k <= *count; ++k) found[0].names.push_back("cc" + std::to_string(k));
  }
  return found;
}

std::vector<AtomColumns> all_atom_styles() {
  std::vector<AtomColumns> all;
  for (const Style& style : styles)
    if (style.known == Known::ByColumns) all.push_back(columns_of(style));
  return all;
}

std::vector<std::string> names_of_atom_styles() {
  std::vector<std::string> names;
  for (const Style& style : styles)
    if (names.empty() || style.name != names.back()) names.emplace_back(style.name);
  return names;
}

void AtomSurvey::add(const std::vector<std::string_view>& words) {
  if (columns_.empty()) columns_.resize(words.size());
  is_even_ = is_even_ && words.size() == columns_.size();
  for (std::size_t k = 0; k < std::min(words.size(), columns_.size()); ++k) {
    Column& column = columns_[k];
    const auto number = parse_number(words[k]);
    column.is_number = column.is_number && spells_number(words[k]);
    column.is_whole = column.is_whole && parse_integer(words[k]).has_value();
    column.is_type = column.is_type && is_type_(words[k]);
    column.least = std::min(column.least, number.value_or(column.least));
    column.most = std::max(column.most, number.value_or(column.most));
  }
  add_moment(words);
}

/// Looks at the columns behind x, y and z of styles dipole and spin, which may be taken for image flags.
void AtomSurvey::add_moment(const std::vector<std::string_view>& words) {
  constexpr std::size_t spin = 5, dipole = 6, least_columns = 9;
  constexpr double rounding = 1e-2;  // of numbers in files
  if (words.size() < least_columns) return;
  std::array<double, 4> v;
  for (std::size_t k = 0; k < 4; ++k) v[k] = parse_number(words[spin + k]).value_or(0.0);
  const double length = v[1] * v[1] + v[2] * v[2] + v[3] * v[3], direction = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  const auto type = dipole_of_type_.try_emplace(std::string(words[1]), length).first;
  has_equal_dipoles_ =
      has_equal_dipoles_ && std::abs(type->second - length) <= rounding * std::max(type->second, length);
  // LAMMPS takes directions of any length, but those with fractions have length 1.
  const bool is_whole = std::all_of(words.begin() + spin, words.begin() + dipole + 2,
                                    [](std::string_view word) { return parse_integer(word).has_value(); });
  const bool is_direction = is_whole ? direction > 0.0 : std::abs(direction - 1.0) <= rounding;
  has_directions_ = has_directions_ && v[3] >= 0.0 && (is_direction || (direction == 0.0 && v[3] == 0.0));
  has_spins_ = has_spins_ || v[3] > 0.0;
}

bool AtomSurvey::fits(const AtomColumns& columns) const {
  if (!is_even_ || (columns_.size() != columns.names.size() && !has_images(columns))) return false;
  if (columns.style == "spin" && !(has_directions_ && has_spins_)) return false;
  for (std::size_t k = 0; k < columns.names.size(); ++k) {
    const std::string& name = columns.names[k];
    const bool is_whole = std::ranges::find(whole_columns, name) != std::end(whole_columns);
    const Column& column = columns_[k];
    if (column.least < 0.0 && std::ranges::find(amounts, name) != std::end(amounts)) return false;
    if (!(name == "type" ? column.is_type : is_whole ? column.is_whole : column.is_number)) return false;
  }
  return std::all_of(columns_.begin() + static_cast<long>(columns.names.size()), columns_.end(),
                     [](const Column& column) { return column.is_whole; });
}

std::array<double, 2> AtomSurvey::image_range() const {
  const std::span images(columns_.end() - 3, columns_.end());
  return {std::ranges::min(images, {}, &Column::least).least, std::ranges::max(images, {}, &Column::most).most};
}

bool AtomSurvey::is_inside(std::size_t x, const Vector3& low, const Vector3& high) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double edge = high[k] - low[k];
    if (edge > 0.0 && (columns_[x + k].least < low[k] - edge || columns_[x + k].most > high[k] + edge)) return false;
  }
  return true;
}

std::size_t AtomSurvey::num_fractional(std::size_t x) const {
  const std::span place(columns_.begin() + static_cast<std::ptrdiff_t>(x), 3);
  return static_cast<std::size_t>(std::ranges::count(place, false, &Column::is_whole));
}

std::vector<AtomColumns> choose_columns(std::vector<AtomColumns> candidates, const AtomSurvey& survey,
                                        const AtomFacts& facts) {
  candidates = fill_open(candidates, survey.num_columns());
  std::erase_if(candidates, [&](const AtomColumns& each) { return !survey.fits(each); });
  prefer(&candidates, [&](const AtomColumns& each) {
    // Columns whose number nobody knows may end in whole numbers of their own, which are not below 0.
    return !each.is_open || (survey.has_images(each) && (!survey.has_shift() || survey.image_range()[0] < 0.0));
  });
  prefer(&candidates, [&](const AtomColumns& each) { return survey.is_inside(each.find("x"), facts.low, facts.high); });
  // Whole numbers at the end are no coordinates where they may be image flags behind coordinates with fractions,
  // unless they are large for flags and give each atom a place of its own.
  const auto has_fractions = [&](const AtomColumns& each) { return survey.num_fractional(each.find("x")) > 0; };
  if (std::ranges::any_of(candidates, [&](const auto& each) { return survey.has_images(each) && has_fractions(each); }))
    prefer(&candidates, [&](const AtomColumns& each) {
      const std::size_t x = each.find("x");
      const auto [least, most] = survey.image_range();
      return x + 3 != survey.num_columns() || has_fractions(each) ||
             (!(least >= -1.0 && most <= 1.0) && facts.has_distinct_places(x));
    });
  prefer(&candidates, [&](const AtomColumns& each) { return survey.num_fractional(each.find("x")) % 3 == 0; });
  const auto has_first_x = [&](const AtomColumns& each) { return each.find("x") == candidates[0].find("x"); };
  if (!std::ranges::all_of(candidates, has_first_x))
    prefer(&candidates, [&](const AtomColumns& each) { return facts.has_distinct_places(each.find("x")); });
  // Image flags of one type's atoms differ, the lengths of their dipoles do not.
  prefer(&candidates, [&](const AtomColumns& each) { return each.style != "dipole" || survey.has_equal_dipoles(); });
  // Bonds join atoms of one molecule, and the types reach the last one of the header.
  prefer(&candidates, [&](const AtomColumns& each) {
    return facts.bonds_share_second && each.find("molecule") == 1 &&
           survey.most(each.find("type")) == static_cast<double>(facts.num_types);
  });
  return candidates;
}

bool are_equivalent(const AtomColumns& a, const AtomColumns& b, const AtomSurvey& survey, const AtomFacts& facts) {
  const bool type_matters = facts.has_masses && facts.num_types > 1;
  const bool shift_matters = survey.has_images(a) != survey.has_images(b) && survey.has_shift();
  return a.find("x") == b.find("x") && !shift_matters && (!type_matters || a.find("type") == b.find("type"));
}

}  // namespace tanor::scene
