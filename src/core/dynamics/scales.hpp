#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "base/memory.hpp"
#include "evaluate/family.hpp"
#include "system/neighbourhoods.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The scales of length and speed of each neighbourhood (see Neighbourhoods), in the inner order. Rows that join
/// supports alone count as a neighbourhood of their own, the last one.
class Scales {
 public:
  Scales(const Neighbourhoods& neighbourhoods, const Numbering& numbering, std::span<const Incidence> incidences,
         double scene_size);

  std::size_t size() const { return length_.size(); }
  /// Returns true if one neighbourhood holds all moving points.
  bool are_one() const { return are_all_ && size() <= 2; }
  std::size_t of_point(std::size_t moving_point) const { return static_cast<std::size_t>(of_point_[moving_point]); }
  /// The neighbourhoods of all points; supports have the last one. Empty if one neighbourhood holds all.
  std::span<const Index> of_points() const { return are_one() ? std::span<const Index>() : of_all_points_; }
  std::span<const Index> of_all_points() const { return of_all_points_; }
  std::size_t of_row(std::size_t row) const { return static_cast<std::size_t>(of_row_[row]); }

  bool has_rows(std::size_t k) const { return has_rows_[k] != 0; }

  double length(std::size_t k) const { return length_[k]; }  ///< m
  double speed(std::size_t k) const { return speed_[k]; }    ///< m/s
  const std::vector<double>& lengths() const { return length_; }
  const std::vector<double>& speeds() const { return speed_; }
  /// Sets the speeds. A neighbourhood in which nothing moves or would fall has the speed 1 m/s.
  void set_speeds(std::span<const double> speeds);
  /// Exchanges the speeds.
  void exchange_memory(Memory& memory);

  /// The least speed V, and the least V^2/L, of neighbourhoods that have rows.
  double least_speed() const { return least_speed_; }
  double least_acceleration() const { return least_acceleration_; }
  /// Sets those of all processes, once the speeds are set.
  void set_least(double speed, double acceleration) {
    least_speed_ = speed;
    least_acceleration_ = acceleration;
  }
  /// Notes that other processes have neighbourhoods, too.
  void stand_beside_others() { are_all_ = false; }

  /// The tolerances if no absolute tolerance is given: 1e-10 of the length and of the speed around a point, m and m/s,
  /// of all points, supports last.
  std::span<const double> position_tolerances() const { return position_tolerance_; }
  std::span<const double> velocity_tolerances() const { return velocity_tolerance_; }
  /// V^2/L around each point, m/s^2. Since V is at least sqrt(a L), it is no less than the accelerations there.
  std::span<const double> accelerations() const { return acceleration_; }
  /// Such a part of these tolerances, 1e-15 of the scales, is rounding, and no step meets less.
  static constexpr double rounding = 1e-5;
  /// Returns the tolerance of a point, or `atol` if it is given and above rounding.
  double position_tolerance(double atol, std::size_t point) const { return choose(atol, position_tolerance_[point]); }
  double velocity_tolerance(double atol, std::size_t point) const { return choose(atol, velocity_tolerance_[point]); }
  static double choose(double atol, double own) { return atol > 0.0 ? std::max(atol, rounding * own) : own; }

 private:
  void derive_from_speeds();

  std::size_t num_points_;
  std::vector<Index> of_point_, of_all_points_, of_row_;
  std::vector<double> length_, speed_;
  std::vector<char> has_rows_;
  bool are_all_ = true;  // no other process has neighbourhoods
  double least_speed_ = 1.0, least_acceleration_ = 1.0;
  std::vector<double> position_tolerance_, velocity_tolerance_, acceleration_;
};

}  // namespace tanor::detail
