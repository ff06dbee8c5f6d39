#pragma once

#include <string>
#include <vector>

#include "base/groups.hpp"
#include "dynamics/unilateral.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// The one-sided rows of a system, without friction: which of them are closed, and how that changes.
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
class UnilateralRows final : public Unilateral {
 public:
  /// Both arguments must outlive this object.
  UnilateralRows(Workspace& work, ConstrainedSystem& system);

  bool close_touching(double t, const double* r, StartMode mode) override;
  void open_moving(double t, const double* r, const double* v) override;
  Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) override;

  void exchange_memory(Memory& memory) override { memory.exchange(slack_); }

  std::size_t num_events() const override { return rows_.size(); }
  void evaluate_events(const Kinematics& at, const Reactions& found, double* values) override;
  void shape_events(const Reactions& found, const double* values, double* shapes) const override;
  void evaluate_slopes(const Kinematics& at, std::span<double> slopes) override;
  Outcome switch_equations(double t, const double* r, double* v, std::span<const std::size_t> which,
                           const Request& request, const AccelerationOutput& to) override;
  Power work_of_switch() const override { return impact_work_; }
  std::span<const ContactEvent> changes_of_switch() const override { return changes_; }
  std::vector<int> discrete_state() const override { return {closed_.begin(), closed_.end()}; }
  std::string describe_change(std::span<const int> before) const override;
  void restore_discrete_state(std::span<const int> state) override;

 private:
  /// An instant at which rows may close and open.
  struct Instant {
    double t;
    const double* r;
    double* v;
    const Request& request;
    const AccelerationOutput& to;
    std::vector<char> touches{}, leaves{};  // [one-sided row] its gap is 0; its force came to 0 just now
    bool begins = false;                    // a motion
  };
  Instant look(const Kinematics& place, double* v, const Request& request, const AccelerationOutput& to, double limit);
  Outcome choose(Instant at);
  Outcome collide(Instant* at, bool* collides);
  Outcome end_slow_flights(const Instant& at, bool* has_slow);
  void note_impact(const Instant& at, const std::vector<char>& approaches, const std::vector<double>& rates,
                   const std::vector<double>& after, const std::vector<double>& x);
  Outcome find_closed(const Instant& at);
  template <class Free, class Solve, class IsWrong>
  Outcome pivot(const Instant& at, const std::vector<char>& may_close, const Free& free, const Solve& solve,
                const IsWrong& is_wrong);

  template <class Free, class Solve>
  Outcome close_dependent(const Instant& at, const std::vector<char>& may_close, const Free& free, const Solve& solve);
  void measure_free(const double* r, const double* v);
  bool look_ahead(const Instant& at, const std::vector<char>& may_close);

  void apply();
  void take_rows(std::vector<double>* numbers) const;
  void measure_gaps(double t, const double* r);
  void measure_rates(const double* r, const double* v, std::vector<double>* rates);
  void measure_accelerations(const double* r, const double* v, const double* w);
  void measure_slack(const Instant& at);
  void minimize_norm(const double* r, std::vector<double>* lambda);
  double inverse_effective_mass(std::size_t k) const;
  std::size_t neighbourhood(std::size_t k) const {
    return workspace_.scales.of_row(static_cast<std::size_t>(rows_[k].row));
  }
  double length(std::size_t k) const { return workspace_.scales.length(neighbourhood(k)); }
  double speed(std::size_t k) const { return workspace_.scales.speed(neighbourhood(k)); }
  double acceleration(std::size_t k) const { return speed(k) * speed(k) / length(k); }
  std::size_t user_row(std::size_t k) const {
    return static_cast<std::size_t>(model_.numbering.user_row[static_cast<std::size_t>(rows_[k].row)]);
  }
  ContactChange name_change(std::size_t k, bool closes) const;

  Workspace& workspace_;
  const Model& model_;
  ConstrainedSystem& system_;
  const std::vector<OneSidedRow>& rows_;
  const Constraints::Selection selection_;
  Groups<Incidence> arms_;                            // [one-sided row] its blocks
  std::vector<char> closed_;                          // [one-sided row]
  bool continues_ = false;                            // the next `begin` goes on with them
  std::vector<double> slack_;                         // [one-sided row] m: gaps below are 0
  std::vector<double> gaps_, rates_, accelerations_;  // [one-sided row] scratch
  std::vector<double> all_rows_, forces_;             // [d] scratch
  struct {
    std::vector<double> b, lambda, w;  // b and multipliers [d]; accelerations [3n], none at impacts
  } free_;                             // where all one-sided rows are open
  Power impact_work_;                  // J, at the last switch
  std::vector<ContactEvent> changes_;  // at the last switch
};

}  // namespace tanor::detail
