#pragma once

#include "scene/points.hpp"

namespace tanor::scene {

/// "import": {"file", "format", "bonds", "types", "angles", "mass"}, points, rods (named `rods`) and rigid
/// angles (named `angles`) of another program's file.
PointSet read_import(const Cursor& import, const Context& context);

}  // namespace tanor::scene
