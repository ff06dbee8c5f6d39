#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// xi = |r_j - r_i + offset| - length; the tension is -lambda.
struct Rods {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  Parameter length{};              ///< m, > 0
  std::vector<Vector3> offsets{};  ///< m; constant image shift of r_j - r_i; empty or one for each
  std::optional<OneSide> side{};
  double restitution = 0.0;
  std::vector<double> breaks_at{};  ///< N, > 0, for all or one for each; empty: they do not break
};

template <>
struct KindOf<Rods> {
  static constexpr std::string_view name = "rod";
  static constexpr auto members = &Rods::pairs;
  static constexpr const char* distinct = "a rod joins two different points";
  static constexpr int rows = 1;
  static constexpr auto parameter = &Rods::length;
  static constexpr auto fields =
      std::tuple_cat(std::tuple{FieldOf("length", &Rods::length, {.unit = "m", .range = ValueRange::positive}),
                                FieldOf("offsets", &Rods::offsets, {.unit = "m"})},
                     one_sided_fields<Rods>, std::tuple{strength_field<Rods>});
  static constexpr bool is_distance = true;

  template <class T>
  struct Definition {
    const Rods& rods;

    template <class Now>
    Definition(const Rods& given, const Now&) : rods(given) {}

    template <class Points>
    T measure(const Points& r, std::size_t k) const {
      return norm(r[1] - r[0] + triple_of<T>(rods.offsets.empty() ? Vector3{} : rods.offsets[k]));
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& length, std::size_t k) const {
      return {measure(r, k) - length};
    }
  };

  template <class Points>
  static const char* complaint(const Rods& rods, const Definition<double>& now, const Points& r, std::size_t k) {
    if (!rods.length.is_initial() || now.measure(r, k) > 0.0) return nullptr;
    return "the initial length is 0; a rod's length is positive";
  }
};

}  // namespace tanor
