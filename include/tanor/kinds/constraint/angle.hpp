#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// xi = cos(angle at the middle point of i, j, k) - cosine; its multiplier is a torque, N m.
struct Angles {
  std::string name{};
  std::vector<std::array<Index, 3>> triples{};
  Parameter cosine{};
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

template <>
struct KindOf<Angles> {
  static constexpr ValueRange cosine_range = {
      [](double x) { return -1.0 <= x && x <= 1.0 ? nullptr : "is not between -1 and 1"; }};
  /// Excludes straight angles, to rounding: their cosine has no slope, so the constraint would have no gradient.
  static constexpr ValueRange parameter_range = {[](double x) -> const char* {
    if (std::abs(x) < 1.0 - 8.0 * std::numeric_limits<double>::epsilon()) return nullptr;
    return "is that of a straight triple, whose angle cannot be held by its cosine; use a line or rods";
  }};

  static constexpr std::string_view name = "angle";
  static constexpr auto members = &Angles::triples;
  static constexpr const char* distinct = "an angle needs three different points";
  static constexpr int rows = 1;
  static constexpr auto parameter = &Angles::cosine;
  static constexpr auto fields =
      std::tuple_cat(std::tuple{FieldOf("cosine", &Angles::cosine, {.range = cosine_range})}, one_sided_fields<Angles>);

  template <class T>
  struct Definition {
    template <class Now>
    Definition(const Angles&, const Now&) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      const TripleOf<T> a = r[0] - r[1], b = r[2] - r[1];
      return dot(a, b) / (norm(a) * norm(b));
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& cosine, std::size_t k) const {
      return {measure(r, k) - cosine};
    }
  };

  template <class Points>
  static const char* complaint(const Angles& angles, const Definition<double>&, const Points& r, std::size_t) {
    const TripleOf<double> a = r[0] - r[1], b = r[2] - r[1];
    if (!angles.cosine.is_initial() || (norm(a) > 0.0 && norm(b) > 0.0 && norm(a - b) > 0.0)) return nullptr;
    return "two of the points are at the same place: there is no initial angle";
  }
  static double leverage(const Angles&, double, double size) { return size; }
};

}  // namespace tanor
