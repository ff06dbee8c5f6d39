#include "host/island_partition.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "base/disjoint_sets.hpp"

namespace tanor::detail {

namespace {

template <class Number>
void append(const std::vector<Number>& from, std::vector<Number>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

IslandPartition::IslandPartition(const HostPoints& points, const Inventory& inventory)
    : points_(points), inventory_(inventory) {
  add_points(points.of_host);
}

// ---- what is divided anew ----

void IslandPartition::add_points(std::span<const Index> points) {
  for (const Index point : points) {
    if (!points_.is_support(point)) new_points_.push_back(point);
  }
  key_of_point_.resize(points_.size(), -1);
  part_of_key_.resize(points_.size(), nullptr);
  place_.resize(points_.size(), -1);
}

void IslandPartition::drop_left_points() {
  for (std::size_t point = 0; point < points_.size(); ++point) {
    if (points_.host_point[point] < 0 && key_of_point_[point] >= 0) touch(std::exchange(key_of_point_[point], -1));
  }
}

void IslandPartition::touch_point(Index point) {
  if (const Index key = key_of_point_[static_cast<std::size_t>(point)]; key >= 0) touch(key);
}

void IslandPartition::touch_constraint(ConstraintId id) {
  if (id < first_new_) touch(key_of(id));
}

void IslandPartition::touch_all() {
  for (const auto& part : parts_) touch(part->key());
}

void IslandPartition::cut(bool is_cut) {
  if (is_cut == std::exchange(is_cut_, is_cut)) return;
  touch_all();
  part_of_slot_.clear();
}

void IslandPartition::restart() {
  parts_.clear();
  part_of_slot_.clear();
  key_of_point_.assign(points_.size(), -1);
  part_of_key_.assign(points_.size(), nullptr);
  new_points_.clear();
  touched_.clear();
  first_new_ = 0;
  add_points(points_.of_host);
}

bool IslandPartition::has_edits() const {
  return first_new_ > 0 && (!touched_.empty() || !new_points_.empty() || first_new_ < inventory_.next_id());
}

/// The key of a constraint that holds supports alone is the smallest of them.
Index IslandPartition::key_of(ConstraintId id) const {
  const std::span<const Index> points = inventory_.points(id);
  for (const Index point : points) {
    if (!points_.is_support(point)) return key_of_point_[static_cast<std::size_t>(point)];
  }
  return *std::ranges::min_element(points);
}

/// Islands that share a part have the same slot.
Index IslandPartition::slot_of(const HostIsland& island) const {
  constexpr std::int64_t most_shared = 1024;  // points and rows
  constexpr Index keys_of_part = 1024;
  if (!is_cut_) return -1;
  return island.weight > most_shared ? island.key : -1 - island.key / keys_of_part;
}

// ---- dividing ----

void IslandPartition::divide_changes(PartHistory* history) {
  HostPart pool;  // contents of old parts, and what is new
  collect_changes(history, &pool);
  find_islands(&pool);
  // The parts in the slots of these islands belong together with them now.
  const std::vector<HostIsland> found = pool.islands;
  for (const HostIsland& island : found) {
    if (const auto old = part_of_slot_.find(slot_of(island)); old != part_of_slot_.end())
      take_in(old->second, history, &pool);
  }
  divide(&pool);
}

/// Collects the parts of islands that have changed, and what is new.
void IslandPartition::collect_changes(PartHistory* history, HostPart* pool) {
  const auto add = [&](Index key) {
    if (key >= 0 && part_at(key) != nullptr) take_in(part_at(key), history, pool);
  };
  for (const Index key : std::exchange(touched_, {})) add(key);
  for (ConstraintId id = first_new_; id < inventory_.next_id(); ++id) {
    if (!inventory_.has(id)) continue;
    pool->members.push_back(id);
    add(key_of(id));
    for (const Index point : inventory_.points(id)) add(key_of_point_[static_cast<std::size_t>(point)]);
  }
  append(std::exchange(new_points_, {}), &pool->moving);
  first_new_ = inventory_.next_id();
  // A point may have left, and another one may have its number.
  std::erase_if(pool->moving, [&](Index point) {
    return points_.host_point[static_cast<std::size_t>(point)] < 0 || points_.is_support(point);
  });
  std::erase_if(pool->members, [&](ConstraintId id) { return !inventory_.has(id); });
  pool->islands.clear();
}

/// Moves the contents of a part into the pool. A part without islands is gone.
void IslandPartition::take_in(HostPart* part, PartHistory* history, HostPart* pool) {
  history->read(part);
  part_of_slot_.erase(slot_of(part->islands.front()));
  for (const HostIsland& island : part->islands) part_of_key_[static_cast<std::size_t>(island.key)] = nullptr;
  append(std::exchange(part->islands, {}), &pool->islands);
  append(part->moving, &pool->moving);
  append(part->members, &pool->members);
  append(part->guesses, &pool->guesses);
}

/// Sorts points and members, and finds the islands that they form.
void IslandPartition::find_islands(HostPart* pool) {
  std::ranges::sort(pool->moving);
  std::ranges::sort(pool->members);
  pool->moving.erase(std::unique(pool->moving.begin(), pool->moving.end()), pool->moving.end());
  Index* const parent = key_of_point_.data();
  for (const Index point : pool->moving) parent[point] = point;
  for (const ConstraintId id : pool->members) {
    Index first = -1;
    for (const Index point : inventory_.points(id)) {
      if (points_.is_support(point)) continue;
      if (first < 0) first = point;
      join_sets(parent, first, point);
    }
  }
  std::map<Index, std::int64_t> without_points;
  for (const Index point : pool->moving) {
    const Index key = parent[point] = parent[parent[point]];  // smaller points have their key
    if (key == point) {
      place_[static_cast<std::size_t>(key)] = static_cast<Index>(pool->islands.size());
      pool->islands.push_back({key, 0});
    }
    ++pool->islands[static_cast<std::size_t>(place_[static_cast<std::size_t>(key)])].weight;
  }
  for (const ConstraintId id : pool->members) {
    const Index key = key_of(id);
    const auto rows = static_cast<std::int64_t>(inventory_.num_rows(id));
    if (points_.is_support(key))
      without_points[key] += rows;
    else
      pool->islands[static_cast<std::size_t>(place_[static_cast<std::size_t>(key)])].weight += rows;
  }
  for (const auto& [key, weight] : without_points) pool->islands.push_back({key, weight});
}

/// Divides the pool into new parts, which replace the old ones.
void IslandPartition::divide(HostPart* pool) {
  std::erase_if(parts_, [](const auto& part) { return part->islands.empty(); });
  std::ranges::sort(pool->islands, {}, &HostIsland::key);
  std::ranges::sort(pool->moving);
  std::ranges::sort(pool->members);
  for (const HostIsland& island : pool->islands) {
    HostPart*& part = part_of_slot_[slot_of(island)];
    if (part == nullptr) part = parts_.emplace_back(std::make_unique<HostPart>()).get();
    part->islands.push_back(island);
    part_of_key_[static_cast<std::size_t>(island.key)] = part;
  }
  for (const Index point : pool->moving)
    part_at(key_of_point_[static_cast<std::size_t>(point)])->moving.push_back(point);
  for (const ConstraintId id : pool->members) part_of(id)->members.push_back(id);
  for (const MultiplierGuess& guess : pool->guesses) {
    if (inventory_.has(guess.id)) part_of(guess.id)->guesses.push_back(guess);
  }
  std::ranges::sort(parts_, {}, [](const auto& part) { return part->key(); });
}

}  // namespace tanor::detail
