#include "report/vtp_frame.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "report/output_file.hpp"

namespace tanor::report {

namespace {

/// The XML of a frame, and the arrays that follow it in the order in which it names them.
class Document {
 public:
  void open(std::string_view element) { xml_ += fmt::format("<{}>\n", element); }
  void close(std::string_view element) { xml_ += fmt::format("</{}>\n", element); }

  void add_text(std::string_view name, double value) {
    xml_ += fmt::format(
        "<DataArray type=\"Float64\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n", name, value);
  }
  /// One array of two pieces.
  void add(std::string_view name, int components, std::span<const double> first, std::span<const double> second = {}) {
    add("Float64", name, components, {bytes_of(first), bytes_of(second)});
  }
  void add(std::string_view name, std::span<const std::int32_t> numbers) {
    add("Int32", name, 1, {bytes_of(numbers), {}});
  }

  void write(OutputFile* file) const {
    file->write(xml_);
    file->write("<AppendedData encoding=\"raw\">\n_");
    for (const Pieces& pieces : arrays_) {
      const std::uint64_t size = size_of(pieces);
      file->write({reinterpret_cast<const char*>(&size), sizeof size});
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
    offset_ += sizeof(std::uint64_t) + size_of(pieces);
    arrays_.push_back(pieces);
  }

  std::string xml_ = "<?xml version=\"1.0\"?>\n";
  std::vector<Pieces> arrays_;  ///< not ours
  std::size_t offset_ = 0;      ///< of the next array, from the byte behind the underscore
};

constexpr std::string_view byte_order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";

/// Tensions of the cells in VTK's order: vertices, then lines.
std::vector<double> collect_tensions(const ShownParts& shown, std::size_t num_vertices,
                                     std::span<const double> multipliers) {
  std::vector<double> tensions(num_vertices, std::numeric_limits<double>::quiet_NaN());
  // tension = -lambda
  for (const std::size_t row : shown.rod_rows) tensions.push_back(-multipliers[row]);
  return tensions;
}

}  // namespace

void write_vtp(const std::filesystem::path& path, const ShownParts& shown, const VtpFrame& frame) {
  const std::size_t num_vertices = shown.loose_points.empty() ? 0 : 1;
  const std::vector<double> tensions = collect_tensions(shown, num_vertices, frame.multipliers);
  const std::vector<std::int32_t> vertex_ends(num_vertices, static_cast<std::int32_t>(shown.loose_points.size()));
  std::vector<std::int32_t> rod_ends(shown.rods.size());  // 2, 4, 6, … in the list of all lines' points
  for (std::size_t k = 0; k < rod_ends.size(); ++k) rod_ends[k] = static_cast<std::int32_t>(2 * (k + 1));
  const std::span<const std::int32_t> rod_points{shown.rods.empty() ? nullptr : shown.rods.front().data(),
                                                 2 * shown.rods.size()};

  const std::vector<double> image_positions = gather_shifted_images(shown, frame.positions);
  const std::vector<double> image_velocities = gather_images(shown, frame.velocities);
  const std::vector<double> image_accelerations = gather_images(shown, frame.accelerations);

  Document document;
  document.open(
      fmt::format(R"(VTKFile type="PolyData" version="1.0" byte_order="{}" header_type="UInt64")", byte_order));
  document.open("PolyData");
  document.open("FieldData");
  document.add_text("TimeValue", frame.time);
  document.close("FieldData");
  document.open(fmt::format(
      R"(Piece NumberOfPoints="{}" NumberOfVerts="{}" NumberOfLines="{}" NumberOfStrips="0" NumberOfPolys="0")",
      shown.num_points + shown.images.size(), num_vertices, shown.rods.size()));
  document.open(R"(PointData Vectors="velocity")");
  document.add("velocity", 3, frame.velocities, image_velocities);
  document.add("acceleration", 3, frame.accelerations, image_accelerations);
  document.close("PointData");
  document.open(R"(CellData Scalars="tension")");
  document.add("tension", 1, tensions);
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

}  // namespace tanor::report
