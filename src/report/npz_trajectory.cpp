#include "report/npz_trajectory.hpp"

#include <zip.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include <tanor/error.hpp>

#include "report/npy.hpp"
#include "report/output_file.hpp"
#include "scene/npy.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace {

constexpr std::array<const char*, 4> row_names{"position", "velocity", "acceleration", "tension"};

struct CloseArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
using Archive = std::unique_ptr<zip_t, CloseArchive>;

[[noreturn]] void fail() {
  throw std::runtime_error("libzip could not make an archive");  // in memory nothing else than memory can end
}

template <class Number>
std::string_view bytes_of(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

/// An archive in memory.
class ZipBytes {
 public:
  explicit ZipBytes(bool is_compressed)
      : is_compressed_(is_compressed), source_(zip_source_buffer_create(nullptr, 0, 0, nullptr)) {
    if (!source_) fail();
    zip_source_keep(source_);
    archive_.reset(zip_open_from_source(source_, ZIP_CREATE | ZIP_TRUNCATE, nullptr));
    if (!archive_) fail();
  }
  ~ZipBytes() { zip_source_free(source_); }
  ZipBytes(const ZipBytes&) = delete;
  ZipBytes& operator=(const ZipBytes&) = delete;

  void add(const std::string& name, std::string content) {
    contents_.push_back(std::make_unique<std::string>(std::move(content)));
    zip_source_t* source = zip_source_buffer(archive_.get(), contents_.back()->data(), contents_.back()->size(), 0);
    const zip_int64_t index = source ? zip_file_add(archive_.get(), name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    if (index < 0) fail();
    const auto place = static_cast<zip_uint64_t>(index);
    constexpr time_t year_1980 = 315619200;  // as numpy does: equal arrays are equal files
    if (zip_set_file_compression(archive_.get(), place, is_compressed_ ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0) != 0 ||
        zip_file_set_mtime(archive_.get(), place, year_1980, 0) != 0)
      fail();
  }

  std::string finish() {
    if (zip_close(archive_.get()) != 0) fail();
    (void)archive_.release();  // closing has freed it
    zip_stat_t stat;
    if (zip_source_stat(source_, &stat) != 0 || zip_source_open(source_) != 0) fail();
    std::string bytes(stat.size, '\0');
    const zip_int64_t read = zip_source_read(source_, bytes.data(), bytes.size());
    zip_source_close(source_);
    if (read != static_cast<zip_int64_t>(bytes.size())) fail();
    return bytes;
  }

 private:
  bool is_compressed_;
  zip_source_t* source_;
  Archive archive_;
  std::vector<std::unique_ptr<std::string>> contents_;  ///< libzip reads them when it closes
};

/// The numbers of one array of an archive of ours; `size`: how many it has at most.
std::vector<double> read_array(const std::string& name, zip_t* archive, const std::string& key, std::size_t size) {
  const zip_int64_t index = zip_name_locate(archive, (key + ".npy").c_str(), 0);
  zip_stat_t stat;
  constexpr std::size_t most_of_a_header = 1 << 16;
  if (index < 0 || zip_stat_index(archive, static_cast<zip_uint64_t>(index), 0, &stat) != 0 ||
      stat.size < size * sizeof(double))
    throw InputError(name, "has fewer frames than the checkpoint says; run without --resume");
  std::string bytes(std::min<std::size_t>(stat.size, size * sizeof(double) + most_of_a_header), '\0');
  zip_file_t* file = zip_fopen_index(archive, static_cast<zip_uint64_t>(index), 0);
  const zip_int64_t read = file ? zip_fread(file, bytes.data(), bytes.size()) : -1;
  if (file) zip_fclose(file);
  constexpr std::size_t smallest_header = 64;
  const std::size_t begin = bytes.find('\n') + 1;  // of the numbers, behind the line of the header
  if (read != static_cast<zip_int64_t>(bytes.size()) || begin < smallest_header ||
      bytes.size() < begin + size * sizeof(double))
    throw InputError(name, "is damaged; run without --resume");
  std::vector<double> numbers(size);
  std::copy_n(bytes.data() + begin, size * sizeof(double), reinterpret_cast<char*>(numbers.data()));
  return numbers;
}

}  // namespace

NpzTrajectory::NpzTrajectory(const std::filesystem::path& path, const ShownParts* shown, bool is_compressed,
                             std::uint64_t frames)
    : path_(path), shown_(shown), is_compressed_(is_compressed) {
  if (frames == 0) return;
  const Archive archive(zip_open(path.c_str(), ZIP_RDONLY, nullptr));
  if (!archive) throw InputError(path.string(), "cannot be read; run without --resume");
  times_ = read_array(path.string(), archive.get(), "time", frames);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const std::size_t width = k == 3 ? shown->rods.size() : 3 * shown->num_points;
    if (width > 0) rows_[k] = read_array(path.string(), archive.get(), row_names[k], frames * width);
  }
}

void NpzTrajectory::write(const Frame& frame) {
  const bool is_first = times_.empty();
  times_.push_back(frame.time);
  const std::span<const double> parts[] = {frame.positions, frame.velocities, frame.accelerations, frame.tensions};
  for (std::size_t k = 0; k < rows_.size(); ++k) rows_[k].insert(rows_[k].end(), parts[k].begin(), parts[k].end());
  if (is_first) save();
}

void NpzTrajectory::cut(std::uint64_t frames) {
  times_.resize(frames);
  for (std::size_t k = 0; k < rows_.size(); ++k)
    rows_[k].resize(frames * (k == 3 ? shown_->rods.size() : 3 * shown_->num_points));
}

void NpzTrajectory::synchronize() {
  save();
}

void NpzTrajectory::save() const {
  ZipBytes zip(is_compressed_);
  const std::size_t frames = times_.size(), m = shown_->num_points, num_rods = shown_->rods.size();
  const auto add = [&](const char* key, std::string_view type, std::vector<std::size_t> shape, std::string_view bytes) {
    zip.add(std::string(key) + ".npy", make_npy(type, shape, bytes));
  };
  add("time", "<f8", {frames}, bytes_of(times_));
  for (std::size_t k = 0; k < rows_.size(); ++k)
    add(row_names[k], "<f8",
        k == 3 ? std::vector<std::size_t>{frames, num_rods} : std::vector<std::size_t>{frames, m, 3},
        bytes_of(rows_[k]));
  const std::vector<std::int32_t> points(shown_->points.begin(), shown_->points.end());
  std::vector<std::int32_t> rods;
  for (const auto& [i, j] : shown_->rods) {
    const auto beyond = j - static_cast<std::int32_t>(m);  // an image of a point
    for (const std::int32_t end : {i, beyond < 0 ? j : shown_->images[static_cast<std::size_t>(beyond)].point})
      rods.push_back(points[static_cast<std::size_t>(end)]);
  }
  add("points", "<i4", {m}, bytes_of(points));
  add("rods", "<i4", {num_rods, 2}, bytes_of(rods));
  const std::string bytes = zip.finish();
  replace_file(path_, [&](OutputFile* file) { file->write(std::string_view(bytes)); });
}

}  // namespace tanor::report
