#pragma once

#include <tanor/inverse_dynamics.hpp>

/// \file
/// The old name of <tanor/inverse_dynamics.hpp>, for one version.
namespace tanor {

using DirectProblem [[deprecated("its name is InverseDynamics")]] = InverseDynamics;

}  // namespace tanor
