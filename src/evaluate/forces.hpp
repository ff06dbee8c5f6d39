#pragma once

#include <vector>

#include "base/parallel.hpp"
#include "evaluate/tables.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// The active forces f(r, v, t) of a system, in the inner order.
///
/// Gravity, given forces and drag act point by point; a spring is evaluated once and gathered by its two points in a fixed order.
class Forces {
 public:
  Forces(const System& system, const Numbering& numbering);

  /// Some force has no potential: drag, damping, or a force that depends on time.
  bool has_work() const { return !drags_.empty() || has_damping_ || forces_depend_on_time_; }
  bool depends_on_velocity() const { return !drags_.empty() || has_damping_; }
  bool has_springs() const { return !springs_.empty(); }

  /// f [3n], N.
  void evaluate(const Parallel& parallel, double t, const double* r, const double* v, double* f);

  /// Potential energy of gravity, constant forces and springs, J. Supports take part as far as springs hold them.
  double potential(const double* r) const;
  /// Power of the forces without potential on the moving points, W, at the (t, r, v) of the last `evaluate`.
  double power(const double* r, const double* v) const;
  /// Power that moving supports put in through springs, W.
  double spring_power_of_supports(const double* r, const double* v) const;

 private:
  struct Spring {
    Index i, j;
    double stiffness, damping, rest_length;
  };
  struct GivenForce {
    Index point;
    Index slot;  // in given_
  };
  struct PointDrag {
    Index point;
    double linear, quadratic;
  };
  Vec3 spring_force(const Spring& spring, const double* r, const double* v, bool elastic, bool viscous) const;

  std::size_t num_points_ = 0, num_moving_ = 0;
  std::vector<double> mass_;  // [moving point], kg
  Vec3 gravity_{};
  VectorTable<AsGiven> given_;
  std::vector<char> given_is_constant_;
  std::vector<GivenForce> given_forces_;
  std::vector<PointDrag> drags_;
  std::vector<Spring> springs_;
  std::vector<double> spring_force_;                      // [spring] on its point j
  std::vector<Index> springs_start_, springs_of_point_;   // [point] -> k or ~k where it is the spring's point i
  bool has_damping_ = false, forces_depend_on_time_ = false;
};

}  // namespace tanor
