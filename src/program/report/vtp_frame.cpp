#include "report/vtp_frame.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "report/compression.hpp"
#include "report/output_file.hpp"
#include "report/words.hpp"

namespace tanor::report {

namespace {

/// The XML of a frame, and the arrays that follow it in the order in which it names them.
class Document {
 public:
  explicit Document(bool is_compressed) : is_compressed_(is_compressed) {}

  void open(std::string_view element) { xml_ += fmt::format("<{}>\n", element); }
  void close(std::string_view element) { xml_ += fmt::format("</{}>\n", element); }

  /// Adds numbers as text in the XML itself.
  void add_text(std::string_view name, std::span<const double> numbers) {
    xml_ +=
        fmt::format("<DataArray type=\"Float64\" Name=\"{}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</DataArray>\n",
                    escape_xml(name), numbers.size(), fmt::join(numbers, " "));
  }
  /// Adds letters as VTK stores them: codes of characters, with a 0 behind them. Without letters it adds nothing.
  void add_text(std::string_view name, const std::string& letters) {
    if (letters.empty()) return;
    xml_ += fmt::format("<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">", name);
    for (const char code : letters) xml_ += fmt::format("{} ", static_cast<unsigned char>(code));
    xml_ += "0</Array>\n";
  }
  /// Adds one array that consists of two pieces.
  void add(std::string_view name, int components, std::span<const double> first, std::span<const double> second = {}) {
    add("Float64", name, components, {bytes_of(first), bytes_of(second)});
  }
  void add(std::string_view name, std::span<const std::int32_t> numbers) {
    add("Int32", name, 1, {bytes_of(numbers), {}});
  }
  void add(std::string_view name, std::span<const std::uint8_t> numbers) {
    add("UInt8", name, 1, {bytes_of(numbers), {}});
  }

  void write(OutputFile* file) const {
    file->write(xml_);
    file->write("<AppendedData encoding=\"raw\">\n_");
    for (const Pieces& pieces : arrays_) {
      const std::uint64_t size = size_of(pieces);
      if (!is_compressed_) file->write({reinterpret_cast<const char*>(&size), sizeof size});
      for (const std::string_view bytes : pieces) file->write(bytes);
    }
    file->write("\n</AppendedData>\n</VTKFile>\n");
  }

 private:
  using Pieces = std::array<std::string_view, 2>;
  static std::size_t size_of(const Pieces& pieces) { return pieces[0].size() + pieces[1].size(); }
  template <class Number>
  static std::string_view bytes_of(std::span<const Number> numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
  }

  void add(std::string_view type, std::string_view name, int components, const Pieces& pieces) {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        name, components, offset_);
    if (is_compressed_) {
      compressed_.push_back(compress_for_vtk(std::string(pieces[0]) + std::string(pieces[1])));
      arrays_.push_back({compressed_.back(), {}});
      offset_ += compressed_.back().size();
    } else {
      offset_ += sizeof(std::uint64_t) + size_of(pieces);
      arrays_.push_back(pieces);
    }
  }

  std::string xml_ = "<?xml version=\"1.0\"?>\n";
  bool is_compressed_;
  std::vector<Pieces> arrays_;          ///< bytes of the caller, or of `compressed_`
  std::deque<std::string> compressed_;  ///< a deque keeps their addresses
  std::size_t offset_ = 0;              ///< offset of the next array, from the byte after the underscore
};

constexpr std::string_view byte_order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// Returns numbers of the cells in VTK's order: vertices, then lines.
std::vector<double> collect_cells(std::size_t num_vertices, std::span<const double> of_rods) {
  std::vector<double> numbers(num_vertices, std::numeric_limits<double>::quiet_NaN());
  numbers.insert(numbers.end(), of_rods.begin(), of_rods.end());
  return numbers;
}

/// Supports are those that still hold.
std::vector<std::uint8_t> collect_supports(const ShownParts& shown, const GoneParts& gone) {
  std::vector<std::uint8_t> is_support(shown.is_support.begin(), shown.is_support.end());
  for (std::size_t k = 0; k < gone.supports.size(); ++k)
    if (!std::isnan(gone.supports[k])) is_support[k] = 0;
  for (const auto& [point, offset] : shown.images) is_support.push_back(is_support[static_cast<std::size_t>(point)]);
  return is_support;
}

void add_field(const Frame& frame, const ShownParts& shown, Document* document) {
  const Units& units = shown.units;
  document->open("FieldData");
  if (!frame.is_at_rest) document->add_text("TimeValue", {&frame.time, 1});
  document->add_text("gravity", frame.gravity);
  document->add_text("unit of time", units.time);
  document->add_text("unit of length", units.length);
  document->add_text("unit of mass", units.mass);
  document->add_text("unit of force", units.force);
  for (const ShownParts::RodGroup& group : shown.rod_groups)
    document->add_text(fmt::format("group {}", group.number), group.name);
  for (const Guide& guide : frame.guides) {
    const std::string name = fmt::format("guide {} {}", guide.kind, guide.name);
    document->add_text(name, guide.numbers);
    if (!std::isnan(guide.gone)) document->add_text("gone_since of " + name, {&guide.gone, 1});
  }
  document->close("FieldData");
}

}  // namespace

void write_vtp(const std::filesystem::path& path, const ShownParts& shown, const Frame& frame, bool is_compressed) {
  const std::size_t num_vertices = shown.loose_points.empty() ? 0 : 1;
  const std::vector<double> tensions = collect_cells(num_vertices, frame.tensions),
                            rods_gone = collect_cells(num_vertices, frame.gone.rods);
  std::vector<std::int32_t> groups(num_vertices, -1), members = groups;
  shown.for_each_rod([&](const ShownParts::RodGroup& group, std::size_t k) {
    groups.push_back(static_cast<std::int32_t>(group.number));
    members.push_back(static_cast<std::int32_t>(k));
  });
  const std::vector<std::int32_t> vertex_ends(num_vertices, static_cast<std::int32_t>(shown.loose_points.size()));
  std::vector<std::int32_t> rod_ends(shown.rods.size());  // 2, 4, 6, … in the list of all lines' points
  for (std::size_t k = 0; k < rod_ends.size(); ++k) rod_ends[k] = static_cast<std::int32_t>(2 * (k + 1));
  const std::span<const std::int32_t> rod_points{shown.rods.empty() ? nullptr : shown.rods.front().data(),
                                                 2 * shown.rods.size()};

  const std::vector<double> image_positions = gather_shifted_images(shown, frame.positions);
  const std::vector<double> image_velocities = gather_images(shown, frame.velocities);
  const std::vector<double> image_accelerations = gather_images(shown, frame.accelerations);
  const std::vector<double> image_forces(3 * shown.images.size()),
      images_gone(shown.images.size(), std::numeric_limits<double>::quiet_NaN());
  const std::vector<std::uint8_t> supports = collect_supports(shown, frame.gone);

  Document document(is_compressed);
  document.open(fmt::format(R"(VTKFile type="PolyData" version="1.0" byte_order="{}" header_type="UInt64"{})",
                            byte_order, is_compressed ? R"( compressor="vtkZLibDataCompressor")" : ""));
  document.open("PolyData");
  add_field(frame, shown, &document);
  document.open(fmt::format(
      R"(Piece NumberOfPoints="{}" NumberOfVerts="{}" NumberOfLines="{}" NumberOfStrips="0" NumberOfPolys="0")",
      shown.num_points + shown.images.size(), num_vertices, shown.rods.size()));
  document.open(R"(PointData Vectors="velocity")");
  document.add("velocity", 3, frame.velocities, image_velocities);
  document.add("acceleration", 3, frame.accelerations, image_accelerations);
  document.add("support", supports);
  if (!frame.gone.supports.empty()) document.add("gone_since", 1, frame.gone.supports, images_gone);
  if (!frame.guide_forces.empty()) document.add("guide_force", 3, frame.guide_forces, image_forces);
  if (!frame.friction_forces.empty()) document.add("friction_force", 3, frame.friction_forces, image_forces);
  document.close("PointData");
  document.open(R"(CellData Scalars="tension")");
  document.add("tension", 1, std::span<const double>(tensions));
  document.add("group", groups);
  document.add("member", members);
  if (!frame.gone.rods.empty()) document.add("gone_since", 1, std::span<const double>(rods_gone));
  document.close("CellData");
  document.open("Points");
  document.add("position", 3, frame.positions, image_positions);
  document.close("Points");
  document.open("Verts");
  document.add("connectivity", shown.loose_points);
  document.add("offsets", vertex_ends);
  document.close("Verts");
  document.open("Lines");
  document.add("connectivity", rod_points);
  document.add("offsets", rod_ends);
  document.close("Lines");
  document.close("Piece");
  document.close("PolyData");
  replace_file(path, [&](OutputFile* file) { document.write(file); });
}

VtpTrajectory::VtpTrajectory(const std::filesystem::path& directory, const ShownParts* shown, bool is_compressed,
                             std::uint64_t mark)
    : directory_(directory),
      shown_(shown),
      is_compressed_(is_compressed),
      list_(mark > 0 ? GrowingFile(directory / list_name, mark, list_tail)
                     : GrowingFile(directory / list_name, list_head, list_tail)) {
  make_folder(directory / frame_folder);
}

std::string VtpTrajectory::name_frame(std::size_t number) {
  return fmt::format("{}/frame_{:06}.vtp", frame_folder, number);
}

std::string VtpTrajectory::list_frame(double time, const std::string& file) {
  return fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n", time, file);
}

void VtpTrajectory::write(const Frame& frame) {
  const std::string name = name_frame(frame.number);
  last_ = directory_ / name;
  const std::uint64_t before = mark();
  try {
    write_vtp(last_, *shown_, frame, is_compressed_);
    list_.append(list_frame(frame.time, name));
  } catch (const WriteError&) {
    cut(before);
    throw;
  }
}

void VtpTrajectory::cut(std::uint64_t mark) {
  list_.cut(mark);
  std::error_code ignored;
  std::filesystem::remove(last_, ignored);
}

}  // namespace tanor::report
