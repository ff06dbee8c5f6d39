#pragma once

#include <cmath>
#include <vector>

#include <tanor/system.hpp>

#include "dynamics/roles.hpp"

namespace tanor {

/// What a function of time gives a motion: accelerations, velocities or positions.
enum class DriveLevel { Acceleration, Velocity, Position };

/// The instants of a step at which functions of time are looked at: the Chebyshev points, between which a step of order
/// p follows an acceleration as a polynomial does, then samples between them. And what such a polynomial misses at the
/// samples,
///
///   e = g - (the polynomial of degree p through g at the p + 1 Chebyshev points of the step);
///
/// for given velocities and positions it has one degree or two more.
class DriveSamples {
 public:
  /// Instants that an advance of one step looks at: room for so many is enough in nearly all cases.
  static constexpr std::size_t most_of_a_step = 4096 + 128;
  /// Takes the memory that steps will need.
  void reserve();

  /// Places the instants of a step, with samples in each piece between the knots of a function; null: it has none.
  void place(const DrivenStep& step, DriveLevel level, const ScalarFunction* function);
  /// All instants, s: those of the polynomial first.
  const std::vector<double>& times() const { return times_; }

  /// Of x and v; and how far the function moves them.
  struct Misses {
    double x = 0.0, v = 0.0, x_done = 0.0, v_done = 0.0;
  };
  /// What is told of a function, whose `values` [times] are given.
  struct Found {
    double range = 0.0, largest = 0.0;  ///< of the values
    Misses missed{};                    ///< what the step misses of x and v, where they vary

    bool varies() const { return range > 0.0 && std::isfinite(range); }
  };
  Found look(const DrivenStep& step, DriveLevel level, const double* values);
  /// Pieces between which straight lines follow it to a hundredth of what varies.
  int count_pieces(DriveLevel level, const double* values, const Found& found) const;

 private:
  void find_times(const DrivenStep& step);
  void deviate(const double* values);
  void deviate_by_weights(const double* values);
  void choose_weights();
  void silence_rounding(const DrivenStep& step, const double* samples, double largest);
  Misses measure_misses(const DrivenStep& step, DriveLevel level, const double* samples, double range) const;

  std::size_t num_nodes_ = 0, num_samples_ = 0;
  bool has_equal_pieces_ = false;
  std::vector<double> fractions_;                                // of the step: the Chebyshev points, then the samples
  std::vector<double> widths_;                                   // of the samples' pieces, likewise
  std::vector<double> times_, knots_;                            // s
  std::vector<double> cosines_, chebyshev_, next_, after_next_;  // for polynomials at all samples
  std::vector<double> missed_;                                   // e at the samples
  // Where as many samples as nodes lie evenly, p at each sample from the values at the nodes: of each number of nodes
  // [sample][node]; and those of this look, or null.
  std::vector<std::vector<double>> all_weights_;
  const std::vector<double>* weights_ = nullptr;
};

}  // namespace tanor
