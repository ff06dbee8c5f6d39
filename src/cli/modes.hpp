#pragma once

#include <tanor/modes.hpp>

#include "scene/scene.hpp"

namespace tanor::cli {

/// What a scene says about modes and buckling about one of its equilibria.
ModesOptions modes_options(const scene::Scene& scene);
BucklingOptions buckling_options(const scene::Scene& scene);

}  // namespace tanor::cli
