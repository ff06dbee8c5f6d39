#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dynamics/linearization.hpp"
#include "dynamics/motion_series.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"
#include "plan/thresholds.hpp"
#include "schur/lane_series.hpp"

namespace tanor::detail {

/// The motion of points as a power series in time: coefficient k + 2 of r from S lambda_k = -b_k, with the one factor
/// of S at the beginning (see MotionSeries, or LaneSeries for the islands that it serves).
class MultiplierSeries final : public SeriesExpansion, private SeriesFactor {
 public:
  MultiplierSeries(Workspace& work, Linearization& linearization);

  /// Returns the reason why the system has no series, or an empty string if it has one.
  std::string obstacle() const { return others_ == nullptr ? std::string{} : others_->obstacle(); }

  Outcome expand(const Kinematics& at, const double* w, const Reactions& found, const SeriesDemand& wanted,
                 std::span<double* const> coefficients, SeriesExtent* extent) override;
  bool has_cheap_terms() const override {
    return work_.team().is_alone() && lanes_.share_left() <= plan::most_left_of_cheap_terms;
  }
  bool leaves_out_terms() const override {
    return has_cheap_terms() && lanes_.num_parts() >= plan::groups_that_differ;
  }
  Power power_along(const Kinematics& at, int terms) override;
  std::span<const Index> neighbourhoods() const override { return work_.scales.of_points(); }
  void find_largest(std::span<double> of_neighbourhoods) override { work_.team().find_largest(of_neighbourhoods); }

 private:
  bool may_use_lanes() const;
  void clear_other_points(std::span<double* const> coefficients, std::span<std::uint8_t> last_term) const;
  void apply_transposed(const double* points, const double* shift, double* rows) override;
  void correct(double* rows, double* points) override;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  LaneSeries lanes_;
  std::unique_ptr<MotionSeries> others_;  // of what the lanes do not serve; null if there is nothing
  std::unique_ptr<MotionSeries> whole_;   // of all, for places where S is singular; null until it is needed
  MotionSeries* last_ = nullptr;          // that of the last series; null if all was in lanes
  bool was_in_lanes_ = false;             // some of the last series was in lanes
  Constraints::Selection rest_;           // members of the other islands, if there are both
  std::vector<double> points_;            // [3n] scratch
};

}  // namespace tanor::detail
