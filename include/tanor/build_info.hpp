#pragma once

#include <string>

#include <tanor/export.hpp>

namespace tanor {

/// Components of the loaded library. They decide which licence a binary that contains it must follow.
struct BuildInfo {
  std::string version;           ///< TANOR_VERSION of the library; the macro is that of the headers
  bool has_suitesparse_qr;       ///< true if built with TANOR_GPL: calls SuiteSparseQR (GPL-2.0-or-later)
  bool cholmod_has_gpl_modules;  ///< true if CHOLMOD had them at build time (Supernodal and others); tanor calls none
  /// Instruction set of the hot loops, "avx512", "avx2" or "baseline": the best of the processor, or the one that
  /// TANOR_ISA in the environment names.
  std::string instruction_set;
};
/// Returns the components. Throws InputError if TANOR_ISA names no instruction set, or one that is not available here.
TANOR_API BuildInfo build_info();

/// Returns the same in four lines, as `tanor --version` prints it.
TANOR_API std::string describe(const BuildInfo& build);

}  // namespace tanor
