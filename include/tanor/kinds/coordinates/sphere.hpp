#pragma once

#include <array>
#include <string>
#include <vector>

#include <tanor/kinds/chart.hpp>
#include <tanor/kinds/constraint/sphere.hpp>

namespace tanor {

/// Two numbers of a stereographic chart around the present position, rad near it. The chart has no poles.
struct SphereCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction center{};
  Parameter radius{};
};

template <>
struct KindOf<SphereCoordinates> {
  static constexpr std::string_view name = "sphere";
  static constexpr auto members = &SphereCoordinates::points;
  static constexpr auto fields = sphere_fields<SphereCoordinates>;
  static constexpr int coordinates = 2;
  static constexpr auto parameter = &SphereCoordinates::radius;
  /// The direction of the position at which both numbers are 0, of unit length.
  using Chart = Vector3;

  /// r = center + radius u(q), where direction_around gives u.
  template <class T>
  struct Definition : KindOf<Spheres>::Definition<T> {
    using Base = typename KindOf<Spheres>::template Definition<T>;
    using Base::Base, Base::center;

    TripleOf<T> place(const std::array<T, 2>& q, const T& radius, const Chart& chart) const {
      return center + radius * direction_around(chart, q[0], q[1]);
    }
    std::array<T, 2> locate(const TripleOf<T>& r, const T&, const Chart& chart) const {
      return numbers_around(chart, (r - center) / norm(r - center));
    }
    Chart chart_at(const TripleOf<double>& r) const {
      const TripleOf<double> u = (r - center) / norm(r - center);
      return {u.x, u.y, u.z};
    }
  };

  template <class Points>
  static const char* complaint(const SphereCoordinates& group, const Definition<double>& now, const Points& r,
                               std::size_t) {
    if (norm(r[0] - now.center) > 0.0) return nullptr;
    return group.radius.is_initial() ? "it is at the center: the initial radius is 0; a radius is positive"
                                     : "it is at the center and has no direction there";
  }
};

}  // namespace tanor
