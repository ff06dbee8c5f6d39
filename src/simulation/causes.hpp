#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/forms.hpp"

namespace tanor {

/// The reaction by its causes: the right-hand side phi + K'M^-1 f of (31) is a sum, S has one factor.
///
/// phi = v'Hess(xi) v + 2 v'grad(xi_t) + xi_tt row by row. *Inertia* is its first term, even in v like the third, and
/// quadratic: (phi(v) + phi(-v))/2 - phi(0). *Drive* is the rest of phi, with the prescribed accelerations of supports.
/// Coordinates alone: the same with psi, eta by (24); v is q_dot then.
class Causes {
 public:
  explicit Causes(Forms& forms);

  /// At (t, r, v) [3n], where the forms stand; q, q_dot: the tangent form's own variables (without constraints). In the
  /// user's order.
  std::vector<ReactionPart> find(double t, const double* r, const double* v, const double* q, const double* q_dot);

 private:
  std::vector<ReactionPart> find_by_constraints(double t, const double* r, const double* v);
  ReactionPart find_part(std::string cause, const double* r, const std::vector<double>& b);
  std::vector<double> apply_transposed_to_forces(const std::vector<double>& f);
  std::vector<double> apply_transposed(const std::vector<double>& w, const double* rest);
  void add_inertia_and_drive(const double* r, const double* v, std::vector<ReactionPart>* result);
  std::vector<ReactionPart> find_by_coordinates(double t, const double* r, const double* v, const double* q,
                                                const double* q_dot);
  /// Calls use(name, forces [3n]) for each entry.
  template <class Use>
  void for_each_force(double t, const double* r, const double* v, const Use& use);

  Forms& forms_;
  Workspace& work_;
  const Model& model_;
  std::vector<std::unique_ptr<Forces>> forces_;  // one an entry
};

}  // namespace tanor
