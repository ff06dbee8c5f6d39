#pragma once

#include <span>

#include "report/text_trajectory.hpp"

namespace tanor::report {

inline constexpr const char* observables_name = "observables.csv";

/// Writes the observables over time for spreadsheets: a row for each frame, with the time and a column for each number.
/// The head names them with their units, "t [s],torque [N m],load(hook).x [N]"; names with commas stand in quotes.
class ObservablesTable : public TextTrajectory {
 public:
  /// `mark` is 0 for a new file.
  ObservablesTable(const std::filesystem::path& path, std::span<const Observed> observables, const Units& units,
                   std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;
};

}  // namespace tanor::report
