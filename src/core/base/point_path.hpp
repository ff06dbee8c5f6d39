#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "base/vec3.hpp"

namespace tanor::detail {

/// The motion of all points during one step. Positions and velocities are known at knots that lie evenly in time;
/// between two knots each point follows a cubic in time.
class PointPath {
 public:
  virtual ~PointPath() = default;

  struct Place {
    Vec3 r, v;  // m, m/s
  };

  int order = 5;                                     ///< order of the scheme that makes the step
  double t = 0.0, h = 0.0;                           ///< s: the step leads from t to t + h
  double atol = 0.0, rtol = 0.0;                     ///< errors allowed in a point's position and velocity at its end
  std::span<const double> own_atol_r, own_atol_v;    ///< [point] m and m/s, each point's own where atol is 0
  bool follows_tolerance = true;                     ///< false if the length of the step is fixed
  bool ends_at_jumps = true;                         ///< false if the step keeps its length where a force jumps
  std::span<const double> looks;                     ///< fractions of h where forces were evaluated, from 0 to 1
  std::span<const double> weights;                   ///< [look] weights of the scheme there: h sum w_k a(s_k)
  std::vector<const double*> positions, velocities;  ///< [knot] arrays [3n] each; at least two knots
  std::vector<const double*> variables, rates;       ///< [knot] variables of the mechanics: the points' own or others
  std::span<const double> accelerations;             ///< [point] m/s^2, upper bounds; empty if none are known

  /// Where a force jumps first: fractions of the step before and after that, between which its side is known to
  /// rounding alone. They are infinite if none is known to jump.
  struct Jump {
    double before = std::numeric_limits<double>::infinity(), after = before;
    const std::string* force = nullptr;  ///< its name, if this process knows it
    double idle = 0.0;                   ///< s: a motion that it drives back so soon goes no farther than it may miss

    bool exists() const { return after < std::numeric_limits<double>::infinity(); }
    void include(const Jump& other) {
      if (other.after < after) {
        force = other.force;
        idle = other.idle;
      }
      before = std::min(before, other.before);
      after = std::min(after, other.after);
    }
  } jump;
  const std::string* passed = nullptr;  ///< the formula that a step passes over, by its name; null if none is known

  /// Returns the part of the path between two fractions, whose cubics are exact to rounding if they are near to
  /// each other; null if the path cannot be magnified. The next call invalidates it.
  virtual const PointPath* magnify(double /*begin*/, double /*end*/) { return nullptr; }

  /// Adds knots until the cubics miss the motion by no more than `error` times the distance that each number moves.
  virtual void refine(double error) = 0;

  template <class Integer>
  double atol_r(Integer i) const {
    return atol > 0.0 || own_atol_r.empty() ? atol : own_atol_r[static_cast<std::size_t>(i)];
  }
  template <class Integer>
  double atol_v(Integer i) const {
    return atol > 0.0 || own_atol_v.empty() ? atol : own_atol_v[static_cast<std::size_t>(i)];
  }

  template <class Integer>
  double largest_acceleration(Integer i) const {
    return accelerations.empty() ? 0.0 : accelerations[static_cast<std::size_t>(i)];
  }

  std::size_t num_pieces() const { return positions.size() - 1; }
  double knot(std::size_t k) const { return static_cast<double>(k) / static_cast<double>(num_pieces()); }

  /// Returns the position and velocity of point i at the fraction s of the step.
  template <class Integer>
  Place at(Integer i, double s) const {
    const std::size_t pieces = num_pieces();
    const double scaled = s * static_cast<double>(pieces);
    const std::size_t k = std::min(static_cast<std::size_t>(scaled), pieces - 1);
    return cubic(i, k, scaled - static_cast<double>(k));
  }

  struct Number {
    double x, rate;
  };
  /// Returns one coordinate of all positions, or one of the mechanics' variables, at the fraction s of the step, by the
  /// formula of `cubic`. The rate is a line between the knots and what the chord e adds in the middle,
  ///
  ///   x'(u) = (1 - u) v0 + u v1 + 6 u (1 - u) (e/H - (v0 + v1)/2)
  ///
  /// In short pieces the latter is rounding of the ends alone, which would be larger than a rate near 0, and is left
  /// out.
  template <class Integer>
  Number number(Integer i, double s, bool of_mechanics) const {
    constexpr double roundings = 4.0 * std::numeric_limits<double>::epsilon();
    const std::size_t pieces = num_pieces(), at = static_cast<std::size_t>(i);
    const double scaled = s * static_cast<double>(pieces), piece = h / static_cast<double>(pieces);
    const std::size_t k = std::min(static_cast<std::size_t>(scaled), pieces - 1);
    const double u = scaled - static_cast<double>(k), w = 1.0 - u;
    const auto& x = of_mechanics ? variables : positions;
    const auto& v = of_mechanics ? rates : velocities;
    const double x0 = x[k][at], x1 = x[k + 1][at], v0 = v[k][at], v1 = v[k + 1][at];
    const double e = x1 - x0, first = piece * v0 - e, last = piece * v1 - e, bends = -0.5 * (first + last);
    const bool is_rounding = std::abs(bends) <= roundings * (std::abs(x0) + std::abs(x1));
    const double rate = w * v0 + u * v1 + (is_rounding ? 0.0 : 6.0 * u * w * bends / piece);
    return {x0 + u * e + u * w * (w * first - u * last), rate};
  }

  /// Returns the position and velocity of point i in piece k, at the fraction u of the piece. With the length H of the
  /// piece and its chord e = r1 - r0,
  ///
  ///   r = r0 + u e + u (1 - u) ((1 - u) (H v0 - e) - u (H v1 - e)),   v = r'/H
  template <class Integer>
  Place cubic(Integer i, std::size_t k, double u) const {
    const double piece = h / static_cast<double>(num_pieces()), w = 1.0 - u;
    const Vec3 r0 = load(positions[k], i), e = load(positions[k + 1], i) - r0;
    const Vec3 first = piece * load(velocities[k], i) - e, last = piece * load(velocities[k + 1], i) - e;
    const Vec3 rate = e + (w * (1.0 - 3.0 * u)) * first + (u * (1.0 - 3.0 * w)) * last;
    return {r0 + u * e + (u * w) * (w * first - u * last), (1.0 / piece) * rate};
  }
};

/// Returns a bound of the distance of a cubic from its chord. The cubic has the ends a and b and is passed in the time
/// H:
///
///   4/27 (|H v_a - e| + |H v_b - e|),   e = r_b - r_a
inline double sagitta(const PointPath::Place& a, const PointPath::Place& b, double length) {
  const Vec3 e = b.r - a.r;
  return 4.0 / 27.0 * (norm(length * a.v - e) + norm(length * b.v - e));
}

}  // namespace tanor::detail
