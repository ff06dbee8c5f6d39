#pragma once

#include <exception>
#include <functional>
#include <optional>
#include <string>

#include "dynamics/mechanics.hpp"

namespace tanor::detail {

/// The inverse problem (forward dynamics) in one of its forms, in the inner order of points and rows. A form steps in
/// its own variables x (positions, or generalized coordinates); r, v, w, eta are always 3n, point by point.
///
/// Each process has a form of its part. What ends in `_here` is of this process.
class EquationsOfMotion : public Mechanics {
 public:
  /// Joins the forms that other processes have of their parts. Collective.
  void join(Ranks& ranks);

  bool has_work() const final { return is_alone() ? has_work_here() : all_.has_work; }
  double reciprocal_condition() const final {
    return is_alone() ? reciprocal_condition_here() : all_.reciprocal_condition;
  }
  std::size_t rank() const final { return is_alone() ? rank_here() : all_.rank; }
  Roles roles() final { return is_alone() ? roles_here() : all_.roles; }
  SeriesExpansion* series(std::string* why_not) final;
  virtual bool has_work_here() const = 0;
  virtual double reciprocal_condition_here() const = 0;
  virtual std::size_t rank_here() const = 0;
  virtual Roles roles_here() = 0;
  virtual SeriesExpansion* series_here(std::string* why_not) = 0;

  /// Moves r and v to the nearest consistent start in the M-norm, on this process. `StartMode::Check` throws InputError
  /// naming the worst violation.
  virtual StartReport start(double t, double* r, double* v, StartMode mode) = 0;
  /// Returns what all processes say together of a start that each of them makes on its own.
  StartReport start_together(const std::function<StartReport()>& start);
  /// Computes the form's own x and x' of a consistent (r, v), `size()` numbers each.
  virtual Outcome set_state(double t, const double* r, const double* v, double* x, double* x_dot) = 0;
  /// Writes r, v and w of all points from x, x' and x'', and from the reactions that were found with x''.
  virtual void write_points(const Kinematics& at, const double* x_ddot, const Reactions& found, double* r, double* v,
                            double* w) = 0;
  /// Computes accelerations where nothing is known of earlier instants, so that contacts at rest choose whether to
  /// stick or to slide. May change x' of those contacts by rounding.
  virtual Outcome begin(double t, const double* x, double* x_dot, const Request& request,
                        const AccelerationOutput& to) = 0;
  /// Fetches the states of points on other processes that equations of this process need. A null `v` is not fetched.
  virtual void fetch_guests(double* r, double* v) = 0;

  virtual Energy energy(double t, const double* x, const double* v) = 0;
  /// Returns the potential energy with all points at r [3n], J.
  virtual double potential(double t, const double* r) = 0;

  /// Moves r [3n] to the nearest point on the constraints, and v [3n] to the nearest velocity with K'v + xi_t = 0 (K at
  /// an admissible r), in the M-norm.
  virtual ProjectionReport project_point_positions(double t, double* r) = 0;
  virtual ProjectionReport project_point_velocities(double t, const double* r, double* v) = 0;
  /// Chooses the variables that serve best around (x, x'), after an accepted step, where its last accelerations were
  /// found. Transforms x'' and what was found with it as well.
  virtual void recentre(double t, double* x, double* x_dot, double* x_ddot, Reactions* found) = 0;
  /// Continues a motion from elsewhere. Its earlier steps are unknown, and the work counters go on from those given.
  virtual void resume(const Counters& counters, const PhaseTimes& times) = 0;

  /// Writes eta [3n] of the reactions found with accelerations at this state, where K stands. At supports it is the
  /// force of the constraints.
  virtual void write_reactions(const Kinematics& at, const Reactions& found, double* eta) = 0;
  /// Replaces lambda [d] by the multipliers of least norm with the same reactions, where they are not unique at this
  /// state.
  virtual void minimize_multipliers(const Kinematics& at, double* lambda) = 0;
  /// Writes tau [3n] of the contacts that slide and of those that stick.
  virtual void write_friction(const Reactions& found, double* tau) const = 0;

  /// Adds the form's own findings about the system.
  virtual void describe(PlanSummary* plan) const = 0;

 protected:
  /// True if other processes take part in what `together` does, and `prescribe` may throw here alone.
  virtual bool is_prescribed_together() const { return false; }
  /// Does work() that is not collective. What it throws here is thrown on all processes by the next `together`.
  template <class Work>
  void prepare(const Work& work) {
    if (is_alone()) return work();
    try {
      work();
    } catch (...) {
      if (!failure_) failure_ = std::current_exception();
    }
  }
  ErrorRatios largest_of_all(const ErrorRatios& own);
  Energy sum_of_all(const Energy& own);

 private:
  /// Agrees on the linearised configuration as well.
  Outcome agree(const std::function<Outcome()>& work, std::span<double> numbers) override;
  void share_roles();

  struct {
    bool has_work = false;
    double reciprocal_condition = 1.0;
    std::size_t rank = 0, rank_here = 0;  // of K; this process's part of it
    Roles roles;
    std::optional<std::string> why_no_series;  // of the first process that has none, once they have looked
  } all_;                                      // what all processes said last
  struct {
    RankMonitor monitor;
    UnseenForces unseen;
    DriveMonitor drives;
    EventFunctions events;
  } none_;                      // roles of a process without them
  std::exception_ptr failure_;  // of `prepare` since the processes last agreed; none if null
};

}  // namespace tanor::detail
