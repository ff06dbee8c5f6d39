#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "dynamics/corner_functions.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Ends steps before corners of guides and carries the motion across them.
///
/// No scheme evaluates anything beyond a corner. Along the parabola x + s v + s^2/2 a from the state, the terms of
/// formulas tell when a corner is met. A step ends a thousandth of the way before that, the next ones likewise. Where
/// so little of the way is left that the parabola is exact to rounding, the motion follows it to the corner, and goes
/// on from the other side of it with the velocity that the mechanics finds.
class Corners {
 public:
  Corners(const IntegrationOptions& options, Mechanics& mechanics);

  /// Returns true if the mechanics has no corners.
  bool empty() const { return functions_ == nullptr; }
  /// Returns true if `shorten` has to know the acceleration of the state; `cross` always has to.
  bool follow_motion() const { return !empty() && functions_->num_terms() > 0; }
  /// Finds how much of a step of length h from the state may be made: h, less if it leads to a corner, or 0 if the
  /// corner is so near that `cross` is to be called.
  Outcome shorten(const State& from, double h, double* clear);
  /// Returns true if the last `shorten` found a corner. The step before it tells nothing about the steps after it.
  bool is_ahead() const { return is_ahead_; }
  /// Returns true if a step from one state to the other has passed a corner.
  bool have_passed(Scheme& scheme, const State& from, const State& to);
  /// Carries `from` across the corner that `shorten` found right ahead in a step to `t_end`, to `to`, no later than
  /// that.
  StepResult cross(const State& from, double t_end, State* to);
  /// Names a corner that is less than `within` ahead, s; empty if there is none.
  std::string name_next(const State& from, double within);

 private:
  /// A place on the parabola, `s` after the state.
  struct Place {
    double s = 0.0, t = 0.0;
  };
  /// The last place before a corner and the first one after it; the same place twice where the argument of a term only
  /// touches 0.
  struct Corner {
    bool is_found = false;
    Place before, after;
    std::size_t touched = no_term;
  };
  static constexpr std::size_t no_term = static_cast<std::size_t>(-1);

  void go_along(const State& from, const Place& place);
  void evaluate_along(const State& from, const Place& place, std::vector<double>* arguments);
  void go_back(const State& from);
  Corner find(const State& from, double h);
  Corner find_behind(const State& from, double h);
  Corner find_on_path(const State& from, double h);
  Corner narrow(const State& from, Place low, Place high);
  Corner find_touch(const State& from, double length);
  Corner check_speed(const State& from, double length, Corner corner);
  void measure_tolerance(const State& from);
  bool may_hide() const;
  double reach_by_rate(const State& from, const Corner& corner);
  Outcome check_progress(double t, double h);
  StepResult cross_at(const State& from, const Corner& corner, double t_end, State* to);
  void widen(const State& from, double h, Corner* corner);
  void put_on_guides(const Corner& corner);
  bool have_moved(const State& to, double travelled) const;
  std::string name_passed() const;
  Outcome refuse(const Corner& corner, const std::string& why) const;
  Outcome check_settled(const State& from, const Corner& corner, double t_end, const State& to);
  Outcome check_bend(const Corner& corner, double h, State* to);
  StepResult arrive(const State& from, const Corner& corner, double t_end, State* to);
  bool differ(const std::vector<double>& one, const std::vector<double>& other) const;

  IntegrationOptions options_;
  Mechanics& mechanics_;
  CornerFunctions* const functions_;          // null if there are no corners
  std::vector<double> x_, v_;                 // a state inside the step
  std::vector<double> start_, here_, other_;  // [term] arguments
  std::vector<double> tolerances_;            // [term] of arguments
  std::vector<std::vector<double>> samples_;  // [sample][term] along the parabola
  std::vector<double> instants_;
  bool is_ahead_ = false;
  double series_begin_ = 0.0;  // s; of crossings without progress, …
  std::size_t repeated_ = 0;   // … and their number
};

}  // namespace tanor::detail
