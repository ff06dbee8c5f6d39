#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <tanor/kinds/chart.hpp>

namespace tanor {

/// A chain of rods on a support. Each link has the two numbers of its direction in a stereographic chart or, in a given
/// plane with unit normal n, its angle, rad, from e1 = n x a (to unit length) towards n x e1, where a is the coordinate
/// axis that n is farthest from.
struct ChainAngles {
  std::string name{};
  std::vector<Index> points{};  ///< along the chain, from the anchor on
  Index anchor = 0;             ///< a support
  Parameter length{};           ///< m, > 0, one for each link
  Vector3 normal{};             ///< normal of the plane; 0 for directions in space
};

template <>
struct KindOf<ChainAngles> {
  static constexpr std::string_view name = "chain_angles";
  static constexpr auto members = &ChainAngles::points;
  static constexpr std::tuple fields{
      FieldOf("anchor", &ChainAngles::anchor, {.is_required = true}),
      FieldOf("length", &ChainAngles::length, {.unit = "m", .range = ValueRange::positive}),
      FieldOf("normal", &ChainAngles::normal)};

  /// The direction of a link whose two numbers are 0, of unit length.
  using Chart = Vector3;

  template <class T>
  struct Definition {
    Vector3 normal;

    template <class Now>
    Definition(const ChainAngles& given, const Now&) : normal(given.normal) {}

    /// Returns the outer end of a link from its inner end. `q` are the two numbers of the link, or its angle in a
    /// plane.
    TripleOf<T> place(const TripleOf<T>& inner_end, const T& length, const T* q, const Chart& chart) const {
      using std::cos, std::sin;
      if (normal == Vector3{}) return inner_end + length * direction_around(chart, q[0], q[1]);
      const TripleOf<double> n = triple_of<double>(normal) / norm(triple_of<double>(normal));
      const auto [e1, e2] = frame_around<T>({n.x, n.y, n.z});
      return inner_end + length * (cos(q[0]) * e1 + sin(q[0]) * e2);
    }
  };

  /// Returns the points that the coordinates tie to one another.
  static std::vector<Index> tied_points(const ChainAngles& chain) {
    std::vector<Index> points = chain.points;
    points.push_back(chain.anchor);
    return points;
  }
  static std::size_t num_coordinates(const ChainAngles& group) {
    return (group.normal == Vector3{} ? 2 : 1) * group.points.size();
  }
};

}  // namespace tanor
