#pragma once

namespace tanor {

/// Order in which S = K'M^-1K is eliminated.
enum class Ordering { Auto, Amd, Metis, Nesdis, Natural };

/// Which of the paper's two forms answers: constraints K (19), (21), (23), or coordinates A (20), (22), (24).
enum class Form {
  Auto,     ///< the cheaper one by predicted flops, of those that the system has
  Normal,   ///< constraints are given
  Tangent,  ///< coordinates are given
  Both      ///< both are given; the cheaper one steps, the other one judges it in every `solve` and certificate
};

/// How friction that depends on the reactions is found (43).
enum class FrictionMethod {
  Auto,        ///< Anderson; Newton where that converges badly; enumeration where few contacts remain
  FixedPoint,  ///< (43) as it stands
  Anderson,    ///< (43), accelerated (Walker and Ni 2011, depth 5)
  Newton,      ///< semismooth, with the law's derivative; GMRES on the factor of S
  Enumeration  ///< all signs of the normal forces; Coulomb friction, up to 10 contacts an island
};

/// How S lambda = b is found in normal form. The ways agree to rounding; those that serve a structure alone fuse the
/// evaluation of the constraints with the elimination.
enum class Way {
  Auto,       ///< each island the shortest one that serves it
  General,    ///< assembly and sparse factorization
  Paths,      ///< every island is a path or a ring of rods: elimination along it, from both ends
  Trees,      ///< every island is a tree of rods, or closes a few rings: elimination from the leaves to the root
  Bundles,    ///< small islands of equal structure: eliminated side by side
  ClosedForm  ///< no constraint joins two moving points: point by point
};

struct SolverOptions {
  Form form = Form::Auto;
  Way way = Way::Auto;
  Ordering ordering = Ordering::Auto;
  int threads = 0;  ///< OpenMP threads; 0: as many as OpenMP gives
  FrictionMethod friction = FrictionMethod::Auto;
  /// Inside the steps of explicit methods on the general way a factor of S serves several places, by conjugate
  /// gradients, where that costs less than a factor each; false: never.
  bool reuse = true;
};

}  // namespace tanor
