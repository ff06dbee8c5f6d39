#include "schur/island_group.hpp"

#include <algorithm>

namespace tanor::detail {

IslandGroup::IslandGroup(const SchurProblem& problem, std::span<const Index> islands)
    : constraints(problem.constraints), gather(problem.gather), inverse_mass(problem.inverse_mass), island_start{0} {
  const Numbering& numbering = problem.numbering;
  std::vector<char> has_row(numbering.num_rows(), 0), has_point(numbering.num_points(), 0);
  for (const Index island : islands) {
    const Index* const start = numbering.island_start.data() + island;
    std::fill(has_row.begin() + start[0], has_row.begin() + start[1], 1);
    for (auto a = static_cast<std::size_t>(start[0]); a < static_cast<std::size_t>(start[1]); ++a) rows.append(a);
    island_start.push_back(island_start.back() + start[1] - start[0]);
  }
  for (const Incidence& incidence : problem.incidences) {
    if (has_row[static_cast<std::size_t>(incidence.row)] != 0) has_point[static_cast<std::size_t>(incidence.point)] = 1;
  }
  for (std::size_t i = 0; i < numbering.num_moving; ++i) {
    if (has_point[i] != 0) points.append(i);
  }
  members = constraints.select(has_row);
}

}  // namespace tanor::detail
