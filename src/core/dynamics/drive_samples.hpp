#pragma once

#include <cmath>
#include <vector>

#include <tanor/system.hpp>

#include "base/chebyshev.hpp"
#include "dynamics/roles.hpp"

namespace tanor::detail {

/// The quantity of a motion that a function of time prescribes.
enum class DriveLevel { Acceleration, Velocity, Position };

/// The instants of a step at which functions of time are evaluated: the Chebyshev points, then samples between them. A
/// step of order p follows an acceleration as a polynomial through the Chebyshev points does. The error of such a
/// polynomial at the samples is
///
///   e = g - (the polynomial of degree p through g at the p + 1 Chebyshev points of the step).
///
/// For given velocities and positions the polynomial has one degree or two more.
class DriveSamples {
 public:
  /// The number of instants in one step for which memory is reserved; nearly all steps need fewer.
  static constexpr std::size_t most_of_a_step = 4096 + 128;
  /// Reserves the memory that steps will need.
  void reserve();

  /// Places the instants of a step, with samples in each piece between the knots of the function.
  void place(const DrivenStep& step, DriveLevel level, const ScalarFunction& function);
  /// All instants, s; those of the polynomial come first.
  const std::vector<double>& times() const { return times_; }

  /// Errors of x and v, and how far the function moves them.
  struct Misses {
    double x = 0.0, v = 0.0, x_done = 0.0, v_done = 0.0;
  };
  /// The result for a function with the `values` [times].
  struct Found {
    double range = 0.0, largest = 0.0;  ///< of the values
    Misses missed{};                    ///< errors of the step in x and v, where the values vary

    bool varies() const { return range > 0.0 && std::isfinite(range); }
  };
  Found look(const DrivenStep& step, DriveLevel level, const double* values);
  /// Returns the number of pieces between which a polygon follows the function to a hundredth of its variation.
  int count_pieces(DriveLevel level, const double* values, const Found& found) const;

 private:
  void find_times(const DrivenStep& step);
  void silence_rounding(const DrivenStep& step, const double* samples, double largest);
  Misses measure_misses(const DrivenStep& step, DriveLevel level, const double* samples, double range) const;

  std::size_t num_nodes_ = 0, num_samples_ = 0;
  bool has_equal_pieces_ = false;
  ChebyshevPolynomial polynomial_;     // as which the step follows the function
  std::vector<double> fractions_;      // fractions of the step: the Chebyshev points, then the samples
  std::vector<double> widths_;         // widths of the samples' pieces, likewise
  std::vector<double> times_, knots_;  // s
  std::vector<double> missed_;         // e at the samples
};

}  // namespace tanor::detail
