#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Ropes over points and supports p_0 … p_m, where the inner ones are pulleys without mass and friction:
///
///   xi = sum over k of c_k |r_{p_k} - r_{p_{k-1}}| - length <= 0
///
/// A slack rope carries nothing; the tension is -lambda, N, and c_k times that in segment k.
struct Ropes {
  std::string name{};
  std::vector<std::vector<Index>> paths{};
  Parameter length{};                  ///< m, > 0
  std::vector<double> coefficients{};  ///< > 0, one for each segment of a path; empty: all 1
  double restitution = 0.0;
  std::optional<OneSide> side = OneSide::AtMost;  ///< none: it is held at its length
  std::vector<double> breaks_at{};                ///< N, > 0, for all or one for each; empty: they do not break
};

template <>
struct KindOf<Ropes> {
  static constexpr std::string_view name = "rope";
  static constexpr auto members = &Ropes::paths;
  static constexpr const char* list = "paths";
  static constexpr const char* distinct = "a rope passes a point once; `coefficients` count its parts in a tackle";
  static constexpr int rows = 1;
  static constexpr auto parameter = &Ropes::length;
  static constexpr std::tuple fields{FieldOf("length", &Ropes::length, {.unit = "m", .range = ValueRange::positive}),
                                     FieldOf("coefficients", &Ropes::coefficients),
                                     FieldOf("restitution", &Ropes::restitution, {.range = restitution_range}),
                                     strength_field<Ropes>};

  template <class T>
  struct Definition {
    const Ropes& ropes;

    template <class Now>
    Definition(const Ropes& given, const Now&) : ropes(given) {}

    template <class Points>
    T measure(const Points& r, std::size_t k) const {
      T sum(0.0);
      for (std::size_t p = 1; p < ropes.paths[k].size(); ++p)
        sum += (ropes.coefficients.empty() ? 1.0 : ropes.coefficients[p - 1]) * norm(r[p] - r[p - 1]);
      return sum;
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& length, std::size_t k) const {
      return {measure(r, k) - length};
    }
  };

  template <class Points>
  static const char* complaint(const Ropes& ropes, const Definition<double>&, const Points& r, std::size_t k) {
    for (std::size_t p = 1; p < ropes.paths[k].size(); ++p) {
      if (!(norm(r[p] - r[p - 1]) > 0.0)) return "two neighbours of a path are at the same place: it has no direction";
    }
    return nullptr;
  }
  static double leverage(const Ropes& ropes, double, double) {
    double least = 1.0;
    for (const double c : ropes.coefficients) least = std::min(least, c);
    return 1.0 / least;
  }
};

}  // namespace tanor
