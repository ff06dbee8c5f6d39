#pragma once

#include <array>
#include <string>
#include <vector>

#include <tanor/kinds/chart.hpp>
#include <tanor/kinds/constraint/plane.hpp>

namespace tanor {

/// Two lengths, m, along two unit vectors of the plane normal.r = offset.
struct PlaneCoordinates {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction normal{};
  Parameter offset = 0.0;
};

template <>
struct KindOf<PlaneCoordinates> {
  static constexpr std::string_view name = "plane";
  static constexpr auto members = &PlaneCoordinates::points;
  static constexpr auto fields = plane_fields<PlaneCoordinates>;
  static constexpr int coordinates = 2;
  static constexpr auto parameter = &PlaneCoordinates::offset;
  /// The coordinate axis that defines the first unit vector.
  using Chart = LineAxis;

  /// r = (offset/|n|) n/|n| + q1 e1 + q2 e2
  template <class T>
  struct Definition : KindOf<Planes>::Definition<T> {
    using Base = typename KindOf<Planes>::template Definition<T>;
    using Base::Base, Base::normal;

    TripleOf<T> place(const std::array<T, 2>& q, const T& offset, Chart axis) const {
      const auto [e1, e2] = frame_of(normal, axis);
      return (offset / dot(normal, normal)) * normal + q[0] * e1 + q[1] * e2;
    }
    std::array<T, 2> locate(const TripleOf<T>& r, const T&, Chart axis) const {
      const auto [e1, e2] = frame_of(normal, axis);
      return {dot(e1, r), dot(e2, r)};
    }
    Chart chart_at(const TripleOf<double>&) const { return axis_of(normal); }
  };

  static double leverage(const PlaneCoordinates& planes, double t, double size) {
    return KindOf<Planes>::leverage(planes, t, size);
  }
};

}  // namespace tanor
