#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <tanor/dynamics.hpp>

#include "assembly/reactions.hpp"
#include "base/parallel.hpp"
#include "evaluate/constraints.hpp"
#include "evaluate/forces.hpp"
#include "evaluate/parametrisation.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// A valid system and its numbers in an order that is good for memory.
struct NumberedSystem {
  /// Validates. `t`: where the system is checked.
  NumberedSystem(System given, const SolverOptions& options, double t);

  System system;
  Parallel parallel;
  Numbering numbering;
};

/// The families of a system, each standing at one instant: time, contacts that stick and charts move them.
struct Families {
  /// `t`: where "initial" values are taken.
  Families(const NumberedSystem& of, double t)
      : constraints(of.system, of.numbering, t),
        forces(of.system, of.numbering),
        coordinates(of.system, of.numbering, t) {}

  Constraints constraints;
  Forces forces;
  Parametrisation coordinates;  ///< empty where none are given
};

/// What does not move, in the inner order of points and rows: what both forms of the dynamics stand on. Everybody has
/// it as a `const Model&`; what moves is in a Workspace.
///
/// Supports take part as points of infinite mass whose acceleration is prescribed: w0 = M^-1 f on moving points and the
/// support's own acceleration there, so that K'w0 carries both and phi needs no term of its own for them.
class Model : public NumberedSystem {
 public:
  Model(NumberedSystem numbered, const Families& families);
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  std::vector<double> mass, inverse_mass;  ///< [point]; supports: 0 and 0
  std::vector<Incidence> incidences;       ///< of K
  ReactionGather gather;                   ///< K lambda
  double scene_size, smallest_length;      ///< m
  /// Constraints close loops, or hold one island in two places: trees of rods on one support never lose rank.
  bool may_lose_rank;
  double mass_ratio;  ///< largest over smallest of moving points under constraints

  std::size_t num_points() const { return numbering.num_points(); }
  std::size_t num_moving() const { return numbering.num_moving; }
  /// With those of contacts that may stick; `numbering.num_user_rows` are the user's.
  std::size_t num_rows() const { return numbering.num_rows(); }
  /// Moving points that constraints join; they come first.
  std::size_t num_constrained() const { return num_constrained_; }
  /// Where the points were at the start: an order of elimination may follow from it.
  PointPlaces places() const { return {system.positions, numbering.user_point}; }
  bool has_friction() const { return num_contacts_ > 0; }
  bool has_moving_supports() const { return !moving_supports_.empty(); }
  /// Reactions may do work.
  bool is_rheonomic() const { return has_moving_supports() || depends_on_time_; }
  /// w0 of every moving point, where gravity alone acts; else null.
  const Vec3* uniform_free() const { return uniform_free_ ? &*uniform_free_ : nullptr; }

  /// Of all points [3n], and the accelerations of supports [3 supports].
  struct PrescribedMotion {
    double *r, *v, *accelerations;
  };
  /// What is prescribed at t: at moving supports; at all of them, for arrays that come from outside.
  void prescribe(double t, const PrescribedMotion& to) const { prescribe(moving_supports_, t, to); }
  void prescribe_all(double t, const PrescribedMotion& to) const;

  /// Largest |x_i|, and largest |x_i - y_i|, over the points.
  double largest_norm(const double* x) const;
  double largest_move(const double* x, const double* y) const;

  Outcome not_finite(double t) const;
  /// Power W = sum of m a'v over the moving points, of accelerations a and velocities v [3n].
  double power(const double* a, const double* v) const;

 private:
  struct PrescribedPoints {
    VectorFunction displacement;
    std::vector<Index> points;   // inner
    std::vector<Vec3> position;  // initial
  };
  void prescribe(const std::vector<PrescribedPoints>& supports, double t, const PrescribedMotion& to) const;

  std::vector<PrescribedPoints> fixed_supports_, moving_supports_;
  std::optional<Vec3> uniform_free_;
  std::size_t num_constrained_, num_contacts_;
  bool depends_on_time_;
};

}  // namespace tanor
