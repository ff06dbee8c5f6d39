#pragma once

#include <string>
#include <vector>

#include "contact/dependent_rows.hpp"
#include "contact/gaps.hpp"
#include "contact/rough_rows.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/unilateral.hpp"

namespace tanor::detail {

/// The one-sided rows of a system: which of them are closed, and how that changes. With friction (RoughRows), which
/// contacts are open, stick or slide is one decision.
///
/// A gap that comes to 0 is an impact by Newton's law, with the S of all rows that touch there and approach:
///
///   M (v+ - v-) = s K P,   0 <= P  _|_  u+ + e u- >= 0      (u: rates of gaps; e = 0 where the gap rests already)
///
/// A force that comes to 0 opens its row. What stays in touch then is closed or open by the accelerations:
///
///   0 <= p  _|_  S_c p + b >= 0
///
/// Both are linear complementarity problems with a symmetric matrix, which is positive definite where rows are
/// independent: one answer, found by an Exchange. Each round of it factorizes S with other unit rows.
class UnilateralRows final : public Unilateral, private Gaps {
 public:
  /// All arguments must outlive this object. `contacts` may be null.
  UnilateralRows(Workspace& work, ConstrainedSystem& system, Contacts* contacts);

  bool close_touching(double t, const double* r, StartMode mode) override;
  void open_moving(double t, const double* r, const double* v) override;
  Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) override;

  void exchange_memory(Memory& memory) override { memory.exchange(slack_); }

  std::size_t num_events() const override {
    return rows_.size() + (friction_.empty() ? 0 : friction_.modes()->num_events());
  }
  void evaluate_events(const Kinematics& at, const Reactions& found, double* values) override;
  void shape_events(const Reactions& found, const double* values, double* shapes) const override;
  void evaluate_slopes(const Kinematics& at, std::span<double> slopes) override;
  Outcome switch_equations(double t, const double* r, double* v, std::span<const std::size_t> which,
                           const Request& request, const AccelerationOutput& to) override;
  Power work_of_switch() const override { return impact_work_; }
  std::span<const ContactEvent> changes_of_switch() const override { return changes_; }
  std::vector<int> discrete_state() const override;
  std::string describe_change(std::span<const int> before) const override;
  void restore_discrete_state(std::span<const int> state) override;

 private:
  using Instant = OneSidedInstant;
  Instant look(const Kinematics& place, double* v, const Request& request, const AccelerationOutput& to, double limit,
               bool keeps_closed);
  Outcome choose(Instant at);
  Outcome collide(Instant* at, bool* collides);
  Outcome end_slow_flights(Instant* at, bool* has_slow);
  void note_impact(Instant* at, const std::vector<char>& approaches, const std::vector<double>& rates,
                   const std::vector<double>& after, const std::vector<double>& x);
  Outcome collide_all(Instant* at);
  Outcome find_closed(Instant* at);
  template <class Free, class Solve, class IsWrong>
  Outcome pivot(const Instant& at, const std::vector<char>& may_close, const Free& free, const Solve& solve,
                const IsWrong& is_wrong);

  template <class Free, class Solve>
  Outcome close_dependent(const Instant& at, const std::vector<char>& may_close, const Free& free, const Solve& solve);
  void close_smooth(const std::vector<char>& closed);

  void measure_slack(const Instant& at);
  void minimize_norm(const double* r, std::vector<double>* lambda);
  std::vector<char> smooth(std::vector<char> rows) const;

  RoughRows friction_;
  DependentRows dependent_;            // without friction
  bool continues_ = false;             // the next `begin` goes on with the rows that are closed
  std::vector<double> slack_;          // [one-sided row] m: gaps below are 0
  std::vector<double> forces_;         // [d] scratch
  Power impact_work_;                  // J, at the last switch
  std::vector<ContactEvent> changes_;  // at the last switch
};

}  // namespace tanor::detail
