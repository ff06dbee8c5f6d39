#include "formats/npz_trajectory.hpp"

#include <fmt/format.h>
#include <zip.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include <tanor/error.hpp>

#include "report/frame_file.hpp"
#include "report/npy.hpp"
#include "report/output_file.hpp"

namespace tanor::report {

namespace {

constexpr std::array<const char*, 4> row_names{"position", "velocity", "acceleration", "tension"};

constexpr const char* observables_key = "observables";

/// Returns the type of a row of observables as numpy describes it: [('t', '<f8'), ('load(hook)', '<f8', (3,)), …]. Its
/// head is ASCII, so letters beyond that are there by number, as Python writes them.
std::string describe_record(std::span<const Observed> observables) {
  std::string type = "[('t', '<f8')";
  for (const Observed& each : observables) {
    std::string name;
    for (auto c = each.name.begin(); c != each.name.end();) {
      const unsigned first = static_cast<unsigned char>(*c);
      std::uint32_t code =
          first < 0x80 ? first : first & (0x1Fu >> ((first >= 0xE0 ? 1 : 0) + (first >= 0xF0 ? 1 : 0)));
      while (++c != each.name.end() && (*c & 0xC0) == 0x80) code = code << 6 | (*c & 0x3Fu);
      const bool is_plain = code >= ' ' && code < 127 && code != '\'' && code != '\\';
      name += is_plain ? std::string(1, static_cast<char>(code)) : fmt::format("\\U{:08x}", code);
    }
    std::string shape;
    if (!each.members.empty()) shape += fmt::format("{},", each.members.size());
    if (!each.parts.empty()) shape += fmt::format("{},", each.parts.size());
    type += fmt::format(", ('{}', '<f8'{})", name, shape.empty() ? "" : ", (" + shape + ")");
  }
  return type + "]";
}

/// Texts of one width, as numpy stores them.
struct PaddedTexts {
  explicit PaddedTexts(std::vector<std::string> texts) : count(texts.size()) {
    for (const std::string& text : texts) width = std::max(width, text.size());
    for (std::string& text : texts) {
      text.resize(width, '\0');
      bytes.insert(bytes.end(), text.begin(), text.end());
    }
  }
  std::size_t count, width = 1;
  std::vector<char> bytes{};
};

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Archive = std::unique_ptr<zip_t, CloseArchive>;

[[noreturn]] void fail() {
  throw std::runtime_error("libzip could not make an archive");
}

/// Writes arrays into an archive in a file. libzip reads them in place when it closes the archive, so that nothing is
/// copied; its output goes straight to the file.
class ZipFile {
 public:
  ZipFile(bool is_compressed, OutputFile* file) : is_compressed_(is_compressed), file_(file) {
    zip_source_t* const target = zip_source_function_create(&ZipFile::serve, this, nullptr);
    if (!target) fail();
    archive_.reset(zip_open_from_source(target, ZIP_CREATE | ZIP_TRUNCATE, nullptr));
    if (archive_) return;
    zip_source_free(target);
    fail();
  }
  ZipFile(const ZipFile&) = delete;
  ZipFile& operator=(const ZipFile&) = delete;

  /// Adds an array. The numbers must stay until `finish`.
  template <class Numbers>
  void add(const std::string& key, std::string_view type, const std::vector<std::size_t>& shape,
           const Numbers& numbers) {
    using Number = typename Numbers::value_type;
    const std::string& header = headers_.emplace_back(make_npy_header(type, shape));
    const zip_buffer_fragment_t parts[] = {
        {reinterpret_cast<zip_uint8_t*>(const_cast<char*>(header.data())), header.size()},
        {reinterpret_cast<zip_uint8_t*>(const_cast<Number*>(numbers.data())), numbers.size() * sizeof(Number)}};
    zip_source_t* const source = zip_source_buffer_fragment(archive_.get(), parts, numbers.empty() ? 1 : 2, 0);
    const zip_int64_t index =
        source ? zip_file_add(archive_.get(), (key + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (index < 0) fail();
    const auto place = static_cast<zip_uint64_t>(index);
    constexpr time_t year_1980 = 315619200;  // as numpy does, so that equal arrays give equal files
    if (zip_set_file_compression(archive_.get(), place, is_compressed_ ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0) != 0 ||
        zip_file_set_mtime(archive_.get(), place, year_1980, 0) != 0)
      fail();
  }

  void finish() {
    const bool is_closed = zip_close(archive_.get()) == 0;
    if (trouble_) std::rethrow_exception(trouble_);
    if (!is_closed) fail();
    (void)archive_.release();  // closing has freed it
  }

 private:
  /// Answers the requests of libzip for a file that is written anew.
  static zip_int64_t serve(void* self, void* data, zip_uint64_t size, zip_source_cmd_t command) {
    return static_cast<ZipFile*>(self)->answer(data, size, command);
  }
  zip_int64_t answer(void* data, zip_uint64_t size, zip_source_cmd_t command) {
    try {
      switch (command) {
        case ZIP_SOURCE_SUPPORTS:
          return zip_source_make_command_bitmap(ZIP_SOURCE_SUPPORTS, ZIP_SOURCE_OPEN, ZIP_SOURCE_READ, ZIP_SOURCE_CLOSE,
                                                ZIP_SOURCE_STAT, ZIP_SOURCE_ERROR, ZIP_SOURCE_FREE, ZIP_SOURCE_SEEK,
                                                ZIP_SOURCE_TELL, ZIP_SOURCE_BEGIN_WRITE, ZIP_SOURCE_WRITE,
                                                ZIP_SOURCE_SEEK_WRITE, ZIP_SOURCE_TELL_WRITE, ZIP_SOURCE_COMMIT_WRITE,
                                                ZIP_SOURCE_ROLLBACK_WRITE, ZIP_SOURCE_REMOVE, -1);
        case ZIP_SOURCE_WRITE:
          file_->write(std::string_view(static_cast<const char*>(data), size));
          end_ = std::max(end_, file_->tell());
          return static_cast<zip_int64_t>(size);
        case ZIP_SOURCE_SEEK_WRITE: {
          const zip_int64_t place = zip_source_seek_compute_offset(file_->tell(), end_, data, size, nullptr);
          if (place < 0) return -1;
          file_->seek(static_cast<std::uint64_t>(place));
          return 0;
        }
        case ZIP_SOURCE_TELL_WRITE:
          return static_cast<zip_int64_t>(file_->tell());
        case ZIP_SOURCE_STAT:  // there is nothing yet
          zip_stat_init(static_cast<zip_stat_t*>(data));
          static_cast<zip_stat_t*>(data)->valid = ZIP_STAT_SIZE;
          return sizeof(zip_stat_t);
        case ZIP_SOURCE_ERROR: {
          auto* const codes = static_cast<int*>(data);
          codes[0] = trouble_ ? ZIP_ER_WRITE : ZIP_ER_OK;
          codes[1] = 0;
          return 2 * sizeof(int);
        }
        default:
          return 0;
      }
    } catch (...) {  // exceptions must not pass through libzip, which is C
      trouble_ = std::current_exception();
      return -1;
    }
  }

  bool is_compressed_;
  OutputFile* file_;
  std::uint64_t end_ = 0;            ///< end of the written part; libzip returns to the head of each array
  std::deque<std::string> headers_;  ///< a deque keeps their addresses
  std::exception_ptr trouble_;
  Archive archive_;
};

struct CloseFile {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

/// Reads the numbers of one array of such an archive, which must have at least `size` of them.
std::vector<double> read_array(const std::string& name, zip_t* archive, const std::string& key, std::size_t size) {
  const zip_int64_t index = zip_name_locate(archive, (key + ".npy").c_str(), 0);
  zip_stat_t stat;
  if (index < 0 || zip_stat_index(archive, static_cast<zip_uint64_t>(index), 0, &stat) != 0 ||
      stat.size < size * sizeof(double))
    throw InputError(name, "has fewer frames than the checkpoint says; run without --resume");
  const std::unique_ptr<zip_file_t, CloseFile> file(zip_fopen_index(archive, static_cast<zip_uint64_t>(index), 0));
  const auto take = [&](void* bytes, std::size_t count) {
    if (!file || zip_fread(file.get(), bytes, count) != static_cast<zip_int64_t>(count))
      throw InputError(name, "is damaged; run without --resume");
  };
  // The head holds the magic, the version and the length of the text that follows; then come the numbers.
  std::array<unsigned char, 10> head{};
  take(head.data(), head.size());
  std::string text(head[8] + 256u * head[9], '\0');
  take(text.data(), text.size());
  std::vector<double> numbers(size);
  take(numbers.data(), size * sizeof(double));
  return numbers;
}

}  // namespace

NpzTrajectory::NpzTrajectory(const std::filesystem::path& path, const ShownParts* shown, bool is_compressed,
                             std::uint64_t frames, std::span<const Observed> observables,
                             const std::optional<Cell>& cell)
    : path_(path), shown_(shown), is_compressed_(is_compressed), cell_(cell) {
  if (!observables.empty()) {
    observed_type_ = describe_record(observables);
    observed_width_ = 1;
    for (const Observed& each : observables) {
      observed_width_ += each.values.size();
      observed_units_.push_back(each.unit);
      for (const std::string& name : column_names(each)) observed_columns_.push_back(name);
    }
  }
  if (frames == 0) return;
  const Archive archive(zip_open(path.c_str(), ZIP_RDONLY, nullptr));
  if (!archive) throw InputError(path.string(), "cannot be read; run without --resume");
  times_ = read_array(path.string(), archive.get(), "time", frames);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const std::size_t width = k == 3 ? shown->rods.size() : 3 * shown->num_points;
    if (width > 0) rows_[k] = read_array(path.string(), archive.get(), row_names[k], frames * width);
  }
  if (observed_width_ > 0)
    observed_ = read_array(path.string(), archive.get(), observables_key, frames * observed_width_);
}

void NpzTrajectory::write(const Frame& frame) {
  const bool is_first = times_.empty();
  times_.push_back(frame.time);
  const std::span<const double> parts[] = {frame.positions, frame.velocities, frame.accelerations, frame.tensions};
  for (std::size_t k = 0; k < rows_.size(); ++k) rows_[k].insert(rows_[k].end(), parts[k].begin(), parts[k].end());
  if (observed_width_ > 0) observed_.push_back(frame.time);
  for (const Observed& each : frame.observables)
    observed_.insert(observed_.end(), each.values.begin(), each.values.end());
  if (is_first) save();
}

void NpzTrajectory::cut(std::uint64_t frames) {
  times_.resize(frames);
  for (std::size_t k = 0; k < rows_.size(); ++k)
    rows_[k].resize(frames * (k == 3 ? shown_->rods.size() : 3 * shown_->num_points));
  observed_.resize(frames * observed_width_);
}

void NpzTrajectory::synchronize() {
  save();
}

void NpzTrajectory::save() const {
  const std::size_t frames = times_.size(), m = shown_->num_points, num_rods = shown_->rods.size();
  const std::vector<std::int32_t> points(shown_->points.begin(), shown_->points.end());
  const std::vector<std::array<Index, 2>> rods = shown_->rod_points();
  const Units& units = shown_->units;
  const PaddedTexts names(shown_->rod_names()), observed_units(observed_units_), columns(observed_columns_),
      letters({units.time, units.length, units.letters(Dimension::Velocity), units.letters(Dimension::Acceleration),
               units.force});
  const Cell cell = cell_.value_or(Cell{});
  const std::array<double, 9> edges = edges_of(cell);
  replace_file(path_, [&](OutputFile* file) {
    ZipFile zip(is_compressed_, file);
    zip.add("time", "<f8", {frames}, times_);
    for (std::size_t k = 0; k < rows_.size(); ++k)
      zip.add(row_names[k], "<f8",
              k == 3 ? std::vector<std::size_t>{frames, num_rods} : std::vector<std::size_t>{frames, m, 3}, rows_[k]);
    zip.add("points", "<i4", {m}, points);
    zip.add("rods", "<i4", {num_rods, 2}, rods);
    const auto add_texts = [&](const char* key, const PaddedTexts& texts) {
      zip.add(key, fmt::format("|S{}", texts.width), {texts.count}, texts.bytes);
    };
    add_texts("rod_names", names);
    add_texts("units", letters);
    if (cell_) {
      zip.add("box", "<f8", {3, 3}, edges);
      zip.add("origin", "<f8", {3}, cell.origin);
    }
    if (observed_width_ > 0) {
      zip.add(observables_key, observed_type_, {frames}, observed_);
      add_texts("observable_units", observed_units);
      add_texts("observable_columns", columns);
    }
    zip.finish();
  });
}

}  // namespace tanor::report

/// The function of the module, which the program calls by its name.
extern "C" __attribute__((visibility("default"))) void tanor_open_frame_file(
    const tanor::report::FrameFileRequest& request, std::unique_ptr<tanor::report::FrameFile>* opened) {
  *opened = std::make_unique<tanor::report::NpzTrajectory>(request.path, request.shown, request.is_compressed,
                                                           request.mark, request.observables, request.cell);
}
