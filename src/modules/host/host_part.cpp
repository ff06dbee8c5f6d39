#include "host/host_part.hpp"

#include <utility>

namespace tanor::detail {

/// Rows are only added at the end, or move forward together with all that follow. So if the first and the last row move
/// by the same number, all rows do.
void HostPart::number_rows(const Inventory& inventory) {
  if (members.empty()) return;
  const std::size_t first = inventory.first_row(members.front());
  const std::size_t last = inventory.first_row(members.back());
  const std::size_t first_move = std::exchange(first_row_, first) - first;
  const std::size_t last_move = std::exchange(last_row_, last) - last;
  std::vector<Index>& rows = host->host_row;
  if (std::exchange(has_rows_, true) && first_move == last_move) {
    if (last_move == 0) return;
    for (Index& row : rows) row -= static_cast<Index>(last_move);
    return;
  }
  const Numbering& numbering = host->model.numbering;
  std::vector<Index> of_user;
  for (const ConstraintId id : members) {
    for (std::size_t k = 0; k < inventory.num_rows(id); ++k)
      of_user.push_back(static_cast<Index>(inventory.first_row(id) + k));
  }
  for (std::size_t a = 0; a < rows.size(); ++a) rows[a] = of_user[static_cast<std::size_t>(numbering.user_row[a])];
}

void HostPart::number_points(const HostPoints& points) const {
  std::vector<Index> host_points;
  for (const Index point : places) host_points.push_back(points.host_point[static_cast<std::size_t>(point)]);
  host->transfer.set_points(host_points);
}

}  // namespace tanor::detail
