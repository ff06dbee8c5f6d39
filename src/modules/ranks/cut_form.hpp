#pragma once

#include <memory>
#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/point_form.hpp"
#include "ranks/agreement.hpp"
#include "ranks/cut_energies.hpp"
#include "ranks/cut_linearization.hpp"
#include "ranks/cut_projector.hpp"
#include "ranks/cut_series.hpp"
#include "ranks/halo_pairs.hpp"
#include "ranks/shared_neighbourhoods.hpp"

namespace tanor::detail {

/// The equations of motion in normal form of a rank's part, where ideal constraints or forces reach from rank to rank.
/// A rank writes for its guests, too, whatever it writes for its own points.
///
/// Guests are supports here, whose motion their owners prescribe. Their positions and velocities are fetched after a
/// projection has moved them, their accelerations after these were found. In between a step does the same arithmetic to
/// both.
class CutForm final : public PointForm {
 public:
  CutForm(Workspace& work, const SolverOptions& options, const Part& part);

  bool has_work() const override { return energies_.has_work(); }
  void prescribe(double t, double* r, double* v) override;
  bool is_prescribed_together() const override { return depends_on_time_; }
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
  Energy energy(double t, const double* r, const double* v) override { return energies_.energy(t, r, v); }
  double potential(double t, const double* r) override { return energies_.potential(t, r); }

  Roles roles() override;
  SeriesExpansion* series(std::string* why_not) override;

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport project_point_positions(double t, double* r) override;
  ProjectionReport project_point_velocities(double t, const double* r, double* v) override;
  Outcome begin(double, const double*, double*, const Request& request, const AccelerationOutput& to) override;
  void recentre(double, double*, double*, double*, Reactions*) override {}
  void resume(const Counters& counters, const PhaseTimes& times) override;
  void write_reactions(const Kinematics&, const Reactions& found, double* eta) override;
  void minimize_multipliers(const Kinematics& at, double* lambda) override;
  void write_friction(const Reactions& found, double* tau) const override;
  void describe(PlanSummary* plan) const override;
  void fetch_guests(double* r, double* v) override;

 private:
  /// Watches nothing, since losing a rank of K ends the motion with an outcome.
  class LastingRank final : public RankMonitor {
   public:
    explicit LastingRank(double mass_ratio) : mass_ratio_(mass_ratio) {}
    double mass_ratio() const override { return mass_ratio_; }
    void remember_gradients() override {}
    double compare_gradients() override { return 1.0; }

   private:
    double mass_ratio_;
  };

  void check_start(const double* r, const double* v);
  Outcome refuse_prestress(const Kinematics& at);
  int refine(const double* b, double scale, bool is_exact, double* residual);
  Outcome solve(const Kinematics& at, const Request& request, double scale, SolveReport* report);

  Part part_;
  CutLinearization linearization_;
  Agreement& agreement_;
  bool depends_on_time_;  // on some rank
  CutProjector projector_;
  CutEnergies energies_;
  SharedNeighbourhoods neighbourhoods_;
  std::unique_ptr<CutSeries> series_;  // null until somebody asks
  LastingRank rank_;
  std::vector<double> lambda_, b_, rows_;  // [d]
  std::vector<double> dw_;                 // [3n]
  std::vector<double> own_x_, own_v_;      // [3n] errors, without those of guests
};

}  // namespace tanor::detail
