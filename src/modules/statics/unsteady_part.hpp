#pragma once

#include <optional>
#include <string>

#include <tanor/system.hpp>

#include "statics/steady_frame.hpp"

namespace tanor::detail {

/// Where a description stands in the scene, and why nothing rests with it.
struct UnsteadyPart {
  std::string where, what;
};

/// Finds a function of time that no frame could carry along: one that is no exponential polynomial, as all steady
/// motions are, or that is not known for all times.
std::optional<UnsteadyPart> find_unknown_function(const System& system);

/// Finds a support, a constraint or a force that is not the same at all times for what rests in a frame, or that acts
/// on what moves with it. Of points that the frame carries along, constraints and energies are evaluated as exponential
/// polynomials of the time since t: what is steady keeps no term but a constant.
std::optional<UnsteadyPart> find_unsteady_part(const System& system, const SteadyFrame& frame, double t,
                                               double scene_size);

}  // namespace tanor::detail
