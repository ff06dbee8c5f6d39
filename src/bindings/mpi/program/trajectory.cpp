#include "mpi/program/trajectory.hpp"

#include <cstring>
#include <string>

#include "cli/output_folder.hpp"
#include "report/npy.hpp"

namespace tanor::mpi {

namespace {

constexpr std::size_t header_size = 128;  // room for any shape in front of the numbers

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

}  // namespace

Trajectory::Trajectory(const MpiRanks& ranks, const std::filesystem::path& folder, const RankSystem& part,
                       std::size_t num_points)
    : ranks_(ranks),
      folder_(folder),
      points_(part.points.begin(), part.points.begin() + static_cast<std::ptrdiff_t>(count_to_write(ranks, part))),
      num_points_(num_points) {}

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

/// Writes the numbers first, then the header that counts them.
void Trajectory::write_frame(const Simulation& simulation) {
  SharedFile frames(ranks_, folder_ / cli::mpi_trajectory_name, SharedFile::Mode::Write);
  frames.write_points(header_size + 24 * num_points_ * times_.size(), 3, points_,
                      simulation.positions().first(3 * points_.size()));
  times_.push_back(simulation.time());
  frames.write(0, bytes_of(report::make_npy_header("<f8", {times_.size(), num_points_, 3}, header_size)));
  frames.synchronize();
  SharedFile times(ranks_, folder_ / cli::mpi_times_name, SharedFile::Mode::Write);
  times.write(header_size, std::as_bytes(std::span(times_)));
  times.write(0, bytes_of(report::make_npy_header("<f8", {times_.size()}, header_size)));
  times.synchronize();
}

}  // namespace tanor::mpi
