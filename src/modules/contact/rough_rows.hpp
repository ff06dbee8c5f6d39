#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "contact/gaps.hpp"
#include "contact/rough_impact.hpp"
#include "contact/rough_islands.hpp"
#include "contact/rough_modes.hpp"
#include "dynamics/contacts.hpp"
#include "dynamics/roles.hpp"

namespace tanor::detail {

/// An instant at which one-sided rows may close and open.
struct OneSidedInstant {
  double t;
  const double* r;
  double* v;
  const Request& request;
  const AccelerationOutput& to;
  std::vector<char> touches{}, leaves{};  ///< [one-sided row] its gap is 0; its force came to 0 just now
  std::vector<char> falls{};              ///< [one-sided row] its gap falls through 0: no rate below 0 is rounding
  bool begins = false;                    ///< a motion, or the rest of one behind a break
  bool is_listed = true;                  ///< what changes is
  int impacts = 0;                        ///< that followed one another so far
  Power work{};                           ///< J, of impacts
  std::vector<ContactEvent> changes{};    ///< what happened so far
};

/// The friction at one-sided rows: impacts, and which contacts are open, stick or slide (theory in docs/one-sided.md).
/// Islands with friction are reduced to their contacts; those that have not changed keep their modes.
class RoughRows {
 public:
  /// All arguments must outlive this object. `contacts` is null if there is no friction.
  RoughRows(Workspace& work, ConstrainedSystem& system, Gaps& gaps, Contacts* contacts);

  bool empty() const { return contacts_ == nullptr; }
  /// Returns true if the island of a one-sided row has friction.
  bool have(std::size_t k) const { return islands_.island_of(k) != RoughContact::none; }
  /// The events of closed contacts; null if there is no friction.
  EventFunctions* modes() const { return empty() ? nullptr : contacts_->events(); }

  /// Notes the forces and modes before an instant, and the events of modes() that are met.
  void begin(const OneSidedInstant& at, std::span<const std::size_t> met);
  /// Solves the impact of the islands with friction that have rows which touch and approach, with the rates of all
  /// gaps [one-sided row].
  Outcome collide(OneSidedInstant* at, const std::vector<double>& rates, bool* collides);
  /// Chooses the closed ones of the rows that may close. Marks rows [one-sided row] of which all motions are known.
  /// Several motions are refused at a start; later the one nearest to the last forces is taken.
  Outcome choose_closed(OneSidedInstant* at, const std::vector<char>& may_close, std::vector<char>* are_known);
  /// True if no motion obeys the law in some islands; then an impulse without a collision takes their slide away.
  bool are_jammed() const { return !jams_.empty(); }
  Outcome end_jams(OneSidedInstant* at);
  /// Takes away the velocity of closed rows that separate slowly, with that of the friction which belongs to it.
  Outcome end_slow_flights(OneSidedInstant* at, const std::vector<double>& rates);
  /// Chooses what sticks and what slides of that which is closed, and computes the accelerations.
  Outcome choose_modes(OneSidedInstant* at);
  /// Adds the contacts that began to stick or to slip, `was_closed` [one-sided row], to the changes.
  void note_modes(OneSidedInstant* at, const std::vector<char>& was_closed) const;

 private:
  using Solve = std::function<RoughImpact(const RoughProblem&)>;

  Outcome reduce(const OneSidedInstant& at, const std::vector<char>& take_part, std::vector<RoughProblem>* problems);
  Outcome strike(OneSidedInstant* at, const std::vector<char>& take_part, const std::vector<double>& rates,
                 ContactChange change, const Solve& solve);
  void note_impact(OneSidedInstant* at, const RoughProblem& problem, const RoughImpact& impact,
                   const std::vector<double>& rates, ContactChange change) const;
  void add_work_of_guides(OneSidedInstant* at, const RoughProblem& problem, const Eigen::VectorXd& P,
                          const std::vector<double>& lambda, const std::vector<double>& own, ContactEvent* event) const;
  Outcome explain(const OneSidedInstant& at, const RoughProblem& problem, const RoughMotions& motions) const;
  std::vector<char> rows_of(const std::function<bool(std::size_t)>& takes_part) const;
  void note(Uniqueness uniqueness, const std::string& why);

  Workspace& work_;
  const Model& model_;
  ConstrainedSystem& system_;
  Gaps& gaps_;
  Contacts* const contacts_;
  RoughIslands islands_;
  std::vector<std::size_t> met_;                    // events of the friction
  std::vector<char> has_changed_;                   // [island] its modes are to be chosen
  std::vector<char> was_stuck_, stuck_, stops_;     // [contact] before the instant; at the last choice; ceases to slide
  std::vector<GuideChange> guides_;                 // [contact]
  std::vector<double> lambda_before_, tau_before_;  // [rows], [3 contacts]
  std::vector<std::size_t> jams_;                   // islands
  Uniqueness uniqueness_ = Uniqueness::NotAsked;    // of the motions at the instant
  std::string reason_;
};

}  // namespace tanor::detail
