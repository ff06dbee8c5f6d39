#pragma once

#include <cstddef>
#include <vector>

#include "base/groups.hpp"
#include "dynamics/constrained_system.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// The gaps of one-sided rows, g = s xi, which of them are closed, and the sizes that they are measured by.
class Gaps {
 public:
  /// Slower gaps rest, over the speed around them; smaller forces and accelerations are 0.
  static constexpr double resting = 1e-11;

  /// Both arguments must outlive this object.
  Gaps(Workspace& work, ConstrainedSystem& system);

  std::vector<char>& closed() { return closed_; }  ///< [one-sided row]
  const std::vector<char>& closed() const { return closed_; }
  const Groups<Incidence>& arms() const { return arms_; }  ///< [one-sided row] its blocks
  double restitution(std::size_t k) const { return rows_[k].restitution; }
  const std::vector<double>& accelerations() const { return accelerations_; }  ///< [one-sided row] last measured, m/s^2

  /// Leaves the open rows out of K, and the contacts of their friction out of those that take part.
  void apply();
  void measure_gaps(double t, const double* r);
  void measure_rates(const double* r, const double* v, std::vector<double>* rates);
  void measure_accelerations(const double* r, const double* v, const double* w);
  /// Writes K'w + phi [row] of all rows; one-sided ones are as if closed.
  void measure_right_side(const double* r, const double* v, const double* w, std::vector<double>* b);

  /// Returns S_aa = K_a'M^-1 K_a of a closed row.
  double inverse_effective_mass(std::size_t k) const;
  double length(std::size_t k) const { return workspace_.scales.length(neighbourhood(k)); }
  double speed(std::size_t k) const { return workspace_.scales.speed(neighbourhood(k)); }
  /// Returns the slowest rate with which a row that touches approaches, m/s. Where its gap was seen to fall, only what
  /// an impact leaves by rounding is slower.
  double slowest(std::size_t k, bool falls) const { return (falls ? 1e-14 : resting) * speed(k); }
  double acceleration(std::size_t k) const { return speed(k) * speed(k) / length(k); }
  std::size_t user_row(std::size_t k) const {
    return static_cast<std::size_t>(model_.numbering.user_row[static_cast<std::size_t>(rows_[k].row)]);
  }
  ContactChange name_change(std::size_t k, bool closes) const;

 protected:
  std::size_t neighbourhood(std::size_t k) const {
    return workspace_.scales.of_row(static_cast<std::size_t>(rows_[k].row));
  }
  void take_rows(std::vector<double>* numbers) const;

  Workspace& workspace_;
  const Model& model_;
  ConstrainedSystem& system_;
  const std::vector<OneSidedRow>& rows_;
  const Constraints::Selection selection_;
  Groups<Incidence> arms_;                            // [one-sided row] its blocks
  std::vector<char> closed_;                          // [one-sided row]
  std::vector<double> gaps_, rates_, accelerations_;  // [one-sided row] scratch
  std::vector<double> all_rows_;                      // [d] scratch
};

}  // namespace tanor::detail
