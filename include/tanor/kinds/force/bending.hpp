#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/force/law_number.hpp>

namespace tanor {

enum class BendingLaw {
  Harmonic,        ///< k/2 (theta - theta0)^2
  CosineHarmonic,  ///< k/2 (cos theta - cos theta0)^2
  Cosine,          ///< k (1 + cos theta)
};

/// An energy of the angle theta at the middle point of three; theta is pi if they are in line.
///
/// The harmonic law is smooth through the straight angle if theta0 = pi. Otherwise its energy there, and at theta = 0,
/// is a cone, whose tip has no force.
struct Bendings {
  std::string name{};
  std::vector<std::array<Index, 3>> triples{};
  BendingLaw law = BendingLaw::Harmonic;
  Parameter stiffness{};  ///< k, J/rad^2 (Harmonic) or J, >= 0
  Parameter rest{};  ///< theta0, rad, 0 to pi (Harmonic, CosineHarmonic); a rest angle of pi must be one number for all
};

template <>
struct KindOf<Bendings> {
  static constexpr double pi = 3.14159265358979323846;
  /// Angles that differ from pi by less than this are pi, however many digits they are written with.
  static constexpr double rounding_of_pi = 1e-8;
  static constexpr ValueRange angle_range = {[](double x) -> const char* {
    if (0.0 <= x && x <= pi + rounding_of_pi) return nullptr;
    return x > 6.4 ? "is not between 0 and pi: rad, not degrees?" : "is not between 0 and pi";
  }};

  static constexpr std::string_view name = "bending";
  static constexpr auto members = &Bendings::triples;
  static constexpr const char* distinct = "a bending needs three different points";
  static constexpr std::tuple fields{
      FieldOf("stiffness", &Bendings::stiffness, {.unit = "J", .range = ValueRange::not_negative, .is_constant = true}),
      FieldOf("rest", &Bendings::rest, {.unit = "rad", .range = angle_range, .is_constant = true})};

  static std::vector<LawNumber> law_numbers(const Bendings& bendings) {
    if (bendings.law == BendingLaw::Cosine) return {{"stiffness", &bendings.stiffness}};
    return {{"stiffness", &bendings.stiffness}, {"rest", &bendings.rest}};
  }
  static constexpr int most_numbers = 2;
  /// Returns true if the rest angle of all is pi.
  static bool is_straight(const Bendings& bendings) {
    const std::vector<double>& rest = bendings.rest.constants;
    return rest.size() == 1 && std::abs(rest[0] - pi) <= rounding_of_pi;
  }

  template <class T>
  struct Definition {
    BendingLaw law;
    bool is_straight;

    explicit Definition(const Bendings& given) : law(given.law), is_straight(KindOf::is_straight(given)) {}

    template <class Points, class Numbers>
    T energy(const Points& r, const Numbers& numbers) const {
      using std::cos, std::atan2;
      const TripleOf<T> a = r[0] - r[1], b = r[2] - r[1];
      if (law == BendingLaw::Harmonic && is_straight) return 0.5 * numbers[0] * detail::square_of_bend(a, b);
      if (law == BendingLaw::Harmonic) {
        const T angle = atan2(norm(cross(a, b)), dot(a, b)) - numbers[1];
        return 0.5 * numbers[0] * angle * angle;
      }
      if (law == BendingLaw::Cosine) {
        // 1 + cos theta = |a/|a| + b/|b||^2/2, without cancellation near the straight angle
        const TripleOf<T> sum = a / norm(a) + b / norm(b);
        return 0.5 * numbers[0] * dot(sum, sum);
      }
      const T difference = dot(a, b) / (norm(a) * norm(b)) - cos(numbers[1]);
      return 0.5 * numbers[0] * difference * difference;
    }
  };

  /// Returns what is wrong with a triple at the positions of its points, or an empty text.
  template <class Points, class Numbers>
  static std::string complaint(const Bendings& bendings, const Points& r, const Numbers&) {
    const TripleOf<double> a = r[0] - r[1], b = r[2] - r[1];
    const double lengths = norm(a) * norm(b);
    if (!(lengths > 0.0)) return "two of its points are at one place: there is no angle";
    if (bendings.law != BendingLaw::Harmonic || norm(cross(a, b)) >= least_sine * lengths) return {};
    if (dot(a, b) > 0.0) return "its angle is 0, where the force of law harmonic has no direction";
    if (!is_straight(bendings))
      return "its angle is straight, where the force of law harmonic has no direction unless all rest at pi";
    return {};
  }
};

}  // namespace tanor
