#include "report/xyz_trajectory.hpp"

#include <fmt/compile.h>

namespace tanor::report {

namespace {

constexpr std::size_t bytes_of_a_point = 80;

}  // namespace

XyzTrajectory::XyzTrajectory(const std::filesystem::path& path) : file_(path, "", "") {}
XyzTrajectory::XyzTrajectory(const std::filesystem::path& path, std::uint64_t size) : file_(path, size, "") {}

void XyzTrajectory::write(double time, const ShownParts& shown, std::span<const double> positions,
                          std::span<const double> velocities) {
  buffer_.clear();
  buffer_.reserve(bytes_of_a_point * (shown.num_points + 2));
  auto out = fmt::appender(buffer_);
  fmt::format_to(out, "{}\nProperties=species:S:1:pos:R:3:velo:R:3 Time={}\n", shown.num_points, time);
  for (std::size_t k = 0; k < shown.num_points; ++k) {
    const double* r = &positions[3 * k];
    const double* v = &velocities[3 * k];
    // About 0.4 us a point.
    fmt::format_to(out, FMT_COMPILE("{} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g}\n"),
                   shown.is_support[k] ? 'X' : 'C', r[0], r[1], r[2], v[0], v[1], v[2]);
  }
  file_.append({buffer_.data(), buffer_.size()});
}

}  // namespace tanor::report
