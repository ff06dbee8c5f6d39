#pragma once

#include <memory>
#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/point_form.hpp"
#include "ranks/agreement.hpp"
#include "ranks/cut_linearization.hpp"
#include "ranks/cut_projector.hpp"

namespace tanor {

/// The equations of motion in normal form of a rank's part, where constraints reach from rank to rank: ideal
/// constraints, each independent of the others. What a rank writes of its own points it writes of its guests, too.
///
/// Guests are supports here, for which motion is prescribed by their owners: positions and velocities come where a
/// projection moved them, accelerations where these were found. In between a step does the same arithmetic to both.
class CutForm final : public PointForm {
 public:
  CutForm(Workspace& work, const SolverOptions& options, const Part& part);

  bool has_work() const override { return is_rheonomic_ || work_.forces.has_work(); }
  Outcome linearise(double t, const double* r) override { return linearization_.update(t, r); }
  double reciprocal_condition() const override { return linearization_.reciprocal_condition(); }
  Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) override;
  Reactions no_reactions() const override;
  ProjectionReport project_positions(double t, double* r, Turn) override { return projector_.project_positions(t, r); }
  ProjectionReport project_velocities(double t, const double* r, double* v) override {
    return projector_.project_velocities(t, r, v);
  }
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  void exchange_memory(Memory& memory) override;
  Energy energy(double t, const double* r, const double* v) override;

  Roles roles() override;
  SeriesExpansion* series() override { return nullptr; }
  std::string why_no_series() const override { return "islands lie on several ranks"; }

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport project_point_positions(double t, double* r) override;
  ProjectionReport project_point_velocities(double t, const double* r, double* v) override;
  Outcome begin(double, const double*, double*, const Request& request, const AccelerationOutput& to) override;
  void recentre(double, double*, double*, double*, Reactions*) override {}
  void resume(const Counters& counters, const PhaseTimes& times) override;
  void write_reactions(const Kinematics&, const Reactions& found, double* eta) override;
  void write_friction(const Reactions& found, double* tau) const override;
  void describe(PlanSummary* plan) const override;
  void fetch_guests(double* r, double* v) override;

 private:
  /// A rank of K that is lost ends the motion with an outcome: nothing is watched.
  class LastingRank final : public RankMonitor {
   public:
    explicit LastingRank(double mass_ratio) : mass_ratio_(mass_ratio) {}
    double mass_ratio() const override { return mass_ratio_; }
    void remember_gradients() override {}
    double compare_gradients() override { return 1.0; }

   private:
    double mass_ratio_;
  };

  Index shared_of(Index point) const { return part_.shared_neighbourhood[static_cast<std::size_t>(point)]; }
  void measure_neighbourhoods();
  void share_speeds();
  void check_start(const double* r, const double* v);
  Power find_power(const Kinematics& at);
  void clear_guests(double* points) const;
  int refine(const double* b, double scale, double good_enough, double* residual);

  Part part_;
  std::unique_ptr<Forces> counted_elsewhere_;  // whose energies other ranks count; null: none
  CutLinearization linearization_;
  Agreement& agreement_;
  CutProjector projector_;
  bool is_rheonomic_;
  LastingRank rank_;
  std::vector<double> lambda_, b_, rows_;  // [d]
  std::vector<double> dw_;                 // [3n]
  std::vector<double> own_x_, own_v_;      // [3n] errors or velocities, guests left out
};

}  // namespace tanor
