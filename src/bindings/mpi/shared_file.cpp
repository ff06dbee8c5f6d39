#include <algorithm>
#include <array>
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
  int error = MPI_File_set_view(file_, 0, MPI_BYTE, MPI_BYTE, "native", MPI_INFO_NULL);
  in_pieces(bytes.first(ranks_.rank() == 0 ? bytes.size() : 0), [&](const std::byte* first, int count) {
    const auto place = static_cast<MPI_Offset>(offset) + (first - bytes.data());
    if (error == MPI_SUCCESS) error = MPI_File_write_at(file_, place, first, count, MPI_BYTE, MPI_STATUS_IGNORE);
  });
  MPI_Bcast(&error, 1, MPI_INT, 0, ranks_.communicator());
  check(error, name_);
}

/// Sets a view of the places of some points, ascending as MPI asks, and transfers their numbers in this order.
void SharedFile::transfer_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                                 const Transfer& transfer) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t k) { return points[k]; });
  std::vector<Index> places;
  for (const std::size_t k : order) places.push_back(points[k]);
  MPI_Datatype point = MPI_DATATYPE_NULL, all = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(width), MPI_DOUBLE, &point);
  MPI_Type_create_indexed_block(static_cast<int>(places.size()), 1, places.data(), point, &all);
  for (MPI_Datatype* const type : {&point, &all}) MPI_Type_commit(type);
  int error = MPI_File_set_view(file_, static_cast<MPI_Offset>(offset), point, all, "native", MPI_INFO_NULL);
  if (error == MPI_SUCCESS) error = transfer(order, point);
  for (MPI_Datatype* const type : {&point, &all}) MPI_Type_free(type);
  check(error, name_);
}

void SharedFile::write_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                              std::span<const double> numbers) {
  transfer_points(offset, width, points, [&](std::span<const std::size_t> order, MPI_Datatype point) {
    std::vector<double> sorted(width * order.size());
    for (std::size_t k = 0; k < order.size(); ++k) std::copy_n(&numbers[width * order[k]], width, &sorted[width * k]);
    return MPI_File_write_all(file_, sorted.data(), static_cast<int>(order.size()), point, MPI_STATUS_IGNORE);
  });
}

void SharedFile::read_points(std::size_t offset, std::size_t width, std::span<const Index> points,
                             std::span<double> numbers) {
  transfer_points(offset, width, points, [&](std::span<const std::size_t> order, MPI_Datatype point) {
    std::vector<double> sorted(width * order.size());
    const int error = MPI_File_read_all(file_, sorted.data(), static_cast<int>(order.size()), point, MPI_STATUS_IGNORE);
    for (std::size_t k = 0; k < order.size(); ++k) std::copy_n(&sorted[width * k], width, &numbers[width * order[k]]);
    return error;
  });
}

}  // namespace tanor
