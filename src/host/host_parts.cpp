#include "host/host_parts.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "base/disjoint_sets.hpp"
#include "host/point_address.hpp"

namespace tanor {

namespace {

template <class Number>
void append(const std::vector<Number>& from, std::vector<Number>* to) {
  to->insert(to->end(), from.begin(), from.end());
}

}  // namespace

void copy_points(const ConstPointArray& from, std::span<const Index> number, double* to) {
  for (std::size_t i = 0; i < number.size(); ++i)
    std::ranges::copy(read_point(from, i), to + 3 * static_cast<std::size_t>(number[i]));
}

HostParts::HostParts(HostPoints points, std::optional<PeriodicCell> cell, const SolverOptions& options)
    : points_(std::move(points)), cell_(cell), options_(options), parallel_(options.threads) {
  if (cell_) points_.cell = *cell_;
  list_points();
  for (const Index point : points_.of_host) {
    if (!points_.is_support(point)) new_points_.push_back(point);
  }
}

/// After points have come or gone.
void HostParts::list_points() {
  supports_.clear();
  for (const Index point : points_.of_host) {
    if (points_.is_support(point)) supports_.push_back(point);
  }
  key_of_point_.resize(points_.size(), -1);
  part_of_key_.resize(points_.size(), nullptr);
  local_.resize(points_.size(), -1);
  sums_.resize(points_.size());
}

// ---- edits ----

ConstraintId HostParts::add(Constraint group, std::vector<std::array<int, 3>> images) {
  has_changed_ = true;
  if (!images.empty() && !inventory_.has_images()) {  // all others have images too, from now on
    for (const auto& part : parts_) touch(part->key());
  }
  return inventory_.add(std::move(group), std::move(images));
}

void HostParts::remove(std::span<const ConstraintId> ids) {
  for (const ConstraintId id : ids) {
    if (id < first_new_) touch(key_of(id));
  }
  inventory_.remove(ids);
  has_changed_ = true;
}

void HostParts::set_length(ConstraintId id, double length, double rate) {
  const bool is_read = inventory_.set_length(id, length, rate);
  if (id >= first_new_) return;
  const Index key = key_of(id);
  if (!is_read) return touch(key);
  if (ConstrainedHost* const host = part_of(key)->host.get()) {
    host->work.constraints.set_time(host->work.time());
    host->place.stands = false;
  }
}

void HostParts::set_mass(Index point, double mass) {
  if (std::exchange(points_.mass[static_cast<std::size_t>(point)], mass) == mass || points_.is_support(point)) return;
  if (const Index key = key_of_point_[static_cast<std::size_t>(point)]; key >= 0) touch(key);
}

void HostParts::renumber(std::vector<Index> of_host, std::span<const double> masses) {
  std::vector<Index> host_point(points_.size(), -1);
  for (std::size_t i = 0; i < of_host.size(); ++i) {
    if (of_host[i] >= 0) host_point[static_cast<std::size_t>(of_host[i])] = static_cast<Index>(i);
  }
  for (std::size_t point = 0; point < host_point.size(); ++point) {
    if (host_point[point] < 0 && key_of_point_[point] >= 0) touch(std::exchange(key_of_point_[point], -1));
  }
  auto free = host_point.begin();
  for (std::size_t i = 0; i < of_host.size(); ++i) {
    if (of_host[i] >= 0) {
      set_mass(of_host[i], masses[i]);
      continue;
    }
    const auto place = std::find(free, host_point.end(), -1);
    of_host[i] = static_cast<Index>(place - host_point.begin());
    const auto point = static_cast<std::size_t>(of_host[i]);
    if (place == host_point.end()) {
      host_point.push_back(-1);
      points_.mass.push_back(0.0);
      points_.positions.resize(points_.positions.size() + 3);
    }
    host_point[point] = static_cast<Index>(i);
    free = host_point.begin() + of_host[i];
    points_.mass[point] = masses[i];
    if (!points_.is_support(of_host[i])) new_points_.push_back(of_host[i]);
  }
  points_.host_point = std::move(host_point);
  points_.of_host = std::move(of_host);
  list_points();
  for (const auto& part : parts_) {
    if (part->host != nullptr) set_host_points(*part);
  }
  has_changed_ = true;
}

void HostParts::set_positions(const ConstPointArray& at) {
  read_positions();  // nothing is read from parts later
  copy_points(at, points_.of_host, points_.positions.data());
  if (cell_) points_.cell = *cell_;
}

void HostParts::read_positions() {
  for (const auto& part : parts_) read_positions(part.get());
}

void HostParts::set_cell(const PeriodicCell& cell) {
  (void)plan();
  const auto set = [&](const PeriodicCell& now) {
    for (const auto& part : parts_) part->host->images->set_cell(now);
  };
  const PeriodicCell old = *cell_;
  set(cell);
  for (const auto& part : parts_) {
    try {
      part->host->check_cell();
    } catch (const InputError& wrong) {
      set(old);
      throw InputError(wrong.where(), with_names(*part, wrong.what()));
    }
  }
  cell_ = cell;
  for (const auto& part : parts_) {
    if (part->host->images->close_ways()) touch(part->key());
  }
}

void HostParts::exchange_memory(Memory& memory) {
  (void)plan();
  std::vector<Index> of_host = points_.of_host;
  std::size_t size = points_.size();
  memory.exchange(size, of_host);
  if (memory.reads() && (of_host != points_.of_host || size != points_.size())) rename_points(of_host, size);
  bool is_cut = most_of_part_ < no_limit;
  memory.exchange(is_cut);
  cut(is_cut ? most_after_edits : no_limit);
  (void)plan_changes();
  for (const auto& part : parts_) {
    part->host->form.exchange_memory(memory);
    part->host->place.stands = false;  // here and there the next call factorizes
  }
}

/// All is planned anew.
void HostParts::rename_points(const std::vector<Index>& of_host, std::size_t size) {
  read_positions();
  HostPoints points{of_host, std::vector<Index>(size, -1), std::vector<double>(size), std::vector<double>(3 * size),
                    points_.cell};
  if (size < of_host.size()) Memory::refuse();
  for (std::size_t i = 0; i < of_host.size(); ++i) {
    const auto to = static_cast<std::size_t>(of_host[i]), from = static_cast<std::size_t>(points_.of_host[i]);
    if (of_host[i] < 0 || to >= size || points.host_point[to] >= 0) Memory::refuse();
    points.host_point[to] = static_cast<Index>(i);
    points.mass[to] = points_.mass[from];
    std::copy_n(&points_.positions[3 * from], 3, &points.positions[3 * to]);
  }
  inventory_.rename_points([&](Index point) {
    return of_host[static_cast<std::size_t>(points_.host_point[static_cast<std::size_t>(point)])];
  });
  points_ = std::move(points);
  for (const auto& part : parts_) weigh(part->islands, -1);
  parts_.clear();
  key_of_point_.assign(points_.size(), -1);
  part_of_key_.assign(points_.size(), nullptr);
  list_points();
  new_points_.clear();
  for (const Index point : points_.of_host) {
    if (!points_.is_support(point)) new_points_.push_back(point);
  }
  touched_.clear();
  first_new_ = 0;
  has_changed_ = true;
  (void)plan();
}

// ---- which islands are together ----

void HostParts::touch(Index key) {
  touched_.insert(key);
  has_changed_ = true;
}

/// All is planned anew in parts of no more than that.
void HostParts::cut(std::int64_t most_of_part) {
  if (most_of_part == most_of_part_) return;
  for (const auto& part : parts_) {
    weigh(part->islands, -1);
    touch(part->key());
  }
  most_of_part_ = most_of_part;
  for (const auto& part : parts_) weigh(part->islands, 1);
}

/// Constraints of supports alone are islands with the smallest of them as key.
Index HostParts::key_of(ConstraintId id) const {
  const std::span<const Index> points = inventory_.points(id);
  for (const Index point : points) {
    if (!points_.is_support(point)) return key_of_point_[static_cast<std::size_t>(point)];
  }
  return *std::ranges::min_element(points);
}

void HostParts::expect_edits() {
  cut(most_after_edits);
}

std::size_t HostParts::plan() {
  const bool has_edits = !touched_.empty() || !new_points_.empty() || first_new_ < inventory_.next_id();
  if (first_new_ > 0 && has_edits) expect_edits();
  return plan_changes();
}

std::size_t HostParts::plan_changes() {
  if (!has_changed_) return 0;
  Pool pool = collect_changes();
  std::vector<Index> old_keys;
  for (const Part* const part : pool.old) {
    weigh(part->islands, -1);
    for (const Island& island : part->islands) {
      part_of_key_[static_cast<std::size_t>(island.key)] = nullptr;
      old_keys.push_back(island.key);
    }
  }
  find_islands(&pool.all);
  weigh(pool.all.islands, 1);
  while (take_in_neighbours(&pool, old_keys)) {
  }
  divide(&pool);
  std::size_t result = 0;
  for (const auto& part : parts_) {
    if (part->host != nullptr) continue;
    build(part.get());
    result += part->islands.size();
  }
  for (const auto& part : parts_) number_rows(part.get());
  summarise();
  has_changed_ = false;
  return result;
}

/// The parts of islands that have changed, and what is new.
HostParts::Pool HostParts::collect_changes() {
  Pool pool;
  std::set<Part*> old;
  const auto add = [&](Index key) {
    if (key >= 0 && part_of(key) != nullptr) old.insert(part_of(key));
  };
  for (const Index key : std::exchange(touched_, {})) add(key);
  for (ConstraintId id = first_new_; id < inventory_.next_id(); ++id) {
    if (!inventory_.has(id)) continue;
    pool.all.members.push_back(id);
    add(key_of(id));
    for (const Index point : inventory_.points(id)) add(key_of_point_[static_cast<std::size_t>(point)]);
  }
  append(std::exchange(new_points_, {}), &pool.all.moving);
  first_new_ = inventory_.next_id();
  for (Part* const part : old) take_in(part, &pool);
  // A point may have left, and another one may have its number.
  std::erase_if(pool.all.moving, [&](Index point) {
    return points_.host_point[static_cast<std::size_t>(point)] < 0 || points_.is_support(point);
  });
  std::erase_if(pool.all.members, [&](ConstraintId id) { return !inventory_.has(id); });
  pool.all.islands.clear();
  return pool;
}

void HostParts::take_in(Part* part, Pool* pool) {
  read_positions(part);
  read_guesses(part);
  pool->old.push_back(part);
  append(part->islands, &pool->all.islands);
  append(part->moving, &pool->all.moving);
  append(part->members, &pool->all.members);
  append(part->guesses, &pool->all.guesses);
}

/// Sorts points and members, and finds what they connect.
void HostParts::find_islands(Part* all) {
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
    const Index key = parent[point] = parent[parent[point]];  // smaller ones know theirs
    if (key == point) {
      local_[static_cast<std::size_t>(key)] = static_cast<Index>(all->islands.size());
      all->islands.push_back({key, 0});
    }
    ++all->islands[static_cast<std::size_t>(local_[static_cast<std::size_t>(key)])].weight;
  }
  for (const ConstraintId id : all->members) {
    const Index key = key_of(id);
    const auto rows = static_cast<std::int64_t>(inventory_.num_rows(id));
    if (points_.is_support(key))
      without_points[key] += rows;
    else
      all->islands[static_cast<std::size_t>(local_[static_cast<std::size_t>(key)])].weight += rows;
  }
  for (const auto& [key, weight] : without_points) all->islands.push_back({key, weight});
}

void HostParts::weigh(const std::vector<Island>& islands, int sign) {
  for (const Island& island : islands) {
    if (island.weight <= most_of_part_) sums_.add(island.key, sign * island.weight);
  }
}

/// Parts whose islands belong together with those of the pool, or with one another where those of the pool have been.
/// Returns whether there are any.
bool HostParts::take_in_neighbours(Pool* pool, const std::vector<Index>& keys) {
  std::ranges::sort(pool->all.islands, {}, &Island::key);
  bool result = false;
  Index end = -1;
  const std::vector<Island> islands = pool->all.islands;
  for (const Island& island : islands) {
    if (island.key < end || island.weight > most_of_part_) continue;
    const DyadicSums::Interval interval = sums_.around(island.key, most_of_part_);
    end = interval.end;
    result |= take_in_interval(pool, interval, true);
  }
  for (const Index key : keys) result |= take_in_interval(pool, sums_.around(key, most_of_part_), false);
  return result;
}

bool HostParts::take_in_interval(Pool* pool, DyadicSums::Interval interval, bool holds_pool) {
  const auto is_small = [&](const Part& part) {
    return part_of(part.key()) == &part &&
           part.islands.front().weight <= most_of_part_;  // parts in the pool have no keys
  };
  auto part = std::ranges::lower_bound(parts_, interval.begin, {}, [](const auto& each) { return each->key(); });
  while (part != parts_.begin() && !is_small(**std::prev(part))) --part;
  if (part != parts_.begin() && (*std::prev(part))->islands.back().key >= interval.begin) --part;
  std::vector<Part*> found;
  for (; part != parts_.end() && (*part)->key() < interval.end; ++part) {
    if (is_small(**part)) found.push_back(part->get());
  }
  if (found.empty() || (found.size() == 1 && !holds_pool)) return false;
  for (Part* const each : found) {
    take_in(each, pool);
    for (const Island& island : each->islands) part_of_key_[static_cast<std::size_t>(island.key)] = nullptr;
  }
  return true;
}

/// The pool into new parts, which take the place of the old ones.
void HostParts::divide(Pool* pool) {
  std::ranges::sort(pool->old);
  std::erase_if(parts_, [&](const auto& part) { return std::ranges::binary_search(pool->old, part.get()); });
  Part& all = pool->all;
  std::ranges::sort(all.islands, {}, &Island::key);
  std::ranges::sort(all.moving);
  std::ranges::sort(all.members);
  Part* shared = nullptr;
  Index end = -1;
  const std::size_t num_kept = parts_.size();
  for (const Island& island : all.islands) {
    const bool is_alone = island.weight > most_of_part_;
    if (is_alone || island.key >= end) {
      parts_.push_back(std::make_unique<Part>());
      if (!is_alone) {
        shared = parts_.back().get();
        end = sums_.around(island.key, most_of_part_).end;
      }
    }
    Part* const part = is_alone ? parts_.back().get() : shared;
    part->islands.push_back(island);
    part_of_key_[static_cast<std::size_t>(island.key)] = part;
  }
  for (const Index point : all.moving) part_of(key_of_point_[static_cast<std::size_t>(point)])->moving.push_back(point);
  for (const ConstraintId id : all.members) part_of(key_of(id))->members.push_back(id);
  for (const Guess& guess : all.guesses) {
    if (inventory_.has(guess.id)) part_of(key_of(guess.id))->guesses.push_back(guess);
  }
  std::ranges::sort(parts_.begin() + static_cast<std::ptrdiff_t>(num_kept), parts_.end(), {},
                    [](const auto& part) { return part->key(); });
  std::ranges::inplace_merge(parts_, parts_.begin() + static_cast<std::ptrdiff_t>(num_kept), {},
                             [](const auto& part) { return part->key(); });
}

}  // namespace tanor
