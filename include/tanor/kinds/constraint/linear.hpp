#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// xi = sum over the tuple of c.r - value, with the same coefficients for every tuple.
struct Linears {
  std::string name{};
  std::vector<std::vector<Index>> tuples{};
  std::vector<Vector3> coefficients{};  ///< one for each point of a tuple
  Parameter value = 0.0;
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

template <>
struct KindOf<Linears> {
  static constexpr std::string_view name = "linear";
  static constexpr auto members = &Linears::tuples;
  static constexpr const char* distinct = "the points of a tuple differ";
  static constexpr int rows = 1;
  static constexpr auto parameter = &Linears::value;
  static constexpr auto fields =
      std::tuple_cat(std::tuple{FieldOf("coefficients", &Linears::coefficients, {.is_required = true}),
                                FieldOf("value", &Linears::value)},
                     one_sided_fields<Linears>);

  template <class T>
  struct Definition {
    const Linears& linears;

    template <class Now>
    Definition(const Linears& given, const Now&) : linears(given) {}

    template <class Points>
    T measure(const Points& r, std::size_t) const {
      T sum(0.0);
      for (std::size_t p = 0; p < linears.coefficients.size(); ++p)
        sum += dot(triple_of<T>(linears.coefficients[p]), r[p]);
      return sum;
    }
    template <class Points>
    std::array<T, 1> xi(const Points& r, const T& value, std::size_t k) const {
      return {measure(r, k) - value};
    }
  };

  static double leverage(const Linears& linears, double, double) {
    double largest = 0.0;
    for (const Vector3& c : linears.coefficients) largest = std::max(largest, norm(triple_of<double>(c)));
    return largest > 0.0 ? 1.0 / largest : 0.0;
  }
};

}  // namespace tanor
