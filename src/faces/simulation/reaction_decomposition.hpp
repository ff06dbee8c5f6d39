#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/forms.hpp"

namespace tanor::detail {

/// Decomposes the reaction by its causes. The right-hand side phi + K'M^-1 f of (31) is a sum, and one factor of S
/// serves all its terms.
///
/// phi = v'Hess(xi) v + 2 v'grad(xi_t) + xi_tt row by row. *Inertia* is the first term, which is quadratic in v and
/// found as (phi(v) + phi(-v))/2 - phi(0). *Drive* is the rest of phi, with the prescribed accelerations of supports.
/// With coordinates alone, psi takes the place of phi, q_dot that of v, and eta follows from (24).
class ReactionDecomposition {
 public:
  explicit ReactionDecomposition(Forms& forms);

  /// Returns the parts in the user's order at (t, r, v) [3n], for which the forms must be current. q and q_dot are the
  /// tangent form's own variables (without constraints).
  std::vector<ReactionPart> find(double t, const double* r, const double* v, const double* q, const double* q_dot);

 private:
  std::vector<ReactionPart> find_by_constraints(double t, const double* r, const double* v);
  ReactionPart find_part(std::string cause, const double* r, const std::vector<double>& b);
  std::vector<double> apply_transposed_to_forces(const std::vector<double>& f);
  std::vector<double> apply_transposed(const std::vector<double>& w, const double* rest);
  void add_inertia_and_drive(double t, const double* r, const double* v, std::vector<ReactionPart>* result);
  std::vector<ReactionPart> find_by_coordinates(double t, const double* r, const double* v, const double* q,
                                                const double* q_dot);
  /// Calls use(name, forces [3n]) for each entry of the system's forces.
  template <class Use>
  void for_each_force(double t, const double* r, const double* v, const Use& use);

  Forms& forms_;
  Workspace& work_;
  const Model& model_;
  std::vector<std::unique_ptr<Forces>> forces_;  // one for each entry of the system's forces
};

}  // namespace tanor::detail
