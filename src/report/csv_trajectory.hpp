#pragma once

#include "report/shown_parts.hpp"
#include "report/text_trajectory.hpp"

namespace tanor::report {

/// A table of few points, for spreadsheets: a row a frame with `t`, of each point i `x<i>,y<i>,z<i>,vx<i>,vy<i>,vz<i>`
/// and of each rod between shown points i and j `tension<i>_<j>`; all digits.
class CsvTrajectory : public TextTrajectory {
 public:
  /// `mark`: 0 for a new file.
  CsvTrajectory(const std::filesystem::path& path, const ShownParts& shown, std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;
};

}  // namespace tanor::report
