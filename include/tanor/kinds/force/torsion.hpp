#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/force/law_number.hpp>

namespace tanor {

enum class TorsionLaw {
  Opls,      ///< 1/2 (k1 (1 + cos phi) + k2 (1 - cos 2 phi) + k3 (1 + cos 3 phi) + k4 (1 - cos 4 phi))
  Multi,     ///< sum of c_n cos^n psi, psi = phi - pi
  Periodic,  ///< k (1 + cos(n phi - phase))
  Harmonic,  ///< k/2 (phi - rest)^2 with the difference between -pi and pi, at whose ends the force jumps
};

/// An energy of the dihedral angle phi of four points: 0 for cis, pi for trans, positive if the last bond is turned
/// clockwise as seen along the middle one (IUPAC). The angle is undefined if three of them are in line.
struct Torsions {
  std::string name{};
  std::vector<std::array<Index, 4>> quadruples{};
  TorsionLaw law = TorsionLaw::Opls;
  std::vector<double> coefficients{};  ///< J: k1 to k4 (Opls), c0 to cn (Multi)
  Parameter stiffness{};               ///< k, J (Periodic) or J/rad^2 (Harmonic), >= 0
  int multiplicity = 1;                ///< n, >= 0 (Periodic)
  Parameter phase{};                   ///< rad (Periodic)
  Parameter rest{};                    ///< rad (Harmonic)
};

template <>
struct KindOf<Torsions> {
  static constexpr std::string_view name = "torsion";
  static constexpr auto members = &Torsions::quadruples;
  static constexpr const char* distinct = "a torsion needs four different points";
  static constexpr std::tuple fields{
      FieldOf("stiffness", &Torsions::stiffness, {.unit = "J", .range = ValueRange::not_negative, .is_constant = true}),
      FieldOf("phase", &Torsions::phase, {.unit = "rad", .is_constant = true}),
      FieldOf("rest", &Torsions::rest, {.unit = "rad", .is_constant = true})};

  static std::vector<LawNumber> law_numbers(const Torsions& torsions) {
    if (torsions.law == TorsionLaw::Periodic) return {{"stiffness", &torsions.stiffness}, {"phase", &torsions.phase}};
    if (torsions.law == TorsionLaw::Harmonic) return {{"stiffness", &torsions.stiffness}, {"rest", &torsions.rest}};
    return {};
  }
  static constexpr int most_numbers = 2;

  template <class T>
  struct Definition {
    TorsionLaw law;
    std::vector<double> coefficients;
    int multiplicity;

    explicit Definition(const Torsions& given)
        : law(given.law), coefficients(given.coefficients), multiplicity(given.multiplicity) {}

    template <class Points, class Numbers>
    T energy(const Points& r, const Numbers& numbers) const {
      using std::sqrt, std::cos, std::sin, std::atan2;
      const TripleOf<T> b1 = r[1] - r[0], b2 = r[2] - r[1], b3 = r[3] - r[2];
      const TripleOf<T> a = cross(b1, b2), b = cross(b2, b3);
      const T lengths = sqrt(dot(a, a) * dot(b, b));
      const T c = dot(a, b) / lengths;
      if (law == TorsionLaw::Multi) {
        T sum = 0.0;  // cos psi = -cos phi
        for (std::size_t n = coefficients.size(); n-- > 0;) sum = coefficients[n] - c * sum;
        return sum;
      }
      if (law == TorsionLaw::Opls) {
        // cos 2 phi = 2 c^2 - 1, cos 3 phi = 4 c^3 - 3 c, cos 4 phi = 8 c^4 - 8 c^2 + 1
        const T square = c * c;
        return 0.5 * coefficients[0] * (1.0 + c) + coefficients[1] * (1.0 - square) +
               0.5 * coefficients[2] * (1.0 + c * (4.0 * square - 3.0)) +
               4.0 * coefficients[3] * square * (1.0 - square);
      }
      // |b2| b1.(b2 x b3) = (A x B).b2/|b2|, which keeps more digits where three points are nearly in line
      const T s = dot(cross(a, b), b2) / (norm(b2) * lengths);
      const T turned_c = cos(numbers[1]), turned_s = sin(numbers[1]);
      if (law == TorsionLaw::Harmonic) {
        const T angle = atan2(s * turned_c - c * turned_s, c * turned_c + s * turned_s);
        return 0.5 * numbers[0] * angle * angle;
      }
      // (c + i s)^n
      T real = 1.0, imaginary = 0.0;
      for (int n = 0; n < multiplicity; ++n) {
        const T next = real * c - imaginary * s;
        imaginary = real * s + imaginary * c;
        real = next;
      }
      return numbers[0] * (1.0 + real * turned_c + imaginary * turned_s);
    }
  };

  /// Returns what is wrong with a quadruple at the positions of its points, or an empty text.
  template <class Points, class Numbers>
  static std::string complaint(const Torsions&, const Points& r, const Numbers&) {
    const TripleOf<double> b1 = r[1] - r[0], b2 = r[2] - r[1], b3 = r[3] - r[2];
    const auto is_straight = [](const TripleOf<double>& a, const TripleOf<double>& b) {
      return !(norm(cross(a, b)) >= least_sine * norm(a) * norm(b)) || !(norm(a) * norm(b) > 0.0);
    };
    const bool at_first = is_straight(b1, b2);
    if (!at_first && !is_straight(b2, b3)) return {};
    return std::string("its ") + (at_first ? "first" : "last") +
           " three points are on a straight line: there is no dihedral";
  }
};

}  // namespace tanor
