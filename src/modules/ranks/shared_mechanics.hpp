#pragma once

#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/equations_of_motion.hpp"
#include "ranks/agreement.hpp"

namespace tanor::detail {

/// Equations of motion of which every rank has a part. A function gives the part's own answer, and what all parts say
/// together where a number or an outcome decides about a step, so that every rank makes the same steps. If no equation
/// reaches from rank to rank, ranks tell each other nothing else.
///
/// A role exists if some rank has it (series, projections of steps, rounding and implicit equations: if all have). A
/// rank without it gives an answer that changes nothing. The numbers of some roles are a rank's own, and who asks for
/// them agrees on them (see roles.hpp).
class SharedMechanics final : public EquationsOfMotion {
 public:
  /// `own` outlives it.
  SharedMechanics(OwnEquations& own, Ranks& ranks);
  ~SharedMechanics() override;

  std::size_t size() const override { return own_.size(); }
  bool keeps_variables() const override { return keeps_variables_; }
  bool has_work() const override { return has_work_; }
  const Parallel& parallel() const override { return own_.parallel(); }
  PointTolerances point_tolerances() const override { return own_.point_tolerances(); }
  double largest(double own) override { return agreement_.largest(own); }
  double sum(double own) override { return agreement_.sum(own); }
  std::string first_text(std::string own) override { return agreement_.first_text(std::move(own)); }

  /// Not collective. What it throws is thrown on all ranks by the next call that finds accelerations or projects.
  void prescribe(double t, double* x, double* v) override;
  Outcome linearise(double t, const double* x) override;
  double reciprocal_condition() const override { return reciprocal_condition_; }
  std::size_t rank() const override { return rank_; }
  Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) override;
  Reactions no_reactions() const override { return own_.no_reactions(); }
  ProjectionReport project_positions(double t, double* x, Turn turn) override;
  ProjectionReport project_velocities(double t, const double* x, double* v) override;
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  void exchange_memory(Memory& memory) override { own_.exchange_memory(memory); }

  Roles roles() override { return roles_; }
  SeriesExpansion* series(std::string* why_not) override;

  StartReport start(double t, double* r, double* v, StartMode mode) override {
    return conclude_start([&] { return own_.start(t, r, v, mode); });
  }
  /// Returns what all ranks say together of a start that each of them makes on its own.
  StartReport conclude_start(const std::function<StartReport()>& start);
  Outcome set_state(double t, const double* r, const double* v, double* x, double* x_dot) override;
  void write_points(const Kinematics& at, const double* x_ddot, const Reactions& found, double* r, double* v,
                    double* w) override {
    own_.write_points(at, x_ddot, found, r, v, w);
  }
  Outcome begin(double t, const double* x, double* x_dot, const Request& request,
                const AccelerationOutput& to) override;
  void fetch_guests(double* r, double* v) override { own_.fetch_guests(r, v); }
  Energy energy(double t, const double* x, const double* v) override;
  double potential(double t, const double* r) override { return agreement_.sum(own_.potential(t, r)); }

 private:
  class Projector;
  class Series;
  class Drives;
  class Events;
  class Implicit;

  /// Agrees on the outcome of work(), and on what `prescribe` has thrown. Collective.
  template <class Work>
  Outcome together(const Work& work, std::span<double> numbers = {});
  /// Runs work() -> Outcome, which may linearise, and returns what all ranks say of it.
  template <class Work>
  Outcome conclude(const Work& work, const AccelerationOutput& to = nullptr);
  /// Does the same for work() -> ProjectionReport.
  template <class Work>
  ProjectionReport conclude_projection(const Work& work);
  template <class Work>
  Outcome conclude_with(const Work& work, std::span<double> numbers);

  OwnEquations& own_;
  Ranks& ranks_;
  Agreement agreement_;
  bool keeps_variables_, has_work_, is_settled_first_;
  std::exception_ptr failure_;         // of `prescribe` since the ranks last agreed; none if null
  double reciprocal_condition_ = 1.0;  // state after the last linearisation
  std::size_t own_rank_ = 0, rank_ = 0;
  std::unique_ptr<Projector> projector_;
  Roles roles_;
  struct {
    RankMonitor monitor;
    UnseenForces features;
  } none_;  // roles of a rank without them
  std::unique_ptr<Series> series_;
  std::unique_ptr<Drives> drives_;
  std::unique_ptr<Events> events_;
  std::unique_ptr<Implicit> implicit_;
  std::optional<std::string> why_no_series_;  // of the first rank that has none, once the ranks have looked
};

/// Returns the powers of all ranks together.
Power sum_powers(Ranks& ranks, const Power& own);

}  // namespace tanor::detail
