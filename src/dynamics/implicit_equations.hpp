#pragma once

#include <complex>
#include <cstddef>
#include <memory>

#include <tanor/dynamics.hpp>

#include "base/memory.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/power.hpp"

namespace tanor {

/// What multiplies M, -df/dv and -df/dx in Newton's matrix of an implicit step.
template <class T>
struct NewtonWeights {
  T mass, velocity, position;
};

/// What implicit schemes see: residuals at any (t, x, v, lambda) of
///
///   M x'' = f + K lambda,   K'x' + xi_t = 0
///
/// Springs with a rest length are no part of f but have rows among those of lambda, after the constraints', with
/// lambda + k xi + c dxi/dt = 0 instead: however stiff they are, Newton's iteration sees rods that give way. Its
/// matrix,
///
///   [ N  -K ]     N = a M - b df/dv - c (df/dx + d(K lambda)/dx)
///   [ K'  E ]     E = 1/(b damping + c stiffness) for springs, else 0
///
/// has the derivatives of springs, dampers, drag, formulas and rods; what else there is counts as not stiff.
class ImplicitEquations {
 public:
  virtual ~ImplicitEquations() = default;

  /// Of constraints, and all of them.
  virtual std::size_t num_constraints() const = 0;
  virtual std::size_t num_rows() const = 0;
  /// lambda [num_rows()] to begin with: what accelerations found, and of springs at (x, v).
  virtual void write_multipliers(const Reactions& found, const double* x, const double* v, double* lambda) = 0;

  /// M^-1 (f + K lambda) into a; K'v + xi_t, or lambda + k xi + c dxi/dt, into rows; the power, which may be null.
  virtual Outcome evaluate(double t, const double* x, const double* v, const double* lambda, double* a, double* rows,
                           Power* power) = 0;
  /// xi, or K'v + xi_t with K at x, of constraints [num_constraints()]; returns the largest relative violation.
  virtual double evaluate_positions(double t, const double* x, double* xi) = 0;
  virtual double evaluate_rates(double t, const double* x, const double* v, double* rates) = 0;
  /// K and the derivatives of forces, from here to the next call.
  virtual void linearise(double t, const double* x, const double* v, const double* lambda) = 0;
  /// How forces answer to a move dx: M^-1 (df/dx + d(K lambda)/dx) dx is added to a, k K'dx to the rows of springs.
  virtual void add_stiffness(const double* dx, double* a, double* rows) = 0;
  /// Newton's matrix at the last linearisation; one real and one complex factor stay until the next ones.
  virtual Outcome factorize(const NewtonWeights<double>& weights) = 0;
  virtual Outcome factorize(const NewtonWeights<std::complex<double>>& weights) = 0;
  /// The increments dx [size()] (0 at supports) and dlambda that answer to residuals of `evaluate`: in their places
  ///
  ///   N dx - K dlambda = M a,   K'dx + E dlambda = -rows (of springs -E rows)
  virtual void solve(double* a, double* rows) = 0;
  virtual void solve(std::complex<double>* a, std::complex<double>* rows) = 0;

  /// The linearisation and the factors that stand.
  virtual void exchange_memory(Memory& memory) = 0;
};

/// Role of a mechanics that has implicit equations.
class ImplicitFormulation {
 public:
  virtual std::unique_ptr<ImplicitEquations> make_implicit_equations() = 0;
  /// Newton's matrix knows all forces that may be stiff.
  virtual bool matrix_knows_all_forces() const = 0;

 protected:
  ~ImplicitFormulation() = default;
};

}  // namespace tanor
