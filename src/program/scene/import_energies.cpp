#include "scene/import_energies.hpp"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/suggestion.hpp"
#include "base/text.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

constexpr double pi = 3.14159265358979323846;

double radians(double degrees) {
  return degrees == 180.0 ? pi : degrees * (pi / 180.0);
}

/// A section of coefficients with the style that applies; its errors name both.
class Styled {
 public:
  /// `what` is the kind of member, such as "bond", and `key` may name its style.
  Styled(const Cursor& key, const char* what, const Imported::Coefficients& coefficients,
         std::initializer_list<std::string_view> known)
      : key_(key), what_(what), coefficients_(coefficients) {
    std::string list;
    for (const std::string_view name : known) list += (list.empty() ? "" : ", ") + std::string(name);
    if (!coefficients.error.empty()) key_.complain(coefficients.error);
    style_ = key_ ? key_.string() : coefficients.style;
    if (style_.empty())
      key_.complain(fmt::format("missing, and no comment behind \"{} Coeffs\" names the style; wanted one of {}",
                                capitalised(), list));
    if (std::ranges::find(known, style_) == known.end())
      key_.complain(fmt::format("found the {} style {}{}, wanted one of {}", what, quote(style_),
                                suggest(style_, {known.begin(), known.end()}), list));
  }

  bool is(std::string_view style) const { return style_ == style; }
  /// Returns the coefficients of a type that occurs: `size` numbers or more, at most `most`.
  std::span<const double> of_type(std::int64_t type, std::size_t size, std::size_t most, const char* names) const {
    const auto found = coefficients_.of_type.find(type);
    if (found == coefficients_.of_type.end())
      key_.complain(fmt::format("the file has no coefficients of {} type {}, wanted {}", what_, type, names));
    if (found->second.size() < size || found->second.size() > most)
      key_.complain(fmt::format("the file has {} coefficients of {} type {}, wanted those of style {}: {}",
                                found->second.size(), what_, type, style_, names));
    return found->second;
  }
  std::span<const double> of_type(std::int64_t type, std::size_t size, const char* names) const {
    return of_type(type, size, size, names);
  }
  [[noreturn]] void fail(std::int64_t type, const std::string& problem) const {
    key_.complain(fmt::format("{} type {} of style {}: {}", what_, type, style_, problem));
  }

 private:
  std::string capitalised() const { return static_cast<char>(what_[0] - 'a' + 'A') + what_.substr(1); }

  Cursor key_;
  std::string what_, style_;
  const Imported::Coefficients& coefficients_;
};

/// Members by type, each in the order of the file.
template <std::size_t p>
using ByType = std::map<std::int64_t, std::vector<std::array<Index, p>>>;

template <class Member>
auto sort_by_type(const std::vector<Member>& members, const std::vector<std::int64_t>& left_out = {}) {
  ByType<std::tuple_size_v<decltype(Member::atoms)>> result;
  for (const Member& member : members)
    if (std::ranges::find(left_out, member.type) == left_out.end()) result[member.type].push_back(member.atoms);
  return result;
}

void add_bonds(const Imported& data, const ImportChoices& choices, const Cursor& import, std::vector<Force>* forces) {
  const Styled styled(import["bond_style"], "bond", data.bond_coefficients, {"harmonic", "fene", "morse"});
  for (auto& [type, pairs] : sort_by_type(data.bonds, choices.rod_types)) {
    Bonds bonds{.name = fmt::format("bonds{}", type), .pairs = std::move(pairs)};
    if (styled.is("fene")) {
      const auto c = styled.of_type(type, 2, 4, "K R0, then epsilon sigma");
      if (c.size() == 3) styled.fail(type, "epsilon without sigma");
      if (c.size() == 4 && c[2] != 0.0 && !choices.pairs_repel)
        styled.fail(type,
                    fmt::format("epsilon {} and sigma {} are a repulsion along the bond, wanted a pair force that "
                                "acts there too and \"fene_repulsion\": \"pair\", or epsilon 0",
                                detail::text(c[2]), detail::text(c[3])));
      bonds.law = BondLaw::Fene;
      bonds.stiffness = c[0];
      bonds.limit = c[1];
    } else if (styled.is("morse")) {
      const auto c = styled.of_type(type, 3, "D alpha r0");
      bonds.law = BondLaw::Morse;
      bonds.depth = c[0];
      bonds.width = c[1];
      bonds.rest_length = c[2];
    } else {
      const auto c = styled.of_type(type, 2, "K r0");
      bonds.stiffness = 2.0 * c[0];
      bonds.rest_length = c[1];
    }
    forces->emplace_back(std::move(bonds));
  }
}

void add_angles(const Imported& data, const Cursor& import, std::vector<Force>* forces) {
  const Styled styled(import["angle_style"], "angle", data.angle_coefficients,
                      {"harmonic", "cosine", "cosine/squared"});
  for (auto& [type, triples] : sort_by_type(data.angles)) {
    Bendings bendings{.name = fmt::format("angles{}", type), .triples = std::move(triples)};
    if (styled.is("cosine")) {
      bendings.law = BendingLaw::Cosine;
      bendings.stiffness = styled.of_type(type, 1, "K")[0];
    } else {
      const auto c = styled.of_type(type, 2, "K theta0");
      bendings.law = styled.is("harmonic") ? BendingLaw::Harmonic : BendingLaw::CosineHarmonic;
      bendings.stiffness = 2.0 * c[0];
      bendings.rest = radians(c[1]);
    }
    forces->emplace_back(std::move(bendings));
  }
}

/// Adds the dihedrals. LAMMPS defines multi/harmonic in cos phi, whereas the law `multi` uses cos psi = -cos phi.
void add_dihedrals(const Imported& data, const Cursor& import, std::vector<Force>* forces) {
  const Styled styled(import["dihedral_style"], "dihedral", data.dihedral_coefficients,
                      {"opls", "multi/harmonic", "charmm", "harmonic"});
  for (auto& [type, quadruples] : sort_by_type(data.dihedrals)) {
    Torsions torsions{.name = fmt::format("dihedrals{}", type), .quadruples = std::move(quadruples)};
    if (styled.is("opls")) {
      const auto c = styled.of_type(type, 4, "K1 K2 K3 K4");
      torsions.coefficients.assign(c.begin(), c.end());
    } else if (styled.is("multi/harmonic")) {
      torsions.law = TorsionLaw::Multi;
      for (const double a : styled.of_type(type, 5, "A1 A2 A3 A4 A5"))
        torsions.coefficients.push_back(torsions.coefficients.size() % 2 == 0 ? a : -a);
    } else {
      const bool is_charmm = styled.is("charmm");
      const auto c = styled.of_type(type, is_charmm ? 4 : 3, is_charmm ? "K n d weight" : "K d n");
      const double n = is_charmm ? c[1] : c[2];
      if (!(n >= 0.0 && n <= 1000.0 && n == static_cast<int>(n)))
        styled.fail(type, fmt::format("n = {}, wanted a whole number >= 0", n));
      if (is_charmm && c[3] != 0.0)
        styled.fail(type, fmt::format("weight {} asks for pair forces of its own, wanted 0", detail::text(c[3])));
      if (!is_charmm && c[1] != 1.0 && c[1] != -1.0) styled.fail(type, fmt::format("d = {}, wanted 1 or -1", c[1]));
      torsions.law = TorsionLaw::Periodic;
      torsions.stiffness = c[0];
      torsions.multiplicity = static_cast<int>(n);
      torsions.phase = is_charmm ? radians(c[2]) : c[1] > 0.0 ? 0.0 : pi;
    }
    forces->emplace_back(std::move(torsions));
  }
}

/// Refuses members whose atoms are not side by side once molecules are joined, because energies do not know periodic
/// images.
template <class Member>
void refuse_torn(const Imported& data, const std::vector<Member>& members, const char* what, const Cursor& wanted) {
  for (const Member& member : members) {
    for (std::size_t k = 1; k < member.atoms.size(); ++k) {
      if (are_side_by_side(data.cell, data.positions, member.atoms[k - 1], member.atoms[k])) continue;
      wanted.complain(
          fmt::format("the {} of atoms {} and {} reaches through a periodic face, wanted atoms side by side "
                      "once the bonds have joined them",
                      what, member.atoms[k - 1] + 1, member.atoms[k] + 1));
    }
  }
}

}  // namespace

std::vector<Force> make_energies(const Imported& data, const ImportChoices& choices, const Cursor& import) {
  std::vector<Force> forces;
  if (choices.bonds_are_energies && !data.bonds.empty()) {
    refuse_torn(data, data.bonds, "bond", import["bonds"]);
    add_bonds(data, choices, import, &forces);
  }
  if (choices.angles_are_energies && !data.angles.empty()) {
    refuse_torn(data, data.angles, "angle", import["angles"]);
    add_angles(data, import, &forces);
  }
  if (choices.dihedrals_are_energies && !data.dihedrals.empty()) {
    refuse_torn(data, data.dihedrals, "dihedral", import["dihedrals"]);
    add_dihedrals(data, import, &forces);
  }
  return forces;
}

}  // namespace tanor::scene
