#pragma once

/// \file
/// Energies whose operations were taken down somewhere else than by user_kernel.hpp, by a host with a language of its
/// own.

#include <memory>

#include <tanor/kernel.hpp>

namespace tanor {

/// An energy of p points: the variables of `energy` are the 3p coordinates, c numbers that each tuple has of its own,
/// and t; it has one result, J. Throws InputError where it has others.
TANOR_API PotentialKernel expression_potential(std::shared_ptr<const Expression> energy, int num_points,
                                               int num_constants = 0);

}  // namespace tanor
