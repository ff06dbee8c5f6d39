#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

/// \file
/// Inverse dynamics: forces from a given motion. The paper calls this the *direct problem*, and calls its *inverse
/// problem* what everybody else calls forward dynamics, accelerations from forces (<tanor/dynamics.hpp>).
namespace tanor {

/// Numbers of a motion at one instant: r, v, w (3n, in the user's order) or q, q_dot, q_ddot.
struct MotionState {
  std::vector<double> value, rate, acceleration;
};

/// A motion given as samples, C4 between them (splines of degree 5; errors at distance h of the samples: O(h^6) of the
/// values, O(h^4) of the accelerations).
class TANOR_API MotionTable {
 public:
  /// `values` [times][columns]. Throws InputError naming the row where the times do not increase or a number is not
  /// finite.
  MotionTable(std::vector<double> times, std::vector<double> values, std::size_t columns);
  MotionTable(MotionTable&&) noexcept;
  MotionTable& operator=(MotionTable&&) noexcept;
  ~MotionTable();

  std::span<const double> times() const;
  std::size_t num_columns() const;
  /// Throws InputError outside the samples.
  MotionState at(double t) const;

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// By how much a motion breaks the constraints on one level, and where: a row ("rods[3]") or a point ("point 4").
struct Violation {
  double largest = 0.0;
  std::string where;  ///< empty: nowhere
};

/// The forces that make a given motion, and how far that motion is from the constraints.
struct [[nodiscard]] MotionForces {
  Outcome outcome;     ///< Singular: rows depend on each other; NotConverged: no multipliers obey the laws of friction;
                       ///< what follows `acceleration` is empty then
  Violation position;  ///< |xi|/|gradient|/length; supports and coordinates: distance over the scene's size
  Violation velocity;  ///< |K'v + xi_t|/|gradient|, m/s; likewise
  Violation acceleration;              ///< |K'w + phi|/|gradient|, m/s^2; likewise
  std::vector<double> multipliers;     ///< lambda = Gamma^-1 K'(Mw - f - tau), [equations]; none by coordinates alone
  std::vector<double> friction;        ///< tau(lambda), 3n, N, of points that slide along their guides; empty: none
  std::vector<double> reactions;       ///< eta = (Mw - f - tau)_N, 3n, N; at supports: what the constraints do there
  std::vector<double> control_forces;  ///< u_T = (Mw - f - tau)_T, 3n, N: the least one that makes the motion, with f
                                       ///< and tau; where a point rests on a guide with exact Coulomb friction, which
                                       ///< the law bounds but does not tell, it holds that friction too
  std::vector<double> support_forces;  ///< 3n, N: the load each support carries
  double largest_control = 0.0;        ///< of one point, N
  Index controlled_point = 0;          ///< which one
};

/// Inverse dynamics, forces from a given motion: Mw = f + tau + eta + u, eta in N by the constraints, u in T by whoever
/// controls the motion, tau by the laws of friction at the eta that they leave. Supports move as prescribed: where the
/// given motion says otherwise it is a violation. Not thread-safe; one object per host thread.
class TANOR_API InverseDynamics {
 public:
  /// Validates; throws InputError.
  explicit InverseDynamics(System system, SolverOptions options = {});
  InverseDynamics(InverseDynamics&&) noexcept;
  InverseDynamics& operator=(InverseDynamics&&) noexcept;
  ~InverseDynamics();

  const System& system() const;  ///< as it was given
  std::size_t num_equations() const;
  std::size_t num_coordinates() const;

  /// At (t, r, v, w), 3n each.
  MotionForces evaluate(double t, const MotionState& points);
  /// r, v and w of (t, q, q_dot, q_ddot): w = A q_ddot + psi. Coordinates stand entry by entry as the system lists
  /// them. Throws InputError where there are none, or where some have charts of their own (spheres, bodies, chains in
  /// space).
  MotionState place(double t, const MotionState& coordinates);

 private:
  struct TANOR_LOCAL Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
