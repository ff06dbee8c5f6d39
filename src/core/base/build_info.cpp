#include <tanor/build_info.hpp>
#include <tanor/version.hpp>

#include "base/instruction_sets.hpp"

namespace tanor {
using namespace detail;

BuildInfo build_info() {
  return {TANOR_VERSION, TANOR_GPL != 0, TANOR_CHOLMOD_HAS_GPL != 0, name_of(instruction_set())};
}

std::string describe(const BuildInfo& build) {
  return "tanor " + build.version +
         "\nQR: " + (build.has_suitesparse_qr ? "SuiteSparseQR (GPL-2.0-or-later)" : "own (BSD-3-Clause)") +
         "\nCHOLMOD: LGPL-2.1-or-later, " +
         (build.cholmod_has_gpl_modules ? "beside GPL modules that tanor does not call" : "built without GPL modules") +
         "\ninstruction set: " + build.instruction_set;
}

}  // namespace tanor
