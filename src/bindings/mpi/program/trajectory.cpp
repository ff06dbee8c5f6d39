#include "mpi/program/trajectory.hpp"

#include <string>
#include <string_view>

#include "cli/output_folder.hpp"
#include "mpi/program/together.hpp"
#include "report/npy.hpp"
#include "scene/npy.hpp"
#include "scene/text_file.hpp"

namespace tanor::mpi {

std::vector<double> read_frame_times(const std::filesystem::path& folder, double time) {
  const std::filesystem::path name = folder / cli::mpi_times_name;
  if (!std::filesystem::exists(name)) return {};
  const std::string text = scene::read_text(name);
  std::string_view bytes = text;
  std::vector<double> times = scene::read_npy(name.string(), &bytes).numbers;
  std::erase_if(times, [&](double frame) { return frame > time; });
  return times;
}

/// Writes the numbers first, then the header that counts them.
void write_frame(MpiRanks& ranks, const std::filesystem::path& folder, const RankSystem& part, std::size_t num_points,
                 const Simulation& simulation, std::vector<double>* times) {
  constexpr std::size_t header_size = 128;  // room for any shape in front of the numbers
  const std::size_t own = count_to_write(ranks, part);
  SharedFile frames(ranks, folder / cli::mpi_trajectory_name, SharedFile::Mode::Write);
  frames.write_points(header_size + 24 * num_points * times->size(), 3, std::span(part.points).first(own),
                      simulation.positions().first(3 * own));
  times->push_back(simulation.time());
  const std::string header = report::make_npy_header("<f8", {times->size(), num_points, 3}, header_size);
  frames.write(0, std::as_bytes(std::span(header)));
  frames.synchronize();
  do_on_first(ranks, [&] {
    report::replace_file(folder / cli::mpi_times_name, report::Wait::ForDisk,
                         [&](report::OutputFile* file) { report::write_npy(file, *times); });
  });
}

}  // namespace tanor::mpi
