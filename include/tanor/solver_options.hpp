#pragma once

namespace tanor {

/// Order in which S = K'M^-1K is eliminated.
enum class Ordering { Auto, Amd, Metis, Nesdis, Natural };

struct SolverOptions {
  Ordering ordering = Ordering::Auto;
  int threads = 0;  ///< OpenMP threads; 0: as many as OpenMP gives
};

}  // namespace tanor
