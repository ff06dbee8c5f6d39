#include "friction/contact_islands.hpp"

#include <algorithm>

namespace tanor::detail {

ContactIslands::ContactIslands(const Workspace& work) : of_contact(work.constraints.tangents().size()) {
  const Tangents& tangents = work.constraints.tangents();
  const std::vector<Index>& start = work.model().numbering.island_start;
  contacts.resize(work.model().numbering.num_islands());
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const auto after = std::upper_bound(start.begin(), start.end(), tangents[c].guide_row[0]);
    contacts[static_cast<std::size_t>(after - start.begin() - 1)].push_back(c);
  }
  std::erase_if(contacts, [](const auto& island) { return island.empty(); });
  for (std::size_t island = 0; island < contacts.size(); ++island) {
    for (const std::size_t c : contacts[island]) of_contact[c] = island;
  }
}

}  // namespace tanor::detail
