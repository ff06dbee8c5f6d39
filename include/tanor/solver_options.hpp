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

struct SolverOptions {
  Form form = Form::Auto;
  Ordering ordering = Ordering::Auto;
  int threads = 0;  ///< OpenMP threads; 0: as many as OpenMP gives
};

}  // namespace tanor
