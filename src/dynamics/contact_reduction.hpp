#pragma once

#include <vector>

#include "dynamics/constrained_system.hpp"
#include "dynamics/contact_choice.hpp"
#include "dynamics/contact_state.hpp"
#include "dynamics/friction_solver.hpp"

namespace tanor {

/// Islands of contacts as small dense problems: how their reactions and accelerations answer to friction, with all else
/// eliminated (docs/friction.md).
class ContactReduction {
 public:
  /// All must outlive it.
  ContactReduction(const ContactState& state, FrictionSolver& friction, ConstrainedSystem& system)
      : state_(state), friction_(friction), system_(system) {}

  /// Islands with Coulomb's friction and at most `most_contacts` of it, among those that are `wanted` [island]: their
  /// contacts, and what they held so far. The friction solver stands at the place.
  std::vector<ContactChoice> list(const ModeSwitch& at, const std::vector<char>& wanted,
                                  std::size_t most_contacts) const;
  /// N0, W, a0, A of each, with the factor of S in which none of their contacts sticks: one solve for the first
  /// component of every island at once, one for the second, …
  void reduce(const ModeSwitch& at, std::vector<ContactChoice>* choices);
  /// The multipliers that belong to what was chosen, into `lambda()` of the system: where iterations begin.
  void guess_multipliers(const ModeSwitch& at, const std::vector<ContactChoice>& choices);

 private:
  struct Answer {
    std::vector<double> lambda, w;  // [rows], [3n]
  };
  double evaluate_without_coulomb(const ModeSwitch& at, std::vector<double>* w, std::vector<double>* b);
  Answer solve_without_coulomb(const ModeSwitch& at, std::vector<ContactChoice>* choices);
  void set_constant_terms(const ModeSwitch& at, const Answer& answer, std::vector<ContactChoice>* choices) const;
  void set_column(std::size_t j, std::vector<ContactChoice>* choices, Answer* answer);
  void clear_rounding(ContactChoice* choice) const;
  void solve(const std::vector<double>& b, std::vector<double>* lambda, std::vector<double>* dw);
  ContactPlace place(const ModeSwitch& at) const { return {at.t, at.r, at.v, system_.blocks().data()}; }
  template <class Column>
  void write_forces(const ContactChoice& choice, const double* lambda, Column&& column) const;
  template <class Column>
  void write_accelerations(const ContactChoice& choice, const double* w, Column&& column) const;

  const ContactState& state_;
  FrictionSolver& friction_;
  ConstrainedSystem& system_;
};

}  // namespace tanor
