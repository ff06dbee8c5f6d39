#include "report/text_formats.hpp"

#include <fmt/compile.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/compression.hpp"
#include "report/output_file.hpp"
#include "report/words.hpp"

namespace tanor::report {

namespace {

/// A text file that grows by one piece for each frame; each is complete before the next one begins. If the name ends in
/// ".gz", each piece is a separate gzip member, so that such a file can also be read whenever the program stops.
class TextTrajectory : public FrameFile {
 public:
  using Print = std::function<void(const Frame&, fmt::appender)>;
  /// Creates a file that begins with `head`, or continues an existing one.
  TextTrajectory(const FrameFileRequest& request, std::string_view head, Print print)
      : is_compressed_(request.path.extension() == ".gz"),
        print_(std::move(print)),
        file_(request.mark > 0 ? GrowingFile(request.path, request.mark, "")
                               : GrowingFile(request.path, pack(head), "")) {}

  void write(const Frame& frame) override {
    buffer_.clear();
    print_(frame, fmt::appender(buffer_));
    file_.append(pack({buffer_.data(), buffer_.size()}));
  }
  std::uint64_t mark() const override { return file_.body_size(); }
  void cut(std::uint64_t mark) override { file_.cut(mark); }
  void synchronize() override { file_.synchronize(); }

 private:
  std::string pack(std::string_view text) const {
    return is_compressed_ && !text.empty() ? gzip(text) : std::string(text);
  }

  bool is_compressed_;
  Print print_;
  GrowingFile file_;
  fmt::memory_buffer buffer_;
};

std::string describe_lattice(const std::optional<Cell>& cell) {
  if (!cell || !cell->is_periodic_everywhere()) return "";
  return fmt::format("Lattice=\"{}\" Origin=\"{}\" pbc=\"T T T\" ", fmt::join(edges_of(*cell), " "),
                     fmt::join(cell->origin, " "));
}

/// Returns "time s, length m, velocity m/s, force N", or nothing without letters.
std::string list_units(const Units& units) {
  std::string list;
  for (const auto& [what, letters] : {std::pair{"time", units.time},
                                      {"length", units.length},
                                      {"velocity", units.letters(Dimension::Velocity)},
                                      {"force", units.force}})
    if (!letters.empty()) list += fmt::format("{}{} {}", list.empty() ? "" : ", ", what, letters);
  return list;
}

/// Returns what dumps begin with, as LAMMPS' own do: the units, and the names that numbers in the columns stand for.
/// Its readers pass over one line, of less than 1024 letters.
std::string make_dump_head(const ShownParts& shown, const std::string& what, const std::vector<std::string>& names) {
  constexpr std::size_t most = 900;
  std::string line = list_units(shown.units);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const bool has_room = line.size() + names[k].size() < most;
    line += k > 0 ? ", " : line.empty() ? what : "; " + what;
    line += has_room ? names[k] : fmt::format("and {} more", names.size() - k);
    if (!has_room) break;
  }
  return line.empty() ? "" : "ITEM: UNITS\n" + line + "\n";
}

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

std::string name_with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() ? name : name + " [" + unit + "]";
}

/// Returns a text as a field of CSV, in quotes only where it needs them.
std::string cell(const std::string& text) {
  return text.find_first_of(",\"\n") == std::string::npos ? text : quote_csv(text);
}

std::string make_csv_head(const ShownParts& shown, bool has_cell) {
  const Units& units = shown.units;
  std::string head = cell(name_with_unit("t", units.time));
  const std::pair<const char*, std::string> parts[] = {{"", units.length}, {"v", units.letters(Dimension::Velocity)}};
  for (const Index point : shown.points)
    for (const auto& [part, unit] : parts)
      for (const char axis : {'x', 'y', 'z'})
        head += "," + cell(name_with_unit(fmt::format("{}{}{}", part, axis, point), unit));
  for (const std::string& name : shown.rod_names())
    head += "," + cell(name_with_unit("tension(" + name + ")", units.force));
  for (const char* part : {"box[0]", "box[1]", "box[2]", "origin"})
    for (const char axis : {'x', 'y', 'z'})
      if (has_cell) head += "," + cell(name_with_unit(fmt::format("{}.{}", part, axis), units.length));
  return head + "\n";
}

std::string make_observables_head(std::span<const Observed> observables, const Units& units) {
  std::string head = cell(name_with_unit("t", units.time));
  for (const Observed& each : observables)
    for (const std::string& name : column_names(each)) head += "," + cell(name_with_unit(name, each.unit));
  return head + "\n";
}

}  // namespace

std::unique_ptr<FrameFile> open_xyz(const FrameFileRequest& request) {
  std::string words = describe_lattice(request.cell);
  if (const std::string units = list_units(request.shown->units); !units.empty()) words += "Units=\"" + units + "\" ";
  const auto print = [shown = request.shown, words](const Frame& frame, fmt::appender out) {
    fmt::format_to(out, "{}\n{}Properties=species:S:1:pos:R:3:velo:R:3 Time={}\n", shown->num_points, words,
                   frame.time);
    for (std::size_t k = 0; k < shown->num_points; ++k) {
      const double *r = &frame.positions[3 * k], *v = &frame.velocities[3 * k];
      // This takes about 0.4 us for each point.
      fmt::format_to(out, FMT_COMPILE("{} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g}\n"),
                     shown->is_support[k] ? 'X' : 'C', r[0], r[1], r[2], v[0], v[1], v[2]);
    }
  };
  return std::make_unique<TextTrajectory>(request, "", print);
}

std::unique_ptr<FrameFile> open_csv(const FrameFileRequest& request) {
  std::string cell;
  if (request.cell)
    cell = fmt::format(",{},{}", fmt::join(edges_of(*request.cell), ","), fmt::join(request.cell->origin, ","));
  const auto print = [cell](const Frame& frame, fmt::appender out) {
    fmt::format_to(out, "{}", frame.time);
    for (std::size_t k = 0; k < frame.positions.size(); k += 3) {
      for (const double number : frame.positions.subspan(k, 3)) fmt::format_to(out, ",{}", number);
      for (const double number : frame.velocities.subspan(k, 3)) fmt::format_to(out, ",{}", number);
    }
    for (const double tension : frame.tensions) fmt::format_to(out, ",{}", tension);
    fmt::format_to(out, "{}\n", cell);
  };
  return std::make_unique<TextTrajectory>(request, make_csv_head(*request.shown, request.cell.has_value()), print);
}

std::unique_ptr<FrameFile> open_lammps_dump(const FrameFileRequest& request) {
  const auto print = [shown = request.shown, cell = request.cell](const Frame& frame, fmt::appender out) {
    print_head(frame, "ATOMS", shown->num_points, cell, out);
    fmt::format_to(out, "ITEM: ATOMS id type {} vx vy vz fx fy fz\n", is_periodic(cell) ? "xu yu zu" : "x y z");
    for (std::size_t k = 0; k < shown->num_points; ++k) {
      const double *r = &frame.positions[3 * k], *v = &frame.velocities[3 * k], *f = &frame.forces[3 * k];
      fmt::format_to(
          out, FMT_COMPILE("{} {} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g} {:.10g}\n"),
          shown->points[k] + 1, shown->is_support[k] ? 2 : 1, r[0], r[1], r[2], v[0], v[1], v[2], f[0], f[1], f[2]);
    }
  };
  std::vector<std::string> names;
  for (const auto& [slot, each] : request.shown->support_names)
    names.push_back(fmt::format("{} {}[{}]", request.shown->points[slot] + 1, each.name, each.number));
  return std::make_unique<TextTrajectory>(request, make_dump_head(*request.shown, "type 2: ", names), print);
}

std::unique_ptr<FrameFile> open_lammps_rod_dump(const FrameFileRequest& request) {
  const auto print = [shown = request.shown, cell = request.cell](const Frame& frame, fmt::appender out) {
    print_head(frame, "ENTRIES", shown->rods.size(), cell, out);
    fmt::format_to(out, "ITEM: ENTRIES index batom1 batom2 length tension group member\n");
    std::vector<double> places(frame.positions.begin(), frame.positions.end());
    const std::vector<double> images = gather_shifted_images(*shown, frame.positions);
    places.insert(places.end(), images.begin(), images.end());
    const std::vector<std::array<Index, 2>> points = shown->rod_points();
    std::size_t k = 0;
    shown->for_each_rod([&](const ShownParts::RodGroup& group, std::size_t member) {
      const auto [i, j] = shown->rods[k];
      const double *a = &places[3 * static_cast<std::size_t>(i)], *b = &places[3 * static_cast<std::size_t>(j)];
      fmt::format_to(out, FMT_COMPILE("{} {} {} {:.10g} {:.10g} {} {}\n"), k + 1, points[k][0] + 1, points[k][1] + 1,
                     std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), frame.tensions[k], group.number, member);
      ++k;
    });
  };
  std::vector<std::string> names;
  for (const ShownParts::RodGroup& each : request.shown->rod_groups)
    names.push_back(fmt::format("{} {}", each.number, each.name));
  return std::make_unique<TextTrajectory>(request, make_dump_head(*request.shown, "groups: ", names), print);
}

std::unique_ptr<FrameFile> open_observables(const FrameFileRequest& request) {
  const auto print = [](const Frame& frame, fmt::appender out) {
    fmt::format_to(out, "{}", frame.time);
    for (const Observed& each : frame.observables)
      for (const double number : each.values)
        fmt::format_to(out, ",{}", std::isnan(number) ? std::string() : fmt::to_string(number));
    fmt::format_to(out, "\n");
  };
  return std::make_unique<TextTrajectory>(request, make_observables_head(request.observables, request.units), print);
}

}  // namespace tanor::report
