#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <tanor/dynamics.hpp>

#include "assembly/reactions.hpp"
#include "base/parallel.hpp"
#include "dynamics/instant.hpp"
#include "evaluate/constraints.hpp"
#include "evaluate/forces.hpp"
#include "evaluate/parametrisation.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Returns the largest mass over the smallest one of moving points that constraints join. S may be worse conditioned
/// than K by as much. `incidences` are those of K; `inverse_mass` [point] is 0 at supports.
double find_mass_ratio(std::span<const Incidence> incidences, std::span<const double> inverse_mass);

/// A valid system and its numbers in an order of good memory locality.
struct NumberedSystem {
  /// Validates the system, with checks at the time `t`.
  NumberedSystem(System given, const SolverOptions& options, double t);

  System system;
  Parallel parallel;
  Numbering numbering;
  bool is_exact;                   ///< SolverOptions::exact
  int max_impacts_at_one_instant;  ///< ContactOptions
};

/// The families of a system, each at one instant. Time, sticking contacts and charts change them.
struct Families {
  /// "Initial" values are taken at the time `t`.
  Families(const NumberedSystem& of, double t)
      : constraints(of.system, of.numbering, t),
        forces(of.system, of.numbering),
        coordinates(of.system, of.numbering, t) {}

  Constraints constraints;
  Forces forces;
  Parametrisation coordinates;  ///< empty if none are given
};

/// The constant data that both forms of the dynamics use, in the inner order of points and rows. It is shared as a
/// `const Model&`; data that changes is in a Workspace.
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
  ReactionGather gather;                   ///< for K lambda
  double scene_size, smallest_length;      ///< m
  /// True if constraints close loops, or hold one island in two places. Trees of rods on one support never lose rank.
  bool may_lose_rank;
  double mass_ratio;  ///< largest over smallest of moving points under constraints

  std::size_t num_points() const { return numbering.num_points(); }
  std::size_t num_moving() const { return numbering.num_moving; }
  /// The number of rows, with those of contacts that may stick; `numbering.num_user_rows` are the user's.
  std::size_t num_rows() const { return numbering.num_rows(); }
  /// The number of moving points that constraints join; they come first.
  std::size_t num_constrained() const { return num_constrained_; }
  /// The initial positions, from which an order of elimination may follow.
  PointPlaces places() const { return {system.positions, numbering.user_point}; }
  bool has_friction() const { return num_contacts_ > 0; }
  /// Returns true if accelerations are to be refined to rounding.
  bool is_exact_for(const Request& request) const { return request.exact && is_exact; }
  bool has_moving_supports() const { return !moving_supports_.empty(); }
  /// Returns true if reactions may do work.
  bool is_rheonomic() const { return has_moving_supports() || depends_on_time_; }
  /// w0 of every moving point if gravity alone acts, otherwise null.
  const Vec3* uniform_free() const { return uniform_free_ ? &*uniform_free_ : nullptr; }

  /// Arrays of all points [3n], which are not written if they are null, and the accelerations of supports [3 supports].
  struct PrescribedMotion {
    double *r, *v, *accelerations;
  };
  /// Write the prescribed motion at t, of moving supports, or of all supports for arrays that come from outside.
  void prescribe(double t, const PrescribedMotion& to) const { prescribe(moving_supports_, t, to); }
  void prescribe_all(double t, const PrescribedMotion& to) const;

  /// Return the largest |x_i|, and the largest |x_i - y_i|, over the points.
  double largest_norm(const double* x) const;
  double largest_move(const double* x, const double* y) const;
  /// Computes y += x for moving points. The loop is so short that a thread pays later than elsewhere.
  void add_to_moving(const double* x, double* y) const {
    parallel.for_ranges(
        3 * num_moving(),
        [=](std::size_t begin, std::size_t end) {
          for (std::size_t i = begin; i < end; ++i) y[i] += x[i];
        },
        3 * Parallel::worth_a_thread);
  }

  Outcome not_finite(double t) const;
  /// Returns the power W = sum of m a'v over the moving points, for accelerations a and velocities v [3n].
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

}  // namespace tanor::detail
