#pragma once

#include <filesystem>

namespace tanor::report {

/// Converts an SVG file into a PNG file by rsvg-convert (Debian: librsvg2-bin). Returns false if that is not installed
/// or fails.
bool convert_to_png(const std::filesystem::path& svg, const std::filesystem::path& png);

}  // namespace tanor::report
