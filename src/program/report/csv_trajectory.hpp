#pragma once

#include "report/shown_parts.hpp"
#include "report/text_trajectory.hpp"

namespace tanor::report {

/// Writes a table of few points for spreadsheets. Each frame is a row with `t`, with `x<i>,y<i>,z<i>,vx<i>,vy<i>,vz<i>`
/// for each point i, and with `tension<i>_<j>` for each rod between shown points i and j; all digits.
class CsvTrajectory : public TextTrajectory {
 public:
  /// `mark` is 0 for a new file.
  CsvTrajectory(const std::filesystem::path& path, const ShownParts& shown, std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;
};

}  // namespace tanor::report
