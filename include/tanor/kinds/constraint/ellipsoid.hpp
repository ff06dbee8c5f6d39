#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>

namespace tanor {

/// Points on an ellipsoid with the half axes a, b, c along three orthogonal directions. With the position y in these
/// axes, k0 = |(y1/a, y2/b, y3/c)| and k1 = |(y1/a^2, y2/b^2, y3/c^2)|, xi = k0 (k0 - 1)/k1.
///
/// On the surface the gradient has unit length, so that xi is the distance to first order and lambda is the force, N.
/// With three equal radii xi is the distance everywhere.
struct Ellipsoids {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  Vector3 radii{1.0, 1.0, 1.0};  ///< m, > 0: a, b, c
  /// The direction of a, and a vector whose part orthogonal to it is the direction of b.
  std::array<Vector3, 2> axes{Vector3{1.0, 0.0, 0.0}, Vector3{0.0, 1.0, 0.0}};
  std::optional<OneSide> side{};
  double restitution = 0.0;
};

template <>
struct KindOf<Ellipsoids> {
  static constexpr std::string_view name = "ellipsoid";
  static constexpr auto members = &Ellipsoids::points;
  static constexpr int rows = 1;
  static constexpr auto fields = std::tuple_cat(
      std::tuple{
          FieldOf("center", &Ellipsoids::center, {.unit = "m", .role = FieldRole::Center, .is_required = true}),
          FieldOf("radii", &Ellipsoids::radii, {.unit = "m", .range = ValueRange::positive, .is_required = true}),
          FieldOf("axes", &Ellipsoids::axes, {.role = FieldRole::Direction})},
      one_sided_fields<Ellipsoids>);

  template <class T>
  struct Definition {
    TripleOf<T> center;
    std::array<TripleOf<T>, 3> direction;
    std::array<double, 3> radius;

    template <class Now>
    Definition(const Ellipsoids& given, const Now& now) : center(now(given.center)), radius(given.radii) {
      const TripleOf<double> e = unit(triple_of<double>(given.axes[0])), h = triple_of<double>(given.axes[1]);
      const TripleOf<double> f = unit(h - dot(e, h) * e), g = cross(e, f);
      direction = {triple(e), triple(f), triple(g)};
    }

    template <class Points>
    std::array<T, 1> xi(const Points& r, const T&, std::size_t) const {
      using std::sqrt;
      const TripleOf<T> arm = r[0] - center;
      T first(0.0), second(0.0);  // k0^2, k1^2
      for (std::size_t j = 0; j < 3; ++j) {
        const T part = dot(direction[j], arm) * (1.0 / radius[j]);
        const T square = part * part;
        first += square;
        second += square * (1.0 / (radius[j] * radius[j]));
      }
      return {(first - sqrt(first)) / sqrt(second)};
    }

   private:
    static TripleOf<double> unit(const TripleOf<double>& a) { return a / norm(a); }
    static TripleOf<T> triple(const TripleOf<double>& a) { return {T(a.x), T(a.y), T(a.z)}; }
  };

  template <class Points>
  static const char* complaint(const Ellipsoids& group, const Definition<double>& now, const Points& r, std::size_t) {
    const TripleOf<double> a = triple_of<double>(group.axes[0]), b = triple_of<double>(group.axes[1]);
    if (!(norm(cross(a, b)) > 1e-8 * norm(a) * norm(b))) return "its axes are parallel; they span a plane";
    return norm(r[0] - now.center) > 0.0 ? nullptr : "it is at the center and has no direction there";
  }
};

}  // namespace tanor
