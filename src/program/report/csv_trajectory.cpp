#include "report/csv_trajectory.hpp"

namespace tanor::report {

namespace {

std::string make_head(const ShownParts& shown) {
  std::string head = "t";
  for (const Index point : shown.points) head += fmt::format(",x{0},y{0},z{0},vx{0},vy{0},vz{0}", point);
  for (const auto& [i, j] : shown.rods) {
    const auto beyond = j - static_cast<std::int32_t>(shown.num_points);  // an image of a point
    const std::int32_t end = beyond < 0 ? j : shown.images[static_cast<std::size_t>(beyond)].point;
    head += fmt::format(",tension{}_{}", shown.points[static_cast<std::size_t>(i)],
                        shown.points[static_cast<std::size_t>(end)]);
  }
  return head + "\n";
}

}  // namespace

CsvTrajectory::CsvTrajectory(const std::filesystem::path& path, const ShownParts& shown, std::uint64_t mark)
    : TextTrajectory(path, make_head(shown), mark) {}

void CsvTrajectory::print(const Frame& frame, fmt::memory_buffer* text) const {
  auto out = fmt::appender(*text);
  fmt::format_to(out, "{}", frame.time);
  for (std::size_t k = 0; k < frame.positions.size(); k += 3) {
    for (const double number : frame.positions.subspan(k, 3)) fmt::format_to(out, ",{}", number);
    for (const double number : frame.velocities.subspan(k, 3)) fmt::format_to(out, ",{}", number);
  }
  for (const double tension : frame.tensions) fmt::format_to(out, ",{}", tension);
  fmt::format_to(out, "\n");
}

}  // namespace tanor::report
