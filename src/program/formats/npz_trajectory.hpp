#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "report/frame_file.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// Writes arrays of all frames for numpy.load: `time` (F), `position`, `velocity`, `acceleration` (F x m x 3),
/// `tension` (F x R), `points` (m), `rods` (R x 2, numbers of points), `rod_names` (R), `units` (5, of the first five),
/// of a periodic sample `box` (3 x 3, an edge a row) and its corner `origin`, and `observables`, a structured array (F)
/// with the time `t` and a field for each, whose units stand in `observable_units`, and the names of all their numbers
/// in `observable_columns`. Frames are kept in memory. The file is replaced as a whole at each call of `synchronize`,
/// which takes no additional memory.
class NpzTrajectory : public FrameFile {
 public:
  /// `shown` must outlive this object. `frames` is 0 for a new file, else the number of frames of an existing one to
  /// continue after; throws InputError if it has fewer.
  NpzTrajectory(const std::filesystem::path& path, const ShownParts* shown, bool is_compressed,
                std::uint64_t frames = 0, std::span<const Observed> observables = {},
                const std::optional<Cell>& cell = {});

  void write(const Frame& frame) override;
  std::uint64_t mark() const override { return times_.size(); }
  void cut(std::uint64_t frames) override;
  void synchronize() override;

 private:
  void save() const;

  std::filesystem::path path_;
  const ShownParts* shown_;
  bool is_compressed_;
  std::vector<double> times_;
  std::array<std::vector<double>, 4> rows_;  ///< position, velocity, acceleration, tension
  std::optional<Cell> cell_;
  std::string observed_type_;       ///< of a row of `observed_`, as numpy describes it; empty if there are none
  std::size_t observed_width_ = 0;  ///< numbers of a row
  std::vector<double> observed_;    ///< F rows: time and observables
  std::vector<std::string> observed_units_, observed_columns_;
};

}  // namespace tanor::report
