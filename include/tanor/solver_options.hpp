#pragma once

namespace tanor {

// The words of these values in scenes, reports and messages stand in <tanor/enum_names.hpp>.

/// Elimination order of S = K'M^-1K.
enum class Ordering {
  Auto,     ///< the one of fewest flops, as far as the search for it pays
  Amd,      ///< approximate minimum degree
  Metis,    ///< nested dissection of the rows, by METIS
  Nesdis,   ///< likewise, by CHOLMOD
  Natural,  ///< the order of the rows, along the islands
  Axes,     ///< nested dissection by planes between the points, from their first positions
  Points    ///< nested dissection of the graph of points, by METIS
};

/// Form of the equations that answers: constraints K (19), (21), (23), or coordinates A (20), (22), (24).
enum class Form {
  Auto,     ///< the cheaper one, by predicted flops, of those that the system has
  Normal,   ///< requires constraints
  Tangent,  ///< requires coordinates
  Both      ///< requires both; the cheaper one steps, the other one verifies it in every `solve` and certificate
};

/// Method that finds friction that depends on the reactions (43).
enum class FrictionMethod {
  Auto,        ///< Anderson; Newton if that converges badly; enumeration if few contacts remain
  FixedPoint,  ///< plain iteration of (43)
  Anderson,    ///< accelerated iteration of (43) (Walker and Ni 2011, depth 5)
  Newton,      ///< semismooth, with the law's derivative; GMRES on the factor of S
  Enumeration  ///< all modes of few contacts; for Coulomb friction with up to 10 contacts per island
};

/// Solver of S lambda = -b in normal form, where S = K'M^-1K is the Schur complement of the mass matrix (Delassus
/// operator). The solvers agree to rounding. Those for one structure alone fuse the evaluation of the constraints with
/// the elimination.
enum class LinearSolver {
  Auto,        ///< the fastest one for each island
  General,     ///< assembly and sparse factorization
  Paths,       ///< Every island is a path or a ring of rods, which is eliminated from both ends.
  Trees,       ///< Every island is a tree of rods, or closes a few rings; it is eliminated from the leaves to the root.
  Batches,     ///< Small islands of equal structure are eliminated side by side.
  ClosedForm,  ///< No constraint joins two moving points; each point is solved by itself.
  Cholmod,     ///< General, but CHOLMOD factorizes and solves alone, also H = A'MA: an independent reference, slower
  Bundles [[deprecated("its name is Batches")]] = Batches
};
using Way [[deprecated("its name is LinearSolver")]] = LinearSolver;

/// Method that factorizes a sparse matrix.
enum class Factorization {
  Simplicial,    ///< column by column
  Multifrontal,  ///< in dense fronts
  ClosedForm     ///< row by row, for a matrix that is diagonal or has small blocks
};

/// Limits of constraints to one side. A motion that reaches one of them ends there, and says so.
struct ContactOptions {
  int max_at_one_instant = 100;  ///< impacts that follow one another at one instant, each of all rows that approach
  int max_events = 100000;       ///< changes of constraints to one side in a motion: snaps, touches, slips …
};

/// Options of a Dynamics, a Simulation or an InverseDynamics.
struct SolverOptions {
  Form form = Form::Auto;
  LinearSolver linear_solver = LinearSolver::Auto;
  Ordering ordering = Ordering::Auto;
  int threads = 0;  ///< OpenMP threads; 0 takes as many as OpenMP gives, which spin for some ms after a call
  FrictionMethod friction = FrictionMethod::Auto;
  /// True to let the general solver use one factor of S at several configurations inside the steps of explicit methods,
  /// by conjugate gradients, if that costs less than a factor for each.
  bool reuse = true;
  /// True to refine accelerations down to the rounding of K'w + phi where a caller of Dynamics or Constrainer asks for
  /// them, false to refine those alone whose residual is above 1e-12 of its largest term. The first solution of a
  /// general solver mostly is below that, and takes 0.7 to 0.9 of the time.
  bool exact = true;
  ContactOptions contact{};
};

}  // namespace tanor
