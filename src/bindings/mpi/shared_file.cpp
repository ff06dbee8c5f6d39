#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <stdexcept>

#include "mpi/pieces.hpp"
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

void SharedFile::resize(std::size_t size) {
  check(MPI_File_set_size(file_, static_cast<MPI_Offset>(size)), name_);
}

void SharedFile::synchronize() {
  check(MPI_File_sync(file_), name_);
}

void SharedFile::write(std::size_t offset, std::span<const std::byte> bytes) {
  check(MPI_File_set_view(file_, 0, MPI_BYTE, MPI_BYTE, "native", MPI_INFO_NULL), name_);
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, ranks_.communicator());
  for (std::size_t first = 0; first < size; first += largest_piece) {
    // All take part in each call, but what the first rank brings is written.
    const auto piece =
        ranks_.rank() == 0 ? bytes.subspan(first, std::min(largest_piece, size - first)) : bytes.first(0);
    check(MPI_File_write_at_all(file_, static_cast<MPI_Offset>(offset + first), piece.data(),
                                static_cast<int>(piece.size()), MPI_BYTE, MPI_STATUS_IGNORE),
          name_);
  }
}

std::vector<std::byte> SharedFile::read(std::size_t offset, std::size_t size) {
  std::vector<std::byte> bytes(size);
  check(MPI_File_set_view(file_, 0, MPI_BYTE, MPI_BYTE, "native", MPI_INFO_NULL), name_);
  std::size_t read = 0;
  in_pieces(std::span(bytes), [&](std::byte* first, int count) {
    MPI_Status status;
    const auto place = static_cast<MPI_Offset>(offset) + (first - bytes.data());
    check(MPI_File_read_at_all(file_, place, first, count, MPI_BYTE, &status), name_);
    int found = 0;
    MPI_Get_count(&status, MPI_BYTE, &found);
    read += static_cast<std::size_t>(found);
  });
  bytes.resize(read);
  return bytes;
}

/// Sets a view of the places of some points, in ascending order, as MPI asks.
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

/// Points in ascending order, with their numbers.
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

/// The numbers of one point, in memory.
class PointType {
 public:
  explicit PointType(std::size_t width) {
    MPI_Type_contiguous(static_cast<int>(width), MPI_DOUBLE, &type_);
    MPI_Type_commit(&type_);
  }
  ~PointType() { MPI_Type_free(&type_); }
  PointType(const PointType&) = delete;
  PointType& operator=(const PointType&) = delete;
  operator MPI_Datatype() const { return type_; }  // NOLINT(google-explicit-constructor): it stands for the type

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

}  // namespace

void SharedFile::write_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                              std::span<const double> numbers) {
  Sorted sorted(points, width);
  for (std::size_t k = 0; k < points.size(); ++k)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(width * sorted.order[k]), width,
                sorted.numbers.begin() + static_cast<std::ptrdiff_t>(width * k));
  set_view(offset, width, sorted.points);
  const PointType point(width);
  check(MPI_File_write_all(file_, sorted.numbers.data(), static_cast<int>(points.size()), point, MPI_STATUS_IGNORE),
        name_);
}

void SharedFile::read_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                             std::span<double> numbers) {
  Sorted sorted(points, width);
  set_view(offset, width, sorted.points);
  const PointType point(width);
  check(MPI_File_read_all(file_, sorted.numbers.data(), static_cast<int>(points.size()), point, MPI_STATUS_IGNORE),
        name_);
  for (std::size_t k = 0; k < points.size(); ++k)
    std::copy_n(sorted.numbers.begin() + static_cast<std::ptrdiff_t>(width * k), width,
                numbers.begin() + static_cast<std::ptrdiff_t>(width * sorted.order[k]));
}

}  // namespace tanor
