#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <tanor/kinds/kind.hpp>
#include <tanor/kinds/line_frame.hpp>

namespace tanor {

/// Points on a wire that winds around an axis d. At the height z along d its angle is 2 pi z/pitch + phase, measured
/// from e1 towards e2, the two unit vectors of the line along d (see Lines). A negative pitch winds the other way; a
/// growing phase turns the wire as a screw.
///
/// The two rows are, with the distance rho from the axis, the angle s from the wire to the point, and q = pitch/(2 pi):
///
///     rho - radius,   2 rho tan(s/2) |q|/sqrt(radius^2 + q^2)
///
/// On the wire their gradients are unit vectors, orthogonal to each other and to the wire.
struct Helices {
  std::string name{};
  std::vector<Index> points{};
  VectorFunction origin{};      ///< m, on the axis
  Vector3 axis{0.0, 0.0, 1.0};  ///< d, of any length but 0
  double radius = 1.0;          ///< m, > 0
  double pitch = 1.0;           ///< m along the axis for one turn, not 0
  Parameter phase{};            ///< rad
};

template <>
struct KindOf<Helices> {
  static constexpr std::string_view name = "helix";
  static constexpr auto members = &Helices::points;
  static constexpr int rows = 2;
  static constexpr auto parameter = &Helices::phase;
  static constexpr std::tuple fields{
      FieldOf("origin", &Helices::origin, {.unit = "m", .role = FieldRole::Place, .is_required = true}),
      FieldOf("axis", &Helices::axis, {.role = FieldRole::Direction, .is_required = true}),
      FieldOf("radius", &Helices::radius, {.unit = "m", .range = ValueRange::positive, .is_required = true}),
      FieldOf("pitch", &Helices::pitch, {.unit = "m", .range = ValueRange::not_zero, .is_required = true}),
      FieldOf("phase", &Helices::phase, {.unit = "rad"})};

  template <class T>
  struct Definition {
    TripleOf<T> origin, d, e1, e2;
    double radius, turns;  ///< rad/m

    template <class Now>
    Definition(const Helices& given, const Now& now)
        : origin(now(given.origin)), radius(given.radius), turns(2.0 * std::numbers::pi / given.pitch) {
      const auto [first, second] = line_frame(given.axis);
      e1 = triple_of<T>(first);
      e2 = triple_of<T>(second);
      d = cross(e1, e2);
    }

    /// Returns the phase of the wire through a point.
    template <class Points>
    T measure(const Points& r, std::size_t) const {
      using std::atan2;
      const TripleOf<T> a = r[0] - origin;
      return atan2(dot(e2, a), dot(e1, a)) - turns * dot(d, a);
    }
    template <class Points>
    std::array<T, 2> xi(const Points& r, const T& phase, std::size_t) const {
      using std::cos, std::sin, std::sqrt;
      const TripleOf<T> a = r[0] - origin;
      const T x = dot(e1, a), y = dot(e2, a), rho = sqrt(x * x + y * y), angle = turns * dot(d, a) + phase;
      const T c = cos(angle), s = sin(angle), along = c * x + s * y, across = c * y - s * x;
      // tan(s/2) = sin s/(1 + cos s)
      const double scale = 2.0 / std::sqrt(1.0 + radius * radius * turns * turns);
      return {rho - T(radius), scale * (rho * across / (rho + along))};
    }
  };

  template <class Points>
  static const char* complaint(const Helices&, const Definition<double>& now, const Points& r, std::size_t) {
    const TripleOf<double> a = r[0] - now.origin;
    return norm(cross(now.d, a)) > 0.0 ? nullptr : "it is on the axis and has no angle there";
  }
  /// Returns the distance that a point moves when the wire turns by 1 rad.
  static double leverage(const Helices& helices, double, double) { return helices.radius; }
};

}  // namespace tanor
