#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/force/law_number.hpp>

namespace tanor {

enum class BondLaw {
  Harmonic,  ///< k/2 (r - r0)^2
  Fene,      ///< -k R^2/2 ln(1 - (r/R)^2), r < R
  Morse,     ///< D (1 - exp(-a (r - r0)))^2
};

/// An energy of the distance r between two points.
struct Bonds {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  BondLaw law = BondLaw::Harmonic;
  Parameter stiffness{};    ///< k, N/m, > 0 (Harmonic, Fene)
  Parameter rest_length{};  ///< r0, m, >= 0 (Harmonic, Morse)
  Parameter limit{};        ///< R, m, > 0 (Fene)
  Parameter depth{};        ///< D, J, > 0 (Morse)
  Parameter width{};        ///< a, 1/m, > 0 (Morse)
};

template <>
struct KindOf<Bonds> {
  static constexpr std::string_view name = "bond";
  static constexpr auto members = &Bonds::pairs;
  static constexpr const char* distinct = "a bond joins two different points";
  static constexpr std::tuple fields{
      FieldOf("stiffness", &Bonds::stiffness, {.unit = "N/m", .range = ValueRange::positive, .is_constant = true}),
      FieldOf("rest_length", &Bonds::rest_length,
              {.unit = "m", .range = ValueRange::not_negative, .is_constant = true}),
      FieldOf("limit", &Bonds::limit, {.unit = "m", .range = ValueRange::positive, .is_constant = true}),
      FieldOf("depth", &Bonds::depth, {.unit = "J", .range = ValueRange::positive, .is_constant = true}),
      FieldOf("width", &Bonds::width, {.unit = "1/m", .range = ValueRange::positive, .is_constant = true})};

  static std::vector<LawNumber> law_numbers(const Bonds& bonds) {
    const LawNumber rest{"rest_length", &bonds.rest_length, ValueRange::not_negative, true};
    if (bonds.law == BondLaw::Fene) return {{"stiffness", &bonds.stiffness}, {"limit", &bonds.limit}};
    if (bonds.law == BondLaw::Morse) return {{"depth", &bonds.depth}, {"width", &bonds.width}, rest};
    return {{"stiffness", &bonds.stiffness}, rest};
  }
  static constexpr int most_numbers = 3;

  template <class T>
  struct Definition {
    BondLaw law;

    explicit Definition(const Bonds& given) : law(given.law) {}

    template <class Points>
    T measure(const Points& r) const {
      return norm(r[1] - r[0]);
    }
    template <class Points, class Numbers>
    T energy(const Points& r, const Numbers& numbers) const {
      using std::exp, std::log;
      const TripleOf<T> a = r[1] - r[0];
      if (law == BondLaw::Fene) {
        const T square = numbers[1] * numbers[1];
        return -0.5 * numbers[0] * square * log(1.0 - dot(a, a) / square);
      }
      if (law == BondLaw::Morse) {
        const T part = 1.0 - exp(-numbers[1] * (norm(a) - numbers[2]));
        return numbers[0] * part * part;
      }
      const T stretch = norm(a) - numbers[1];
      return 0.5 * numbers[0] * stretch * stretch;
    }
  };

  /// Returns what is wrong with a bond at the positions of its points, or an empty text.
  template <class Points, class Numbers>
  static std::string complaint(const Bonds& bonds, const Points& r, const Numbers& numbers) {
    const double distance = norm(r[1] - r[0]);
    if (!(distance > 0.0)) return "its points are at one place, where the force has no direction";
    if (bonds.law == BondLaw::Fene && !(distance < numbers[1]))
      return "the distance " + detail::show(distance) + " is not below the limit " + detail::show(numbers[1]);
    return {};
  }
};

}  // namespace tanor
