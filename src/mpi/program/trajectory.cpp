#include "mpi/program/trajectory.hpp"

#include <fmt/format.h>

#include <cstring>
#include <string>

#include "cli/output_folder.hpp"

namespace tanor::mpi {

namespace {

constexpr std::size_t header_size = 128;  // of a .npy file of version 1

/// The header of an array of numbers; `shape` as Python writes a tuple.
std::string make_header(const std::string& shape) {
  constexpr std::size_t preamble = 10;
  std::string text = fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': {}, }}", shape);
  text.resize(header_size - preamble - 1, ' ');
  const auto length = static_cast<unsigned>(header_size - preamble);
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(length & 255u) + static_cast<char>(length >> 8u) +
         text + "\n";
}

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

}  // namespace

Trajectory::Trajectory(const MpiRanks& ranks, const std::filesystem::path& folder, const RankSystem& part,
                       std::size_t num_points)
    : ranks_(ranks), folder_(folder), num_points_(num_points) {
  std::size_t count = part.num_owned;
  if (ranks.rank() == 0) count = part.points.size() - part.part.guests.size();
  points_.assign(part.points.begin(), part.points.begin() + static_cast<std::ptrdiff_t>(count));
}

void Trajectory::keep_until(double time) {
  const std::filesystem::path name = folder_ / cli::mpi_times_name;
  if (!std::filesystem::exists(name)) return;
  SharedFile file(ranks_, name, SharedFile::Mode::Read);
  const std::size_t size = std::filesystem::file_size(name);
  const std::vector<std::byte> bytes = file.read(header_size, size > header_size ? size - header_size : 0);
  for (std::size_t k = 0; 8 * (k + 1) <= bytes.size(); ++k) {
    double frame = 0.0;
    std::memcpy(&frame, bytes.data() + 8 * k, sizeof frame);
    if (frame <= time) times_.push_back(frame);
  }
}

/// The numbers first, then the header that tells of them.
void Trajectory::write_frame(const Simulation& simulation) {
  SharedFile frames(ranks_, folder_ / cli::mpi_trajectory_name, SharedFile::Mode::Write);
  frames.write_points(header_size + 24 * num_points_ * times_.size(), 3, points_,
                      simulation.positions().first(3 * points_.size()));
  times_.push_back(simulation.time());
  frames.write(0, bytes_of(make_header(fmt::format("({}, {}, 3)", times_.size(), num_points_))));
  frames.synchronize();
  SharedFile times(ranks_, folder_ / cli::mpi_times_name, SharedFile::Mode::Write);
  times.write(header_size, std::as_bytes(std::span(times_)));
  times.write(0, bytes_of(make_header(fmt::format("({},)", times_.size()))));
  times.synchronize();
}

}  // namespace tanor::mpi
