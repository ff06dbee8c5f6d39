#pragma once

#include <complex>
#include <cstddef>
#include <memory>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/power.hpp"

namespace tanor::detail {

/// The coefficients of M, -df/dv and -df/dx in Newton's matrix of an implicit step.
template <class T>
struct NewtonWeights {
  T mass, velocity, position;
};

/// The equations of motion for implicit schemes: residuals at any (t, x, v, lambda) of
///
///   M x'' = f + K lambda,   K'x' + xi_t = 0
///
/// Springs with a rest length are no part of f. They have rows of their own after those of the constraints,
/// lambda + k xi + c dxi/dt = 0, so that Newton's iteration sees them as compliant rods however stiff they are. Its
/// matrix,
///
///   [ N  -K ]     N = a M - b df/dv - c (df/dx + d(K lambda)/dx)
///   [ K'  E ]     E = 1/(b damping + c stiffness) for springs, else 0
///
/// contains the derivatives of springs, dampers, drag, formulas and rods; all other forces count as not stiff.
class ImplicitEquations {
 public:
  virtual ~ImplicitEquations() = default;

  /// The number of rows of constraints, and of all rows.
  virtual std::size_t num_constraints() const = 0;
  virtual std::size_t num_rows() const = 0;
  /// Writes the initial lambda [num_rows()]: as found with accelerations, and for springs as of (x, v).
  virtual void write_multipliers(const Reactions& found, const double* x, const double* v, double* lambda) = 0;

  /// Computes M^-1 (f + K lambda) into a; K'v + xi_t, or lambda + k xi + c dxi/dt, into rows; and the power, which may
  /// be null.
  virtual Outcome evaluate(double t, const double* x, const double* v, const double* lambda, double* a, double* rows,
                           Power* power) = 0;
  /// Computes xi of the constraints [num_constraints()]. Returns the largest relative violation.
  virtual double evaluate_positions(double t, const double* x, double* xi) = 0;
  /// Evaluates K and the derivatives of forces, which stay until the next call.
  virtual void linearise(double t, const double* x, const double* v, const double* lambda) = 0;
  /// Adds the response of forces to a move dx: M^-1 (df/dx + d(K lambda)/dx) dx to a, and k K'dx to the rows of
  /// springs.
  virtual void add_stiffness(const double* dx, double* a, double* rows) = 0;
  /// Factorizes Newton's matrix at the last linearisation. One real and one complex factor stay until the next ones.
  virtual Outcome factorize(const NewtonWeights<double>& weights) = 0;
  virtual Outcome factorize(const NewtonWeights<std::complex<double>>& weights) = 0;
  /// Replaces residuals of `evaluate` by the increments dx [size()] (0 at supports) and dlambda:
  ///
  ///   N dx - K dlambda = M a,   K'dx + E dlambda = -rows (of springs -E rows)
  virtual void solve(double* a, double* rows) = 0;
  virtual void solve(std::complex<double>* a, std::complex<double>* rows) = 0;

  /// Exchanges the linearisation and the factors.
  virtual void exchange_memory(Memory& memory) = 0;
};

/// The role of a mechanics that has implicit equations.
class ImplicitFormulation {
 public:
  virtual std::unique_ptr<ImplicitEquations> make_implicit_equations() = 0;
  /// Returns true if Newton's matrix contains all forces that may be stiff.
  virtual bool matrix_knows_all_forces() const = 0;

 protected:
  ~ImplicitFormulation() = default;
};

}  // namespace tanor::detail
