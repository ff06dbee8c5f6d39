#pragma once

#include <string>

#include <tanor/export.hpp>

namespace tanor {

/// What the library that is loaded was built of. It decides which licence a binary that contains it must follow.
struct BuildInfo {
  std::string version;           ///< TANOR_VERSION of the library; the macro is that of the headers
  bool has_suitesparse_qr;       ///< built with TANOR_GPL: calls SuiteSparseQR (GPL-2.0-or-later)
  bool cholmod_has_gpl_modules;  ///< the CHOLMOD at the build has them (Supernodal and others); tanor calls none
  /// Of the hot loops: "avx512", "avx2" or "baseline", the best that the processor has or the one that TANOR_ISA in the
  /// environment names.
  std::string instruction_set;
};
/// Throws InputError where TANOR_ISA names none, or one that cannot be had here.
TANOR_API BuildInfo build_info();

/// The same in four lines, as `tanor --version` prints it.
TANOR_API std::string describe(const BuildInfo& build);

}  // namespace tanor
