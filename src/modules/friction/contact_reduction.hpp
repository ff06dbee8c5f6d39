#pragma once

#include <vector>

#include "friction/contact_choice.hpp"
#include "friction/contact_state.hpp"
#include "friction/friction_solver.hpp"

namespace tanor::detail {

/// Reduces islands of contacts to small dense problems: the responses of their reactions and accelerations to friction,
/// with all other unknowns eliminated (docs/friction.md).
class ContactReduction {
 public:
  /// Both arguments must outlive this object.
  ContactReduction(const ContactState& state, FrictionSolver& friction) : state_(state), friction_(friction) {}

  /// Lists the islands among those `wanted` [island] that have Coulomb contacts, and at most `most_contacts` of them,
  /// each with its contacts and their last friction. The friction solver must be set to this configuration.
  std::vector<ContactChoice> list(const ModeSwitch& at, const std::vector<char>& wanted,
                                  std::size_t most_contacts) const;
  /// Computes N0, W, a0, A of each island, with the factor of S in which none of their contacts sticks. One solve
  /// serves the first component of every island at once, one the second, and so on.
  void reduce(const ModeSwitch& at, std::vector<ContactChoice>* choices);
  /// Writes the multipliers that belong to the chosen friction into `lambda()` of the system, as initial guess of later
  /// iterations.
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
  template <class Column>
  void write_forces(const ContactChoice& choice, const double* lambda, Column&& column) const;
  template <class Column>
  void write_accelerations(const ContactChoice& choice, const double* w, Column&& column) const;

  const ContactState& state_;
  FrictionSolver& friction_;
};

}  // namespace tanor::detail
