#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "mpi/tanor_mpi.hpp"

namespace tanor {

namespace {

void check(int error, const std::string& what) {
  if (error == MPI_SUCCESS) return;
  std::array<char, MPI_MAX_ERROR_STRING> text{};
  int length = 0;
  MPI_Error_string(error, text.data(), &length);
  throw std::runtime_error(what + ": " + std::string(text.data(), static_cast<std::size_t>(length)));
}

}  // namespace

SharedFile::SharedFile(const MpiRanks& ranks, const std::filesystem::path& name, Mode mode)
    : ranks_(ranks), name_(name.string()) {
  const int access = mode == Mode::Read ? MPI_MODE_RDONLY : MPI_MODE_CREATE | MPI_MODE_WRONLY;
  check(MPI_File_open(ranks.communicator(), name_.c_str(), access, MPI_INFO_NULL, &file_), name_);
}

SharedFile::~SharedFile() {
  if (file_ != MPI_FILE_NULL) MPI_File_close(&file_);
}

void SharedFile::write(std::size_t offset, std::span<const std::byte> bytes) {
  check(MPI_File_set_view(file_, 0, MPI_BYTE, MPI_BYTE, "native", MPI_INFO_NULL), name_);
  const int size = ranks_.rank() == 0 ? static_cast<int>(bytes.size()) : 0;
  check(MPI_File_write_at_all(file_, static_cast<MPI_Offset>(offset), bytes.data(), size, MPI_BYTE, MPI_STATUS_IGNORE),
        name_);
}

std::vector<std::byte> SharedFile::read(std::size_t offset, std::size_t size) {
  std::vector<std::byte> bytes(size);
  check(MPI_File_set_view(file_, 0, MPI_BYTE, MPI_BYTE, "native", MPI_INFO_NULL), name_);
  MPI_Status status;
  check(MPI_File_read_at_all(file_, static_cast<MPI_Offset>(offset), bytes.data(), static_cast<int>(size), MPI_BYTE,
                             &status),
        name_);
  int read = 0;
  MPI_Get_count(&status, MPI_BYTE, &read);
  bytes.resize(static_cast<std::size_t>(read));
  return bytes;
}

/// A view of the places of some points, in rising order, as MPI asks.
void SharedFile::set_view(std::size_t offset, std::size_t width, std::span<const Index> points) {
  std::vector<MPI_Aint> places;
  for (const Index point : points) places.push_back(static_cast<MPI_Aint>(8 * width * static_cast<std::size_t>(point)));
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Type_create_hindexed_block(static_cast<int>(places.size()), static_cast<int>(width), places.data(), MPI_DOUBLE,
                                 &type);
  MPI_Type_commit(&type);
  const int error =
      MPI_File_set_view(file_, static_cast<MPI_Offset>(offset), MPI_DOUBLE, type, "native", MPI_INFO_NULL);
  MPI_Type_free(&type);
  check(error, name_);
}

namespace {

/// Points in rising order, and their numbers likewise.
struct Sorted {
  std::vector<std::size_t> order;
  std::vector<Index> points;
  std::vector<double> numbers;

  Sorted(std::span<const Index> given, std::size_t width) : order(given.size()), numbers(width * given.size()) {
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](std::size_t k) { return given[k]; });
    for (const std::size_t k : order) points.push_back(given[k]);
  }
};

}  // namespace

void SharedFile::write_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                              std::span<const double> numbers) {
  Sorted sorted(points, width);
  for (std::size_t k = 0; k < points.size(); ++k)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(width * sorted.order[k]), width,
                sorted.numbers.begin() + static_cast<std::ptrdiff_t>(width * k));
  set_view(offset, width, sorted.points);
  check(MPI_File_write_all(file_, sorted.numbers.data(), static_cast<int>(sorted.numbers.size()), MPI_DOUBLE,
                           MPI_STATUS_IGNORE),
        name_);
}

void SharedFile::read_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                             std::span<double> numbers) {
  Sorted sorted(points, width);
  set_view(offset, width, sorted.points);
  check(MPI_File_read_all(file_, sorted.numbers.data(), static_cast<int>(sorted.numbers.size()), MPI_DOUBLE,
                          MPI_STATUS_IGNORE),
        name_);
  for (std::size_t k = 0; k < points.size(); ++k)
    std::copy_n(sorted.numbers.begin() + static_cast<std::ptrdiff_t>(width * k), width,
                numbers.begin() + static_cast<std::ptrdiff_t>(width * sorted.order[k]));
}

namespace {

/// What a checkpoint begins with; the motion's progress follows, then positions and velocities of all points.
struct Header {
  std::array<char, 8> magic{'t', 'a', 'n', 'o', 'r', 'm', 'p', 'i'};
  std::uint64_t version = 1, num_points = 0, progress_bytes = 0;

  std::size_t end() const { return (sizeof(Header) + progress_bytes + 7) / 8 * 8; }
  std::size_t positions() const { return end(); }
  std::size_t velocities() const { return end() + 24 * num_points; }
  std::size_t size() const { return end() + 48 * num_points; }
};

}  // namespace

std::vector<Index> points_to_write(const MpiRanks& ranks, const RankSystem& part) {
  std::size_t count = part.num_owned;
  if (ranks.rank() == 0) count = part.points.size() - part.part.guests.size();
  return {part.points.begin(), part.points.begin() + static_cast<std::ptrdiff_t>(count)};
}

void write_checkpoint(const MpiRanks& ranks, const std::filesystem::path& name, const RankSystem& part,
                      std::size_t num_points, const Simulation& simulation) {
  const std::vector<std::byte> progress = simulation.save_progress();
  Header header;
  header.num_points = num_points;
  header.progress_bytes = progress.size();
  // That of the first rank stands there; others' may have other lengths.
  MPI_Bcast(&header, sizeof header, MPI_BYTE, 0, ranks.communicator());
  const std::filesystem::path unfinished = name.string() + ".new";
  {
    SharedFile file(ranks, unfinished, SharedFile::Mode::Write);
    file.write(0, std::as_bytes(std::span(&header, 1)));
    file.write(sizeof header, progress);
    const std::vector<Index> points = points_to_write(ranks, part);
    file.write_points(header.positions(), 3, points, simulation.positions().first(3 * points.size()));
    file.write_points(header.velocities(), 3, points, simulation.velocities().first(3 * points.size()));
  }
  if (ranks.rank() == 0) std::filesystem::rename(unfinished, name);
  MPI_Barrier(ranks.communicator());
}

void read_checkpoint(const MpiRanks& ranks, const std::filesystem::path& name, const RankSystem& part,
                     std::size_t num_points, Simulation* simulation) {
  const auto refuse = [&](const std::string& why) { throw InputError(name.string(), why); };
  SharedFile file(ranks, name, SharedFile::Mode::Read);
  Header header, expected;
  const std::vector<std::byte> first = file.read(0, sizeof header);
  if (first.size() < sizeof header) refuse("ends too early");
  std::memcpy(&header, first.data(), sizeof header);
  if (header.magic != expected.magic || header.version != expected.version)
    refuse("is no checkpoint of this version of tanor-mpi");
  if (header.num_points != num_points)
    refuse("holds " + std::to_string(header.num_points) + " points, the system has " + std::to_string(num_points));
  if (std::filesystem::file_size(name) != header.size()) refuse("ends too early, or too late");
  const std::vector<std::byte> progress = file.read(sizeof header, header.progress_bytes);
  std::vector<double> positions(3 * part.points.size()), velocities(positions.size());
  file.read_points(header.positions(), 3, part.points, positions);
  file.read_points(header.velocities(), 3, part.points, velocities);
  simulation->restore_progress(progress, positions, velocities);
}

}  // namespace tanor
