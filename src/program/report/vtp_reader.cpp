#include "report/vtp_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include <tanor/error.hpp>

#include "report/compression.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace {

/// Reads the tags of the XML that vtp_frame.cpp writes, one by one, and the text after each.
class Tags {
 public:
  explicit Tags(std::string_view xml) : rest_(xml) {}

  bool next() {
    const std::size_t begin = rest_.find('<');
    const std::size_t end = begin == std::string_view::npos ? begin : rest_.find('>', begin);
    if (end == std::string_view::npos) return false;
    tag_ = rest_.substr(begin + 1, end - begin - 1);
    rest_.remove_prefix(end + 1);
    return true;
  }
  std::string_view name() const { return tag_.substr(0, tag_.find(' ')); }
  std::string_view text() const { return rest_.substr(0, rest_.find('<')); }

  /// Returns the value of an attribute; empty if it is missing.
  std::string attribute(std::string_view key) const {
    const std::string wanted = fmt::format(" {}=\"", key);
    const std::size_t at = tag_.find(wanted);
    if (at == std::string_view::npos) return {};
    const std::size_t begin = at + wanted.size();
    return without_entities(tag_.substr(begin, tag_.find('"', begin) - begin));
  }

 private:
  static std::string without_entities(std::string_view text) {
    std::string result;
    for (std::size_t k = 0; k < text.size();) {
      const std::string_view rest = text.substr(k);
      std::size_t taken = 0;
      for (const auto& [entity, letter] : {std::pair{"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&amp;", '&'}}) {
        if (!rest.starts_with(entity)) continue;
        result += letter;
        taken = std::strlen(entity);
      }
      if (taken == 0) result += rest[0];
      k += std::max<std::size_t>(taken, 1);
    }
    return result;
  }

  std::string_view rest_, tag_;
};

/// The XML of a frame, and the arrays after it by "<section>/<name>".
class VtpFile {
 public:
  explicit VtpFile(const std::filesystem::path& path) : path_(path.string()), bytes_(scene::read_text(path)) {
    head_.time = NAN;  // a state of rest has none
    constexpr std::string_view mark = "<AppendedData encoding=\"raw\">\n_";
    const std::size_t end = bytes_.find(mark);
    if (end == std::string::npos || !bytes_.ends_with("</VTKFile>\n")) fail();
    arrays_ = std::string_view(bytes_).substr(end + mark.size());
    read_head(std::string_view(bytes_).substr(0, end));
  }

  const StoredFrame& head() const { return head_; }
  std::size_t num_points() const { return num_points_; }
  std::size_t num_rods() const { return num_rods_; }
  std::size_t num_vertices() const { return num_vertices_; }

  /// Returns `count` numbers of an array, or nothing if there is no such array.
  template <class Number>
  std::vector<Number> read(const std::string& key, std::size_t count) const {
    const auto found = offsets_.find(key);
    if (found == offsets_.end()) return {};
    const std::string decoded = decode(found->second, count * sizeof(Number));
    std::vector<Number> numbers(count);
    if (count > 0) std::memcpy(numbers.data(), decoded.data(), decoded.size());
    return numbers;
  }

  [[noreturn]] void fail() const { throw InputError(path_, "is damaged, or no frame of a trajectory of this tanor"); }

 private:
  void read_head(std::string_view xml) {
    Tags tags(xml);
    std::string section;
    while (tags.next()) {
      const std::string name(tags.name());
      if (name == "VTKFile") is_compressed_ = !tags.attribute("compressor").empty();
      if (name == "Piece") {
        num_points_ = count(tags.attribute("NumberOfPoints"));
        num_vertices_ = count(tags.attribute("NumberOfVerts"));
        num_rods_ = count(tags.attribute("NumberOfLines"));
      }
      if (name == "Array") take_text(tags.attribute("Name"), tags.text());
      if (name != "DataArray") {
        if (!name.starts_with('/')) section = name;
        continue;
      }
      if (tags.attribute("format") == "ascii")
        take_field(tags.attribute("Name"), tags.text());
      else
        offsets_[section + "/" + tags.attribute("Name")] = count(tags.attribute("offset"));
    }
  }

  std::size_t count(const std::string& word) const {
    const std::optional<std::int64_t> number = scene::parse_integer(word);
    if (!number || *number < 0 || static_cast<std::size_t>(*number) > bytes_.size()) fail();
    return static_cast<std::size_t>(*number);
  }

  /// Reads the letters of a unit: codes of characters, with a 0 behind them.
  void take_text(const std::string& name, std::string_view codes) {
    std::string text;
    for (const std::string_view word : scene::split_words(codes))
      if (const std::size_t code = count(std::string(word)); code > 0) text += static_cast<char>(code);
    if (name == "unit of time") head_.time_unit = text;
    if (name == "unit of force") head_.force_unit = text;
  }

  /// Reads a field "TimeValue", "gravity", "guide <kind> <name>" or "gone_since of …" behind it.
  void take_field(const std::string& name, std::string_view text) {
    std::vector<double> numbers;
    for (const std::string_view word : scene::split_words(text)) {
      const std::optional<double> number = scene::parse_number(word);
      if (!number) fail();
      numbers.push_back(*number);
    }
    constexpr std::string_view guide = "guide ";
    if (name == "TimeValue" && numbers.size() == 1) head_.time = numbers[0];
    if (name == "gravity" && numbers.size() == 3) std::copy_n(numbers.begin(), 3, head_.gravity.begin());
    if (name.starts_with("gone_since") && numbers.size() == 1 && !head_.guides.empty())
      head_.guides.back().gone = numbers[0];
    if (!name.starts_with(guide)) return;
    const std::size_t end = name.find(' ', guide.size());
    if (end == std::string::npos) fail();
    const std::string kind = name.substr(guide.size(), end - guide.size());
    static const std::map<std::string, std::size_t> sizes{{"plane", 4},      {"sphere", 4}, {"line", 6}, {"circle", 7},
                                                          {"ellipsoid", 12}, {"helix", 9},  {"cell", 12}};
    const auto size = sizes.find(kind);
    if (size != sizes.end() && numbers.size() != size->second) fail();
    head_.guides.push_back({kind, name.substr(end + 1), std::move(numbers)});
  }

  /// Returns the array at an offset, where its number of bytes or the sizes of its compressed blocks precede it.
  std::string decode(std::size_t offset, std::size_t wanted) const {
    if (offset > arrays_.size()) fail();
    std::string_view rest = arrays_.substr(offset);
    if (is_compressed_) {
      const std::optional<std::string> bytes = decompress_for_vtk(rest, wanted);
      if (!bytes) fail();
      return *bytes;
    }
    std::uint64_t size = 0;
    if (rest.size() < sizeof size) fail();
    std::memcpy(&size, rest.data(), sizeof size);
    rest.remove_prefix(sizeof size);
    if (size != wanted || rest.size() < wanted) fail();
    return std::string(rest.substr(0, wanted));
  }

  std::string path_, bytes_;
  std::string_view arrays_;  ///< part of bytes_
  std::map<std::string, std::size_t> offsets_;
  bool is_compressed_ = false;
  std::size_t num_points_ = 0, num_rods_ = 0, num_vertices_ = 0;
  StoredFrame head_;
};

bool are_small(const std::vector<double>& numbers) {
  return std::ranges::all_of(numbers, [](double x) { return std::abs(x) <= largest_place; });
}

}  // namespace

void leave_out_gone(StoredFrame* frame) {
  const auto is_gone = [&](double since) { return since <= frame->time; };
  for (std::size_t k = 0; k < frame->supports_gone.size(); ++k)
    frame->is_support[k] = frame->is_support[k] && !is_gone(frame->supports_gone[k]);
  std::erase_if(frame->guides, [&](const Guide& guide) { return is_gone(guide.gone); });
  std::size_t left = 0;
  for (std::size_t k = 0; k < frame->rods.size(); ++k) {
    if (k < frame->rods_gone.size() && is_gone(frame->rods_gone[k])) continue;
    frame->rods[left] = frame->rods[k];
    frame->tensions[left++] = frame->tensions[k];
  }
  frame->rods.resize(left);
  frame->tensions.resize(left);
}

StoredFrame read_vtp(const std::filesystem::path& path) {
  const VtpFile file(path);
  StoredFrame frame = file.head();
  const std::size_t m = file.num_points();
  frame.positions = file.read<double>("Points/position", 3 * m);
  frame.velocities = file.read<double>("PointData/velocity", 3 * m);
  frame.guide_forces = file.read<double>("PointData/guide_force", 3 * m);
  frame.friction_forces = file.read<double>("PointData/friction_force", 3 * m);
  const std::vector<std::uint8_t> supports = file.read<std::uint8_t>("PointData/support", m);
  if (frame.positions.size() != 3 * m || frame.velocities.size() != 3 * m || supports.size() != m) file.fail();
  if (m == 0 || !are_small(frame.positions) || !are_small(frame.velocities)) file.fail();
  frame.is_support.assign(supports.begin(), supports.end());

  // The numbers are those of all cells, of which vertices come first.
  const std::vector<std::int32_t> ends = file.read<std::int32_t>("Lines/connectivity", 2 * file.num_rods());
  frame.tensions = file.read<double>("CellData/tension", file.num_vertices() + file.num_rods());
  if (ends.size() != 2 * file.num_rods() || frame.tensions.size() != file.num_vertices() + file.num_rods()) file.fail();
  frame.rods_gone = file.read<double>("CellData/gone_since", frame.tensions.size());
  frame.supports_gone = file.read<double>("PointData/gone_since", m);
  for (std::vector<double>* each : {&frame.tensions, &frame.rods_gone})
    if (!each->empty()) each->erase(each->begin(), each->begin() + static_cast<std::ptrdiff_t>(file.num_vertices()));
  for (std::size_t k = 0; k < ends.size(); k += 2) {
    for (const std::int32_t end : {ends[k], ends[k + 1]})
      if (end < 0 || static_cast<std::size_t>(end) >= m) file.fail();
    frame.rods.push_back({ends[k], ends[k + 1]});
  }
  return frame;
}

std::vector<ListedFrame> read_frame_list(const std::filesystem::path& path) {
  const std::string xml = scene::read_text(path);
  std::vector<ListedFrame> frames;
  Tags tags(xml);
  while (tags.next()) {
    if (tags.name() != "DataSet") continue;
    const std::optional<double> time = scene::parse_number(tags.attribute("timestep"));
    const std::string file = tags.attribute("file");
    const bool is_name = !file.empty() && std::ranges::none_of(file, [](unsigned char c) { return c < ' '; });
    if (!time || !is_name || (!frames.empty() && *time < frames.back().time))
      throw InputError(path.string(), "is damaged, or no list of frames of this tanor");
    frames.push_back({*time, path.parent_path() / file});
  }
  return frames;
}

}  // namespace tanor::report
