#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// xi = |r_i - a| + ratio |r_j - b| - length
struct Pulleys {
  std::string name{};
  std::vector<std::array<Index, 2>> pairs{};
  Vector3 a{}, b{};
  Parameter length{};
  double ratio = 1.0;
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

template <>
struct KindOf<Pulleys> {
  static constexpr std::string_view name = "pulley";
  static constexpr auto members = &Pulleys::pairs;
  static constexpr const char* distinct = "a pulley joins two different points";
  static constexpr int rows = 1;
  static constexpr auto parameter = &Pulleys::length;
  static constexpr auto fields = std::tuple_cat(
      std::tuple{FieldOf("a", &Pulleys::a, {.unit = "m", .role = FieldRole::Center, .is_required = true}),
                 FieldOf("b", &Pulleys::b, {.unit = "m", .role = FieldRole::Center, .is_required = true, .point = 1}),
                 FieldOf("length", &Pulleys::length, {.unit = "m"}),
                 FieldOf("ratio", &Pulleys::ratio, {.range = ValueRange::not_zero})},
      one_sided_fields<Pulleys>);

  template <class T>
  struct Definition {
    TripleOf<T> a, b;
    T ratio;

    template <class Now>
    Definition(const Pulleys& given, const Now&)
        : a(triple_of<T>(given.a)), b(triple_of<T>(given.b)), ratio(given.ratio) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      return norm(r[0] - a) + ratio * norm(r[1] - b);
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& length, std::size_t k) const {
      return {measure(r, k) - length};
    }
  };

  template <class Points>
  static const char* complaint(const Pulleys&, const Definition<double>& now, const Points& r, std::size_t) {
    if (!(norm(r[0] - now.a) > 0.0)) return "the first point is at a; the rope has no direction";
    if (!(norm(r[1] - now.b) > 0.0)) return "the second point is at b; the rope has no direction";
    return nullptr;
  }
  static double leverage(const Pulleys& pulleys, double, double) {
    return std::max(1.0, 1.0 / std::abs(pulleys.ratio));
  }
};

}  // namespace tanor
