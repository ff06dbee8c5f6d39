#pragma once

#include <vector>

#include "dynamics/workspace.hpp"
#include "friction/laws.hpp"

namespace tanor {

/// What changes of friction are measured by: the largest friction of their own neighbourhood, so that a heavy part of a
/// scene does not hide a light one. The neighbourhoods that have contacts are numbered as *groups*.
class FrictionScales {
 public:
  FrictionScales(const Workspace& work, const FrictionLaws& laws);

  /// Where friction vanishes it is measured by the forces around it: `accelerations` [neighbourhood], m/s^2.
  void set_accelerations(const std::vector<double>& accelerations);

  bool are_several() const { return neighbourhoods_.size() > 1; }
  const std::vector<Index>& group_of_part() const { return group_of_part_; }
  /// Least force that counts in each group, N.
  const std::vector<double>& least() const { return least_; }

  /// |x - before| over the largest friction, of the worst group; both [parts].
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

/// Largest |x_i| and |a_i - b_i|; a NaN wins.
double largest_of(const std::vector<double>& x);
double largest_difference(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace tanor
