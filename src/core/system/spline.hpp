#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <tanor/jet.hpp>

namespace tanor::detail {

/// C4 interpolation of samples by a spline of degree 5, so that accelerations are as smooth as a trajectory needs.
///
/// Its ends are not-a-knot: one polynomial spans the first three intervals and one the last three, so polynomials up to
/// degree 5 are reproduced. Up to six samples give the polynomial through them. The error on a smooth function at
/// distance h of the samples is O(h^6), that of the second derivative O(h^4).
class Spline {
 public:
  /// Interpolates. `times` are strictly increasing, at least 2, and all numbers are finite; otherwise throws
  /// InputError.
  Spline(std::vector<double> times, const std::vector<double>& values);

  /// Returns the value and two derivatives at t. Throws InputError outside the samples (by more than a rounding of t).
  Jet<2> evaluate(double t) const;
  /// Writes the Taylor coefficients 0 … of the piece at t.
  void expand(double t, std::span<double> coefficients) const;
  /// Returns where the piece at t ends; infinite for the last one.
  double next_knot(double t) const;
  /// Appends the times between begin and end at which two pieces meet.
  void append_knots(double begin, double end, std::vector<double>* knots) const;
  /// Returns c with value = c0 + c1 (t - first_time) + c2 (t - first_time)^2 if that holds, to rounding, for all t.
  std::optional<std::array<double, 3>> find_parabola() const;
  double first_time() const { return first_time_; }
  double last_time() const { return last_time_; }

 private:
  /// A polynomial: value = sum of coefficients[k] (t - start)^k.
  struct Piece {
    double start;
    std::array<double, 6> coefficients;
  };

  const Piece& find_piece(double t) const;

  double first_time_, last_time_;
  std::vector<Piece> pieces_;
};

}  // namespace tanor::detail
