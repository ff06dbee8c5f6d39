#pragma once

#include <vector>

#include "dynamics/workspace.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// The scales of changes of friction. Each change is measured by the largest friction of its own neighbourhood, so that
/// a heavy part of a scene does not hide a light one. The neighbourhoods that have contacts are numbered as *groups*.
class FrictionScales {
 public:
  FrictionScales(const Workspace& work, const FrictionLaws& laws);

  /// Sets the forces that measure friction where it vanishes, from the `accelerations` [neighbourhood] around it,
  /// m/s^2.
  void set_accelerations(const std::vector<double>& accelerations);

  bool are_several() const { return neighbourhoods_.size() > 1; }
  const std::vector<Index>& group_of_part() const { return group_of_part_; }
  /// The smallest force that counts in each group, N.
  const std::vector<double>& least() const { return least_; }

  /// Returns |x - before| over the largest friction, of the worst group; both are [parts].
  double relative_change(const std::vector<double>& x, const std::vector<double>& before);

 private:
  const Workspace& work_;
  const Model& model_;
  const FrictionLaws& laws_;
  std::vector<Index> group_of_part_;
  std::vector<std::size_t> neighbourhoods_;       // [group]
  std::vector<double> least_;                     // [group] N
  std::vector<double> largest_, largest_change_;  // [group] N, scratch
};

/// Return the largest |x_i| or |a_i - b_i|, or NaN if there is any.
double largest_of(const std::vector<double>& x);
double largest_difference(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace tanor::detail
