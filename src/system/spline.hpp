#pragma once

#include <array>
#include <span>
#include <vector>

#include <tanor/jet.hpp>

namespace tanor {

/// C4 interpolation of samples: a spline of degree 5, so that accelerations are as smooth as a trajectory needs.
///
/// Not-a-knot ends: one polynomial spans the first three intervals and one the last three; polynomials up to degree 5
/// are reproduced. Up to six samples it is the polynomial through them. Error on a smooth function at distance h of
/// the samples: O(h^6), of the second derivative O(h^4).
class Spline {
 public:
  /// `times` strictly increasing, at least 2, all numbers finite; InputError otherwise.
  Spline(std::vector<double> times, const std::vector<double>& values);

  /// Value and two derivatives at t; outside the samples (by more than a rounding of t) InputError.
  Jet<2> evaluate(double t) const;
  /// Taylor coefficients 0 … of the piece at t.
  void expand(double t, std::span<double> coefficients) const;
  /// Where the piece at t ends; infinite for the last one.
  double next_knot(double t) const;
  /// Appends the times between begin and end at which two pieces meet.
  void append_knots(double begin, double end, std::vector<double>* knots) const;
  double first_time() const { return first_time_; }
  double last_time() const { return last_time_; }

 private:
  /// Value = sum of coefficients[k] (t - start)^k.
  struct Piece {
    double start;
    std::array<double, 6> coefficients;
  };

  const Piece& find_piece(double t) const;

  double first_time_, last_time_;
  std::vector<Piece> pieces_;
};

}  // namespace tanor
