/// \file Refuses in the place of damped_mode_finder.cpp, in a build without Spectra.

#include <string>

#include <tanor/error.hpp>

#include "statics/damped_mode_finder.hpp"

namespace tanor::detail {

DampedModeFinder::Found find_lowest_damped_modes(EquilibriumEquations&, Eigen::SparseMatrix<double>, std::size_t,
                                                 std::size_t freedoms, double, double) {
  throw InputError("/modes/damped", "found true with " + std::to_string(freedoms) +
                                        " degrees of freedom; this tanor was built without Spectra and finds damped "
                                        "modes of small systems only");
}

}  // namespace tanor::detail
