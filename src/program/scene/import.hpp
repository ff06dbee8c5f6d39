#pragma once

#include "scene/points.hpp"

namespace tanor::scene {

/// Reads "import": {"file", "format", "bonds", "types", "angles", "mass"}. Returns points, rods (named `rods`) and
/// rigid angles (named `angles`) of another program's file.
PointSet read_import(const Cursor& import, const Context& context);

}  // namespace tanor::scene
