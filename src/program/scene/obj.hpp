#pragma once

#include <string>
#include <string_view>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Reads the vertices of a Wavefront .obj file, with the edges of its lines (`l`) and faces (`f`), each once. Indices
/// may be relative (negative), lines may be continued by a backslash, and `#` begins a comment anywhere. Other lines,
/// such as normals, textures, groups, curves and surfaces, are named as unread. `name` is the file's name for errors.
/// Throws InputError (without a place) naming file and line.
Imported read_obj(const std::string& name, std::string_view text);

}  // namespace tanor::scene
