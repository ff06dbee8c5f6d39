#include "report/xyz_trajectory.hpp"

#include <fmt/compile.h>

namespace tanor::report {

namespace {

constexpr std::size_t bytes_of_a_point = 80;

std::string describe_lattice(const std::optional<Cell>& cell) {
  if (!cell || !cell->is_periodic_everywhere()) return "";
  const Vector3& o = cell->origin;
  return fmt::format("Lattice=\"{} 0 0 {} {} 0 {} {} {}\" Origin=\"{} {} {}\" pbc=\"T T T\" ", cell->xx, cell->xy,
                     cell->yy, cell->xz, cell->yz, cell->zz, o[0], o[1], o[2]);
}

}  // namespace

XyzTrajectory::XyzTrajectory(const std::filesystem::path& path, const ShownParts* shown,
                             const std::optional<Cell>& cell, std::uint64_t mark)
    : TextTrajectory(path, "", mark), shown_(shown), lattice_(describe_lattice(cell)) {}

void XyzTrajectory::print(const Frame& frame, fmt::memory_buffer* text) const {
  text->reserve(bytes_of_a_point * (shown_->num_points + 2));
  auto out = fmt::appender(*text);
  fmt::format_to(out, "{}\n{}Properties=species:S:1:pos:R:3:velo:R:3 Time={}\n", shown_->num_points, lattice_,
                 frame.time);
  for (std::size_t k = 0; k < shown_->num_points; ++k) {
    const double* r = &frame.positions[3 * k];
    const double* v = &frame.velocities[3 * k];
    // This takes about 0.4 us for each point.
    fmt::format_to(out, FMT_COMPILE("{} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g}\n"),
                   shown_->is_support[k] ? 'X' : 'C', r[0], r[1], r[2], v[0], v[1], v[2]);
  }
}

}  // namespace tanor::report
