#pragma once

#include <filesystem>

namespace tanor::report {

/// Draws an SVG file into a PNG file by rsvg-convert (Debian: librsvg2-bin); false where that is not installed or
/// fails.
bool convert_to_png(const std::filesystem::path& svg, const std::filesystem::path& png);

}  // namespace tanor::report
