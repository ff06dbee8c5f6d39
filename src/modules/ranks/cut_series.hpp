#pragma once

#include <span>
#include <string>

#include "dynamics/motion_series.hpp"
#include "dynamics/roles.hpp"
#include "ranks/cut_energies.hpp"
#include "ranks/cut_linearization.hpp"
#include "ranks/shared_neighbourhoods.hpp"

namespace tanor::detail {

/// The motion as a power series in time, where constraints and forces reach from rank to rank. Every order is one solve
/// with the factor that spans the ranks, after which that order's coefficients of the guests are fetched.
class CutSeries final : public SeriesExpansion, private SeriesFactor {
 public:
  /// All arguments outlive it.
  CutSeries(Workspace& work, CutLinearization& linearization, CutEnergies& energies,
            const SharedNeighbourhoods& neighbourhoods)
      : work_(work),
        model_(work.model()),
        linearization_(linearization),
        energies_(energies),
        neighbourhoods_(neighbourhoods),
        series_(work) {}

  const std::string& obstacle() const { return series_.obstacle(); }

  Outcome expand(const Kinematics& at, const double* w, const Reactions& found, const SeriesDemand& wanted,
                 std::span<double* const> coefficients, SeriesExtent* extent) override;
  bool has_cheap_terms() const override { return false; }
  bool leaves_out_terms() const override { return false; }
  Power power_along(const Kinematics& at, int terms) override { return energies_.power_along(at, terms, series_); }
  std::span<const Index> neighbourhoods() const override { return work_.scales.of_all_points(); }
  void find_largest(std::span<double> of_neighbourhoods) override { neighbourhoods_.find_largest(of_neighbourhoods); }

 private:
  void complete(double* points) override { linearization_.guests().fetch(points); }
  void apply_transposed(const double* points, const double* shift, double* rows) override;
  void correct(double* rows, double* points) override { linearization_.correct(rows, points); }

  Workspace& work_;
  const Model& model_;
  CutLinearization& linearization_;
  CutEnergies& energies_;
  const SharedNeighbourhoods& neighbourhoods_;
  MotionSeries series_;
};

}  // namespace tanor::detail
