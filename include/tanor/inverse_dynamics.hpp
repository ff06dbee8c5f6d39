#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

/// \file
/// Inverse dynamics: forces from a given motion. The paper calls this the *direct problem*, and its *inverse problem*
/// is the forward dynamics of the field, accelerations from forces (<tanor/dynamics.hpp>).
namespace tanor {

/// A motion at one instant: r, v, w (3n, in the user's order) or q, q_dot, q_ddot.
struct MotionState {
  std::vector<double> value, rate, acceleration;
};

/// A motion given as samples, with C4 interpolation (splines of degree 5; for samples at distance h the errors are
/// O(h^6) in the values and O(h^4) in the accelerations).
class TANOR_API MotionTable {
 public:
  /// Interpolates `values` [times][columns]. Throws InputError naming the row if the times do not increase or a number
  /// is not finite.
  MotionTable(std::vector<double> times, std::vector<double> values, std::size_t columns);
  MotionTable(MotionTable&&) noexcept;
  MotionTable& operator=(MotionTable&&) noexcept;
  ~MotionTable();

  std::span<const double> times() const;
  std::size_t num_columns() const;
  /// Returns the motion at t. Throws InputError outside the samples.
  MotionState at(double t) const;

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Violation of the constraints by a motion on one level, and its place: a row ("rods[3]") or a point ("point 4").
struct Violation {
  double largest = 0.0;
  std::string where;  ///< empty if there is none
};

/// The forces that make a given motion, and the violation of the constraints by that motion.
struct [[nodiscard]] MotionForces {
  /// Singular if rows depend on each other; NotConverged if no multipliers obey the laws of friction. The members after
  /// `acceleration` are then empty.
  Outcome outcome;
  Violation position;      ///< |xi|/|gradient|/length; for supports and coordinates the distance over the scene's size
  Violation velocity;      ///< |K'v + xi_t|/|gradient|, m/s; likewise
  Violation acceleration;  ///< |K'w + phi|/|gradient|, m/s^2; likewise
  std::vector<double> multipliers;  ///< lambda = Gamma^-1 K'(Mw - f - tau), [equations]; empty with coordinates alone
  /// Tau(lambda), 3n, N, at points that slide along their guides; empty if there are none.
  std::vector<double> friction;
  std::vector<double> reactions;  ///< eta = (Mw - f - tau)_N, 3n, N; at supports the forces of the constraints there
  /// u_T = (Mw - f - tau)_T, 3n, N: the least control force that makes the motion, beside f and tau. At a point that
  /// rests on a guide with exact Coulomb friction, whose law bounds the friction without determining it, it contains
  /// the friction too.
  std::vector<double> control_forces;
  std::vector<double> support_forces;  ///< 3n, N: the load that each support carries
  double largest_control = 0.0;        ///< largest control force of a point, N
  Index controlled_point = 0;          ///< the point with that force
};

/// Inverse dynamics, forces from a given motion: Mw = f + tau + eta + u, with eta in N by the constraints, u in T by
/// whoever controls the motion, and tau by the laws of friction at that eta. Supports move as prescribed; a given
/// motion that differs there is a violation. Not thread-safe; use one object per host thread.
class TANOR_API InverseDynamics {
 public:
  /// Validates the system; throws InputError.
  explicit InverseDynamics(System system, SolverOptions options = {});
  InverseDynamics(InverseDynamics&&) noexcept;
  InverseDynamics& operator=(InverseDynamics&&) noexcept;
  ~InverseDynamics();

  const System& system() const;  ///< the system as it was given
  std::size_t num_equations() const;
  std::size_t num_coordinates() const;

  /// Returns the forces at (t, r, v, w), 3n each.
  MotionForces evaluate(double t, const MotionState& points);
  /// Returns r, v and w at (t, q, q_dot, q_ddot), where w = A q_ddot + psi. Coordinates stand entry by entry as the
  /// system lists them. Throws InputError if there are none, or if some have charts of their own (spheres, bodies,
  /// chains in space).
  MotionState place(double t, const MotionState& coordinates);

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
