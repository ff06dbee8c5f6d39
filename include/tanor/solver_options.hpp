#pragma once

namespace tanor {

// The words of all these in scenes, reports and messages stand in <tanor/enum_names.hpp>.

/// Order in which S = K'M^-1K is eliminated.
enum class Ordering {
  Auto,     ///< the one of fewest flops, as far as looking for it repays
  Amd,      ///< approximate minimum degree
  Metis,    ///< nested dissection of the rows, by METIS
  Nesdis,   ///< likewise, by CHOLMOD
  Natural,  ///< as the rows stand, along the islands
  Axes,     ///< nested dissection by planes between the points, from their first positions
  Points    ///< nested dissection of the graph of points, by METIS
};

/// Which of the paper's two forms answers: constraints K (19), (21), (23), or coordinates A (20), (22), (24).
enum class Form {
  Auto,     ///< the cheaper one by predicted flops, of those that the system has
  Normal,   ///< constraints are given
  Tangent,  ///< coordinates are given
  Both      ///< both are given; the cheaper one steps, the other one verifies it in every `solve` and certificate
};

/// How friction that depends on the reactions is found (43).
enum class FrictionMethod {
  Auto,        ///< Anderson; Newton where that converges badly; enumeration where few contacts remain
  FixedPoint,  ///< (43) as it stands
  Anderson,    ///< (43), accelerated (Walker and Ni 2011, depth 5)
  Newton,      ///< semismooth, with the law's derivative; GMRES on the factor of S
  Enumeration  ///< all signs of the normal forces; Coulomb friction, up to 10 contacts an island
};

/// What solves S lambda = -b in normal form, S = K'M^-1K being the Schur complement of the mass matrix (Delassus
/// operator). The solvers agree to rounding. Those that serve one structure alone fuse the evaluation of the
/// constraints with the elimination.
enum class LinearSolver {
  Auto,        ///< for each island the fastest one that serves it
  General,     ///< assembly and sparse factorization
  Paths,       ///< Every island is a path or a ring of rods, which is eliminated from both ends.
  Trees,       ///< Every island is a tree of rods, or closes a few rings; it is eliminated from the leaves to the root.
  Batches,     ///< Small islands of equal structure are eliminated side by side.
  ClosedForm,  ///< No constraint joins two moving points; each point is solved by itself.
  Bundles [[deprecated("its name is Batches")]] = Batches
};
using Way [[deprecated("its name is LinearSolver")]] = LinearSolver;

/// How a sparse matrix is factorized.
enum class Factorization {
  Simplicial,    ///< column by column
  Multifrontal,  ///< in dense fronts
  ClosedForm     ///< the matrix is diagonal, or has small blocks: row by row
};

/// Options of a Dynamics, a Simulation or an InverseDynamics.
struct SolverOptions {
  Form form = Form::Auto;
  LinearSolver linear_solver = LinearSolver::Auto;
  Ordering ordering = Ordering::Auto;
  int threads = 0;  ///< OpenMP threads; 0: as many as OpenMP gives, which spin for some ms behind a call
  FrictionMethod friction = FrictionMethod::Auto;
  /// Inside the steps of explicit methods the general solver uses a factor of S at several configurations, by conjugate
  /// gradients, where that costs less than a factor each. false: it never does.
  bool reuse = true;
};

}  // namespace tanor
