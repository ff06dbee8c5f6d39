#include "schur/island_schedule.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/groups.hpp"

namespace tanor::detail {

IslandSchedule::IslandSchedule(const IslandTopology& given) : topology(given) {
  const Groups<int> by_point(static_cast<std::size_t>(topology.num_points), [&](const auto& add) {
    for (std::size_t a = 0; a < topology.rods.size(); ++a) {
      for (const int point : topology.rods[a])
        if (point < topology.num_points) add(point, static_cast<int>(a));
    }
  });
  std::vector<std::set<int>> neighbours(topology.rods.size());  // [row] the other rows with which it has a product
  for (std::size_t p = 0; p < by_point.size(); ++p) {
    // u points from the lower end to the higher one.
    const auto sign = [&](int a) {
      return topology.rods[static_cast<std::size_t>(a)][1] == static_cast<int>(p) ? 1.0 : -1.0;
    };
    for (const int a : by_point[p]) {
      for (const int b : by_point[p]) {
        if (b >= a) continue;
        neighbours[static_cast<std::size_t>(a)].insert(b);
        neighbours[static_cast<std::size_t>(b)].insert(a);
        products.push_back({0, a, b, static_cast<int>(p), sign(a) * sign(b)});
      }
    }
  }
  const Slots slots = eliminate(std::move(neighbours));
  for (Column& column : columns) {
    column.targets = static_cast<int>(targets.size());
    for (int f = column.first + 1; f < column.end; ++f) {
      for (int e = f; e < column.end; ++e)
        targets.push_back(slots.at({slot_row[static_cast<std::size_t>(e)], slot_row[static_cast<std::size_t>(f)]}));
    }
  }

  for (Product& product : products) product.slot = slots.at({product.a, product.b});
  std::stable_sort(products.begin(), products.end(),
                   [](const Product& x, const Product& y) { return x.slot < y.slot; });
  num_fill_slots = static_cast<std::size_t>(num_slots) - columns.size();
  for (std::size_t k = 0; k < products.size(); ++k) {
    if (k == 0 || products[k].slot != products[k - 1].slot) --num_fill_slots;
  }
}

/// Chooses the order by minimum degree. The neighbours that a row still has when its turn comes form its column.
IslandSchedule::Slots IslandSchedule::eliminate(std::vector<std::set<int>> neighbours) {
  const std::size_t num_rods = neighbours.size();
  Slots slots;
  std::vector<int> depth(num_rods, 0);
  std::set<int> waiting;
  for (std::size_t a = 0; a < num_rods; ++a) waiting.insert(static_cast<int>(a));
  const auto cost = [&](int a) {
    const auto row = static_cast<std::size_t>(a);
    return std::tuple(neighbours[row].size(), depth[row], a);
  };
  while (!waiting.empty()) {
    const int row = *std::min_element(waiting.begin(), waiting.end(), [&](int a, int b) { return cost(a) < cost(b); });
    waiting.erase(row);
    const std::set<int> entries = std::move(neighbours[static_cast<std::size_t>(row)]);
    columns.push_back({row, num_slots, num_slots + 1 + static_cast<int>(entries.size()), 0});
    slots[{row, row}] = num_slots++;
    slot_row.push_back(row);
    for (const int entry : entries) {
      slots[{entry, row}] = slots[{row, entry}] = num_slots++;
      slot_row.push_back(entry);
      const auto e = static_cast<std::size_t>(entry);
      neighbours[e].insert(entries.begin(), entries.end());
      neighbours[e].erase(entry);
      neighbours[e].erase(row);
      depth[e] = std::max(depth[e], depth[static_cast<std::size_t>(row)] + 1);
    }
  }
  return slots;
}

}  // namespace tanor::detail
