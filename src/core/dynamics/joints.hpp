#pragma once

#include <span>
#include <vector>

#include "base/block3.hpp"
#include "base/memory.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/scales.hpp"
#include "evaluate/family.hpp"

namespace tanor::detail {

/// Groups of moving points that constraints and springs join; supports join nothing. The rounding of a force on one
/// point of a group affects all of its points. The groups have tolerances that allow for rounding; see
/// motion/rounding.hpp.
class Joints {
 public:
  Joints(std::span<const Incidence> incidences, std::span<const Coupling> couplings, std::size_t num_moving);

  std::size_t num_groups() const { return num_groups_; }
  /// See Mechanics.
  void largest_differences(const double* a, const double* b, std::span<double> largest) const;
  double allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target,
                        const Scales& scales);
  /// Returns true if the last `allow_rounding` found rounding that matters. `error_ratios` then allows for it.
  bool allows_rounding() const { return allows_rounding_; }
  ErrorRatios error_ratios(const StepErrors& errors, double atol, double rtol, const Scales& scales) const;
  void exchange_allowance(Memory& memory) { memory.exchange(allows_rounding_, allowed_x_, allowed_v_); }

 private:
  std::size_t num_groups_ = 0;
  std::vector<Index> group_;        // [moving point]
  std::vector<std::size_t> first_;  // [group] its first point
  bool allows_rounding_ = false;
  std::vector<double> allowed_x_, allowed_v_;  // m, m/s, of each group
  std::vector<double> speed_, size_;           // largest |v| and |x| of each group; scratch
  std::vector<double> atol_;                   // m/s, of each group; scratch
};

}  // namespace tanor::detail
