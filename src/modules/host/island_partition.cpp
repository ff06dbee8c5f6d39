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
  sums_.resize(points_.size());
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

void IslandPartition::cut(std::int64_t most_of_part) {
  if (most_of_part == most_of_part_) return;
  for (const auto& part : parts_) {
    weigh(part->islands, -1);
    touch(part->key());
  }
  most_of_part_ = most_of_part;
  for (const auto& part : parts_) weigh(part->islands, 1);
}

void IslandPartition::restart() {
  for (const auto& part : parts_) weigh(part->islands, -1);
  parts_.clear();
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

// ---- dividing ----

void IslandPartition::divide_changes(PartHistory* history) {
  Pool pool{*history};
  collect_changes(&pool);
  std::vector<Index> old_keys;
  for (const HostPart* const part : pool.old) {
    weigh(part->islands, -1);
    for (const HostIsland& island : part->islands) {
      part_of_key_[static_cast<std::size_t>(island.key)] = nullptr;
      old_keys.push_back(island.key);
    }
  }
  find_islands(&pool.all);
  weigh(pool.all.islands, 1);
  while (take_in_neighbours(&pool, old_keys)) {
  }
  divide(&pool);
}

/// Collects the parts of islands that have changed, and what is new.
void IslandPartition::collect_changes(Pool* pool) {
  std::set<HostPart*> old;
  const auto add = [&](Index key) {
    if (key >= 0 && part_at(key) != nullptr) old.insert(part_at(key));
  };
  for (const Index key : std::exchange(touched_, {})) add(key);
  for (ConstraintId id = first_new_; id < inventory_.next_id(); ++id) {
    if (!inventory_.has(id)) continue;
    pool->all.members.push_back(id);
    add(key_of(id));
    for (const Index point : inventory_.points(id)) add(key_of_point_[static_cast<std::size_t>(point)]);
  }
  append(std::exchange(new_points_, {}), &pool->all.moving);
  first_new_ = inventory_.next_id();
  for (HostPart* const part : old) take_in(part, pool);
  // A point may have left, and another one may have its number.
  std::erase_if(pool->all.moving, [&](Index point) {
    return points_.host_point[static_cast<std::size_t>(point)] < 0 || points_.is_support(point);
  });
  std::erase_if(pool->all.members, [&](ConstraintId id) { return !inventory_.has(id); });
  pool->all.islands.clear();
}

void IslandPartition::take_in(HostPart* part, Pool* pool) {
  pool->history.read(part);
  pool->old.push_back(part);
  append(part->islands, &pool->all.islands);
  append(part->moving, &pool->all.moving);
  append(part->members, &pool->all.members);
  append(part->guesses, &pool->all.guesses);
}

/// Sorts points and members, and finds the islands that they form.
void IslandPartition::find_islands(HostPart* all) {
  std::ranges::sort(all->moving);
  std::ranges::sort(all->members);
  all->moving.erase(std::unique(all->moving.begin(), all->moving.end()), all->moving.end());
  Index* const parent = key_of_point_.data();
  for (const Index point : all->moving) parent[point] = point;
  for (const ConstraintId id : all->members) {
    Index first = -1;
    for (const Index point : inventory_.points(id)) {
      if (points_.is_support(point)) continue;
      if (first < 0) first = point;
      join_sets(parent, first, point);
    }
  }
  std::map<Index, std::int64_t> without_points;
  for (const Index point : all->moving) {
    const Index key = parent[point] = parent[parent[point]];  // smaller points have their key
    if (key == point) {
      place_[static_cast<std::size_t>(key)] = static_cast<Index>(all->islands.size());
      all->islands.push_back({key, 0});
    }
    ++all->islands[static_cast<std::size_t>(place_[static_cast<std::size_t>(key)])].weight;
  }
  for (const ConstraintId id : all->members) {
    const Index key = key_of(id);
    const auto rows = static_cast<std::int64_t>(inventory_.num_rows(id));
    if (points_.is_support(key))
      without_points[key] += rows;
    else
      all->islands[static_cast<std::size_t>(place_[static_cast<std::size_t>(key)])].weight += rows;
  }
  for (const auto& [key, weight] : without_points) all->islands.push_back({key, weight});
}

void IslandPartition::weigh(const std::vector<HostIsland>& islands, int sign) {
  for (const HostIsland& island : islands) {
    if (island.weight <= most_of_part_) sums_.add(island.key, sign * island.weight);
  }
}

/// Takes in the parts whose islands belong together with those of the pool, or with one another where islands of the
/// pool have been. Returns true if there are any.
bool IslandPartition::take_in_neighbours(Pool* pool, const std::vector<Index>& keys) {
  std::ranges::sort(pool->all.islands, {}, &HostIsland::key);
  bool result = false;
  Index end = -1;
  const std::vector<HostIsland> islands = pool->all.islands;
  for (const HostIsland& island : islands) {
    if (island.key < end || island.weight > most_of_part_) continue;
    const DyadicSums::Interval interval = sums_.around(island.key, most_of_part_);
    end = interval.end;
    result |= take_in_interval(pool, interval, true);
  }
  for (const Index key : keys) result |= take_in_interval(pool, sums_.around(key, most_of_part_), false);
  return result;
}

bool IslandPartition::take_in_interval(Pool* pool, DyadicSums::Interval interval, bool holds_pool) {
  const auto is_small = [&](const HostPart& part) {
    return part_at(part.key()) == &part &&
           part.islands.front().weight <= most_of_part_;  // parts in the pool have no keys
  };
  auto part = std::ranges::lower_bound(parts_, interval.begin, {}, [](const auto& each) { return each->key(); });
  while (part != parts_.begin() && !is_small(**std::prev(part))) --part;
  if (part != parts_.begin() && (*std::prev(part))->islands.back().key >= interval.begin) --part;
  std::vector<HostPart*> found;
  for (; part != parts_.end() && (*part)->key() < interval.end; ++part) {
    if (is_small(**part)) found.push_back(part->get());
  }
  if (found.empty() || (found.size() == 1 && !holds_pool)) return false;
  for (HostPart* const each : found) {
    take_in(each, pool);
    for (const HostIsland& island : each->islands) part_of_key_[static_cast<std::size_t>(island.key)] = nullptr;
  }
  return true;
}

/// Divides the pool into new parts, which replace the old ones.
void IslandPartition::divide(Pool* pool) {
  std::ranges::sort(pool->old);
  std::erase_if(parts_, [&](const auto& part) { return std::ranges::binary_search(pool->old, part.get()); });
  HostPart& all = pool->all;
  std::ranges::sort(all.islands, {}, &HostIsland::key);
  std::ranges::sort(all.moving);
  std::ranges::sort(all.members);
  HostPart* shared = nullptr;
  Index end = -1;
  const std::size_t num_kept = parts_.size();
  for (const HostIsland& island : all.islands) {
    const bool is_alone = island.weight > most_of_part_;
    if (is_alone || island.key >= end) {
      parts_.push_back(std::make_unique<HostPart>());
      if (!is_alone) {
        shared = parts_.back().get();
        end = sums_.around(island.key, most_of_part_).end;
      }
    }
    HostPart* const part = is_alone ? parts_.back().get() : shared;
    part->islands.push_back(island);
    part_of_key_[static_cast<std::size_t>(island.key)] = part;
  }
  for (const Index point : all.moving) part_at(key_of_point_[static_cast<std::size_t>(point)])->moving.push_back(point);
  for (const ConstraintId id : all.members) part_of(id)->members.push_back(id);
  for (const MultiplierGuess& guess : all.guesses) {
    if (inventory_.has(guess.id)) part_of(guess.id)->guesses.push_back(guess);
  }
  std::ranges::sort(parts_.begin() + static_cast<std::ptrdiff_t>(num_kept), parts_.end(), {},
                    [](const auto& part) { return part->key(); });
  std::ranges::inplace_merge(parts_, parts_.begin() + static_cast<std::ptrdiff_t>(num_kept), {},
                             [](const auto& part) { return part->key(); });
}

}  // namespace tanor::detail
