#include "report/lammps_dump.hpp"

#include <fmt/compile.h>

#include <algorithm>
#include <cmath>

namespace tanor::report {

namespace {

bool is_periodic(const std::optional<Cell>& cell) {
  return cell && cell->is_periodic_everywhere();
}

/// Prints the corners of the periodic cell, or of a box around the points.
void print_box(const Frame& frame, const std::optional<Cell>& cell, fmt::appender out) {
  if (is_periodic(cell)) {
    const auto [x, y, z] = cell->origin;
    if (!cell->is_tilted()) {
      fmt::format_to(out, "ITEM: BOX BOUNDS pp pp pp\n{} {}\n{} {}\n{} {}\n", x, x + cell->xx, y, y + cell->yy, z,
                     z + cell->zz);
      return;
    }
    // LAMMPS describes a tilted cell by the box around it.
    const auto [x_low, x_high] = std::minmax({0.0, cell->xy, cell->xz, cell->xy + cell->xz});
    const auto [y_low, y_high] = std::minmax({0.0, cell->yz});
    fmt::format_to(out, "ITEM: BOX BOUNDS xy xz yz pp pp pp\n{} {} {}\n{} {} {}\n{} {} {}\n", x + x_low,
                   x + cell->xx + x_high, cell->xy, y + y_low, y + cell->yy + y_high, cell->xz, z, z + cell->zz,
                   cell->yz);
    return;
  }
  fmt::format_to(out, "ITEM: BOX BOUNDS ss ss ss\n");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t k = axis; k < frame.positions.size(); k += 3) {
      low = std::min(low, frame.positions[k]);
      high = std::max(high, frame.positions[k]);
    }
    // LAMMPS does not accept a flat box.
    const double room = high > low ? 1e-3 * (high - low) : 0.5;
    fmt::format_to(out, "{:.10g} {:.10g}\n", low - room, high + room);
  }
}

void print_head(const Frame& frame, const char* things, std::size_t count, const std::optional<Cell>& cell,
                fmt::appender out) {
  fmt::format_to(out, "ITEM: TIME\n{}\nITEM: TIMESTEP\n{}\nITEM: NUMBER OF {}\n{}\n", frame.time, frame.number, things,
                 count);
  print_box(frame, cell, out);
}

}  // namespace

LammpsDump::LammpsDump(const std::filesystem::path& path, const ShownParts* shown, const std::optional<Cell>& cell,
                       std::uint64_t mark)
    : TextTrajectory(path, "", mark), shown_(shown), cell_(cell) {}

void LammpsDump::print(const Frame& frame, fmt::memory_buffer* text) const {
  auto out = fmt::appender(*text);
  print_head(frame, "ATOMS", shown_->num_points, cell_, out);
  fmt::format_to(out, "ITEM: ATOMS id type {} vx vy vz fx fy fz\n", is_periodic(cell_) ? "xu yu zu" : "x y z");
  for (std::size_t k = 0; k < shown_->num_points; ++k) {
    const double* r = &frame.positions[3 * k];
    const double* v = &frame.velocities[3 * k];
    const double* f = &frame.forces[3 * k];
    fmt::format_to(out, FMT_COMPILE("{} {} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g}\n"),
                   shown_->points[k] + 1, shown_->is_support[k] ? 2 : 1, r[0], r[1], r[2], v[0], v[1], v[2], f[0], f[1],
                   f[2]);
  }
}

LammpsRodDump::LammpsRodDump(const std::filesystem::path& path, const ShownParts* shown,
                             const std::optional<Cell>& cell, std::uint64_t mark)
    : TextTrajectory(path, "", mark), shown_(shown), cell_(cell) {}

void LammpsRodDump::print(const Frame& frame, fmt::memory_buffer* text) const {
  auto out = fmt::appender(*text);
  print_head(frame, "ENTRIES", shown_->rods.size(), cell_, out);
  fmt::format_to(out, "ITEM: ENTRIES index batom1 batom2 length tension\n");
  const std::vector<double> images = gather_shifted_images(*shown_, frame.positions);
  for (std::size_t k = 0; k < shown_->rods.size(); ++k) {
    const auto [i, j] = shown_->rods[k];
    const auto beyond = j - static_cast<std::int32_t>(shown_->num_points);  // an image of a point
    const double* a = &frame.positions[3 * static_cast<std::size_t>(i)];
    const double* b =
        beyond < 0 ? &frame.positions[3 * static_cast<std::size_t>(j)] : &images[3 * static_cast<std::size_t>(beyond)];
    const std::int32_t end = beyond < 0 ? j : shown_->images[static_cast<std::size_t>(beyond)].point;
    fmt::format_to(out, FMT_COMPILE("{} {} {} {:.10g} {:.10g}\n"), k + 1,
                   shown_->points[static_cast<std::size_t>(i)] + 1, shown_->points[static_cast<std::size_t>(end)] + 1,
                   std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), frame.tensions[k]);
  }
}

}  // namespace tanor::report
