#pragma once

/// \file
/// Energies whose operations were recorded by a host in a language of its own, instead of by user_kernel.hpp.

#include <memory>

#include <tanor/kernel.hpp>

namespace tanor {

/// Makes a kernel from an energy of p points. The variables of `energy` are the 3p coordinates, c numbers that each
/// tuple has of its own, and t; its only result is the energy, J. Throws InputError if it has others.
TANOR_API PotentialKernel expression_potential(std::shared_ptr<const Expression> energy, int num_points,
                                               int num_constants = 0);

}  // namespace tanor
