#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Reads the vertices (x, y, z) of a Stanford .ply file, ascii or binary of either byte order, with its edges
/// (`vertex1`, `vertex2`) and those of its faces and strips of triangles (`vertex_indices` or `vertex_index` of `face`
/// and `tristrips`), each once. Other elements and properties may hold anything, and are named as unread. `name` is the
/// file's name for errors. Throws InputError (without a place) naming file, and line or element.
Imported read_ply(const std::string& name, std::string_view text);

}  // namespace tanor::scene
