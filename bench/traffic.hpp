#pragma once

#include <tanor/solver_options.hpp>

/// \file The least bytes that one evaluation must move, counted from the arrays of the linear solvers: each array once
/// a
/// pass over it, read or written (numbers of 8 bytes, indices of 4, signs of 1). Not counted are bytes that a cache
/// reads
/// before it writes, those that are found in the first cache again, and refinement. Mixtures of solvers are counted as
/// the
/// general one, which moves more. The triad (machine.hpp) is counted likewise.
struct Traffic {
  double bytes;        ///< moved by one evaluation
  double working_set;  ///< bytes of the arrays themselves
};

struct TrafficOf {
  tanor::LinearSolver solver;  ///< the only one of the system; General: there are several
  double points, rows;
  double entries;          ///< of S, one triangle
  double factor_nonzeros;  ///< of L
};

inline Traffic count_traffic(const TrafficOf& of) {
  constexpr double number = 8.0, vector = 24.0, index = 4.0, sign = 1.0;
  const double state = of.points * (3.0 * vector + number);  // r, v, w, 1/m
  const double rows = of.rows * (vector + number);           // block of K, lambda
  if (of.solver == tanor::LinearSolver::Paths) {
    // Elimination: r v 1/m sign -> block b y pivot factor. Substitution: 1/m sign block b y pivot factor -> lambda, w.
    const double each = sign + vector + 4.0 * number;
    return {state + of.points * number + of.rows * (2.0 * each + number), state + of.rows * each};
  }
  if (of.solver == tanor::LinearSolver::Batches) {
    // Index of point, row and block, r v 1/m -> L and D, block lambda w; the rest stays in a thread's workspace.
    const double bytes = state + rows + of.points * index + of.rows * 2.0 * index + of.factor_nonzeros * number;
    return {bytes, bytes};
  }
  if (of.solver == tanor::LinearSolver::ClosedForm) {
    // r v 1/m -> block lambda w; the 3 x 3 factors of points with more rows than one.
    const double bytes = state + rows + (of.rows > of.points ? 6.0 * number * of.points : 0.0);
    return {bytes, bytes};
  }
  // Evaluate: two indices, r v w -> block b. Assemble: term (two indices, weight), blocks -> S. Factorize: S -> L.
  // Solve: b, L twice -> lambda. Reactions: block lambda 1/m -> w. Residual: block w.
  const double plan = of.entries * (2.0 * index + number);
  const double set = state + rows + of.rows * (2.0 * index + number) + plan + of.entries * (number + index) +
                     of.factor_nonzeros * number;
  const double bytes = of.points * (6.0 * vector + number) + of.rows * (2.0 * index + 4.0 * vector + 4.0 * number) +
                       plan + of.entries * (2.0 * number + index) + 3.0 * of.factor_nonzeros * number;
  return {bytes, set};
}
