#include "report/loglog_plot.hpp"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "report/words.hpp"

namespace tanor::report {

namespace {

constexpr double width = 640.0, height = 440.0, left = 80.0, right = 20.0, top = 40.0, bottom = 60.0;
constexpr std::array colors{"#0b6e99", "#c1440e", "#4c8c2b", "#7b4fa3", "#8a6d00",
                            "#222222", "#d1498b", "#2aa198", "#9a9a9a", "#5d4037"};

/// Returns true if both numbers have a logarithm.
bool is_shown(const std::array<double, 2>& point) {
  return std::all_of(point.begin(), point.end(), [](double x) { return x > 0.0 && std::isfinite(x); });
}

/// The whole decades around the data.
struct Axis {
  double low = 0.0, high = 1.0;  // exponents of ten

  Axis(const std::vector<PlotSeries>& series, std::size_t component) {
    double least = HUGE_VAL, most = 0.0;
    for (const PlotSeries& s : series) {
      for (const auto& point : s.points) {
        if (!is_shown(point)) continue;
        least = std::min(least, point[component]);
        most = std::max(most, point[component]);
      }
    }
    if (!(most > 0.0)) return;
    low = std::floor(std::log10(least));
    high = std::max(low + 1.0, std::ceil(std::log10(most)));
  }
  /// Returns the position of 10^exponent on the axis. The number itself may be too large for a double.
  double fraction(double exponent) const { return (exponent - low) / (high - low); }
  /// Returns the decades from label to label.
  double stride() const { return std::max(1.0, std::ceil((high - low) / 16.0)); }
};

}  // namespace

std::string make_loglog_plot(const LogLogPlot& plot) {
  const Axis x_axis(plot.series, 0), y_axis(plot.series, 1);
  const double inner_width = width - left - right, inner_height = height - top - bottom;
  // Positions of a power of ten.
  const auto x_of = [&](double exponent) { return left + inner_width * x_axis.fraction(exponent); };
  const auto y_of = [&](double exponent) { return top + inner_height * (1.0 - y_axis.fraction(exponent)); };

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n"
      "<text x=\"{2}\" y=\"24\" font-size=\"15\">{3}</text>\n",
      width, height, left, escape_xml(plot.title));
  // Draw grid lines with labels, at each decade if there are few.
  for (double e = x_axis.low; e <= x_axis.high; e += x_axis.stride()) {
    const double x = x_of(e);
    svg += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{0:.1f}\" y2=\"{2}\" stroke=\"#ddd\"/>"
        "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">1e{4:.0f}</text>\n",
        x, top, height - bottom, height - bottom + 18.0, e);
  }
  for (double e = y_axis.low; e <= y_axis.high; e += y_axis.stride()) {
    const double y = y_of(e);
    svg += fmt::format(
        "<line x1=\"{1}\" y1=\"{0:.1f}\" x2=\"{2}\" y2=\"{0:.1f}\" stroke=\"#ddd\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">1e{5:.0f}</text>\n",
        y, left, width - right, left - 8.0, y + 4.0, e);
  }
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", left + inner_width / 2,
                     height - 16.0, escape_xml(plot.x_label));
  svg += fmt::format("<text transform=\"translate(18 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     top + inner_height / 2, escape_xml(plot.y_label));
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    const PlotSeries& series = plot.series[k];
    const char* const color = colors[k % colors.size()];
    std::string line;
    for (const auto& point : series.points) {
      if (!is_shown(point)) continue;
      const double x = x_of(std::log10(point[0])), y = y_of(std::log10(point[1]));
      line += fmt::format("{:.1f},{:.1f} ", x, y);
      svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"/>\n", x, y, color);
    }
    svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n", line, color);
    const double y = top + 18.0 + 18.0 * static_cast<double>(k);
    svg += fmt::format(
        "<rect x=\"{}\" y=\"{}\" width=\"12\" height=\"12\" fill=\"{}\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
        width - right - 130.0, y - 10.0, color, width - right - 112.0, y, escape_xml(series.name));
  }
  return svg + "</svg>\n";
}

bool convert_to_png(const std::filesystem::path& svg, const std::filesystem::path& png) {
  std::array<std::string, 5> words{"rsvg-convert", "--zoom=2", "--output", png.string(), svg.string()};
  std::array<char*, 6> arguments{};
  for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
  pid_t process = 0;
  if (posix_spawnp(&process, arguments[0], nullptr, nullptr, arguments.data(), environ) != 0) return false;
  int status = 0;
  return waitpid(process, &status, 0) == process && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace tanor::report
