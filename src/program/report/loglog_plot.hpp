#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace tanor::report {

/// A line of a plot. Points whose x or y has no logarithm are not shown.
struct PlotSeries {
  std::string name;
  std::vector<std::array<double, 2>> points;
};

struct LogLogPlot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
};

/// Returns a picture with logarithmic axes as SVG text.
std::string make_loglog_plot(const LogLogPlot& plot);

/// Converts an SVG file into a PNG file by rsvg-convert (Debian: librsvg2-bin). Returns false if that is not installed
/// or fails.
bool convert_to_png(const std::filesystem::path& svg, const std::filesystem::path& png);

}  // namespace tanor::report
