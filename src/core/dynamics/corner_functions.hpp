#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "dynamics/instant.hpp"

namespace tanor::detail {

/// Corners, where the gradients of constraints, the tangents of coordinates or the rates of what moves by itself jump.
/// Formulas have terms with two branches each; functions of time alone have instants.
class CornerFunctions {
 public:
  virtual std::size_t num_terms() const = 0;
  /// Evaluates the arguments of the terms. The equations follow one branch of a term where its argument is negative,
  /// and the other one elsewhere.
  virtual void evaluate_terms(const Kinematics& at, double* arguments) = 0;
  /// Appends the last instants in [begin, end) before rates of functions of time jump, s.
  virtual void append_instants(double begin, double end, std::vector<double>* instants) = 0;
  /// Changes v, which belongs to the state `before` a corner, to what it is `after` it: that of the same motion along
  /// guides whose corners are rounded ever more sharply. The terms `which` have different branches at both states,
  /// which are apart by no more than rounding. Writes the work of what moves by itself, J. Fails by name if v would
  /// depend on how corners are rounded.
  virtual Outcome cross(const Kinematics& before, const Kinematics& after, std::span<const std::size_t> which,
                        double* v, Power* work) = 0;
  /// Fails by name if the state, where the argument of the term is 0, stands in a corner of it or moves along its edge.
  virtual Outcome check_standing(const Kinematics& at, std::size_t term) = 0;
  /// Returns e.g. "abs(x1) in formula0".
  virtual std::string name_term(std::size_t term) const = 0;

 protected:
  ~CornerFunctions() = default;
};

}  // namespace tanor::detail
