#include "evaluate/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tanor::detail {

namespace {

/// Resizes with room to spare. Sizes vary from list to list, and soon no more memory is allocated.
template <class Number>
void resize_with_room(std::size_t size, std::vector<Number>* vector) {
  if (size > vector->capacity()) vector->reserve(size + size / 4);
  vector->resize(size);
}

/// Returns the largest square of the vectors of(i); NaN if one is not finite.
template <class Of>
double largest_square(const Parallel& parallel, std::size_t count, const Of& of) {
  return parallel.max_over_ranges(count, [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) worst = larger(worst, squared(of(i)));
    return worst;
  });
}

}  // namespace

void PointRoom::add(Vec3 r) {
  const std::array<double, 6> here{r.x, r.y, r.z, -r.x, -r.y, -r.z};
  for (std::size_t c = 0; c < ends_.size(); ++c) ends_[c] = std::max(ends_[c], here[c]);
}

bool PointRoom::is_crowded(std::size_t num_points, double radius) const {
  constexpr std::size_t few_points = 1000;
  constexpr double most_spacings = 3.0;
  if (num_points <= few_points) return false;
  double volume = 1.0, dimensions = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double extent = ends_[c] + ends_[c + 3];
    if (!(extent > 0.0)) continue;
    volume *= extent;
    dimensions += 1.0;
  }
  const double spacing = std::pow(volume / static_cast<double>(num_points), 1.0 / std::max(dimensions, 1.0));
  return radius > most_spacings * spacing;
}

bool NeighbourLists::follow(const Parallel& parallel, const std::vector<Vec3>& places) {
  const bool is_first = places_.size() != places.size();
  const double move2 = largest_square(parallel, places.size(),
                                      [&](std::size_t i) { return is_first ? places[i] : places[i] - places_[i]; });
  if (!std::isfinite(move2)) return false;
  if (!is_first && move2 <= 0.2499 * skin_ * skin_) return true;  // slightly below a quarter, for rounding
  make(parallel, places, skin_);
  return true;
}

bool NeighbourLists::cover(const Parallel& parallel, const std::vector<Vec3>& places, double reach) const {
  if (places_.size() != places.size()) return false;
  const double move2 = largest_square(parallel, places.size(), [&](std::size_t i) { return places[i] - places_[i]; });
  return std::sqrt(move2) + reach < 0.4999 * skin_;
}

void NeighbourLists::make(const Parallel& parallel, const std::vector<Vec3>& places, double skin) {
  skin_ = skin;
  radius_ = cutoff_ + skin;
  ++version_;
  places_ = places;
  lay_out_cells(places);
  sort_into_cells(places);
  make_lists(parallel, places);
}

Index NeighbourLists::Axis::cell(double x) const {
  if (count == 1) return 0;
  double s = scale * (x - origin);
  if (is_periodic) s -= std::floor(s);
  return std::min(static_cast<Index>(s * count), count - 1);
}

int NeighbourLists::Axis::around(Index cell, std::array<std::array<Index, 2>, 3>* runs) const {
  Index first = cell - 1, last = cell + 2;
  int found = 0;
  if (count < 3) {
    first = 0;
    last = count;
  } else if (is_periodic && first < 0) {
    (*runs)[found++] = {count - 1, count};
  } else if (is_periodic && last > count) {
    (*runs)[found++] = {0, 1};
  }
  (*runs)[found++] = {std::max(first, Index{0}), std::min(last, count)};
  return found;
}

/// Divides the box, or the extent of the points, into cells that are not narrower than the radius and not many more
/// than the points.
void NeighbourLists::lay_out_cells(const std::vector<Vec3>& places) {
  Vec3 low = places[0], high = places[0];
  for (const Vec3& place : places) {
    low = {std::min(low.x, place.x), std::min(low.y, place.y), std::min(low.z, place.z)};
    high = {std::max(high.x, place.x), std::max(high.y, place.y), std::max(high.z, place.z)};
  }
  const Vec3 edges = box_.edges();
  const auto axis = [](double edge, double from, double to) {
    return edge > 0.0 ? Axis{true, 0.0, 1.0 / edge, 1} : Axis{false, from, to > from ? 1.0 / (to - from) : 0.0, 1};
  };
  axes_ = {axis(edges.x, low.x, high.x), axis(edges.y, low.y, high.y), axis(edges.z, low.z, high.z)};

  // The count is slightly less than fits, so that rounding finds no neighbour two cells away.
  const double most = 1.0 + 2.0 * static_cast<double>(places.size());
  std::array<double, 3> counts;
  for (std::size_t k = 0; k < 3; ++k) {
    const double fits = axes_[k].scale > 0.0 ? (1.0 - 1e-9) / (axes_[k].scale * radius_) : 1.0;
    counts[k] = std::clamp(std::floor(fits), 1.0, most);
  }
  while (counts[0] * counts[1] * counts[2] > most) {
    double& longest = *std::max_element(counts.begin(), counts.end());
    longest = std::ceil(0.5 * longest);
  }
  for (std::size_t k = 0; k < 3; ++k) axes_[k].count = static_cast<Index>(counts[k]);
}

/// Sorts the points into cells by counting.
void NeighbourLists::sort_into_cells(const std::vector<Vec3>& places) {
  const auto number_of = [&](const std::array<Index, 3>& c) {
    return (static_cast<std::size_t>(c[0]) * axes_[1].count + c[1]) * axes_[2].count + c[2];
  };
  const std::size_t num_cells = number_of({axes_[0].count - 1, axes_[1].count - 1, axes_[2].count - 1}) + 1;
  cell_of_.resize(places.size());
  cell_places_.resize(places.size());
  cells_.entries.resize(places.size());
  resize_with_room(num_cells + 1, &cells_.start);
  resize_with_room(num_cells, &next_);
  std::fill(next_.begin(), next_.end(), 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    cell_of_[i] = {axes_[0].cell(places[i].x), axes_[1].cell(places[i].y), axes_[2].cell(places[i].z)};
    ++next_[number_of(cell_of_[i])];
  }
  Index sum = 0;
  for (std::size_t c = 0; c < num_cells; ++c) {
    cells_.start[c] = sum;
    sum += next_[c];
    next_[c] = cells_.start[c];
  }
  cells_.start[num_cells] = sum;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto slot = static_cast<std::size_t>(next_[number_of(cell_of_[i])]++);
    cells_.entries[slot] = static_cast<Index>(i);
    cell_places_[slot] = places[i];
  }
}

bool NeighbourLists::is_pair(std::size_t i, Index j) const {
  if (static_cast<std::size_t>(j) == i) return false;
  if (i >= num_moving_ && static_cast<std::size_t>(j) >= num_moving_) return false;
  const std::span<const Index> excluded = excluded_[i];
  return std::find(excluded.begin(), excluded.end(), j) == excluded.end();
}

template <class Visit>
void NeighbourLists::visit_neighbours(const std::vector<Vec3>& places, std::size_t i, const Visit& visit) const {
  std::array<std::array<std::array<Index, 2>, 3>, 3> runs;
  std::array<int, 3> count;
  for (std::size_t k = 0; k < 3; ++k) count[k] = axes_[k].around(cell_of_[i][k], &runs[k]);
  const auto visit_slots = [&](std::size_t begin, std::size_t end) {
    const double radius2 = radius_ * radius_;
    for (std::size_t slot = begin; slot < end; ++slot) {
      if (squared(box_.nearest_image(cell_places_[slot] - places[i])) > radius2) continue;
      if (is_pair(i, cells_.entries[slot])) visit(cells_.entries[slot]);
    }
  };
  for (int run_a = 0; run_a < count[0]; ++run_a) {
    for (Index a = runs[0][run_a][0]; a < runs[0][run_a][1]; ++a) {
      for (int run_b = 0; run_b < count[1]; ++run_b) {
        for (Index b = runs[1][run_b][0]; b < runs[1][run_b][1]; ++b) {
          // Cells along the last axis lie side by side.
          const std::size_t row = (static_cast<std::size_t>(a) * axes_[1].count + b) * axes_[2].count;
          for (int run_c = 0; run_c < count[2]; ++run_c) {
            const auto [first, last] = runs[2][run_c];
            visit_slots(static_cast<std::size_t>(cells_.start[row + first]),
                        static_cast<std::size_t>(cells_.start[row + last]));
          }
        }
      }
    }
  }
}

void NeighbourLists::make_lists(const Parallel& parallel, const std::vector<Vec3>& places) {
  constexpr std::size_t most_chunks = 64;
  const std::size_t n = places.size();
  chunks_.resize(std::min(n, most_chunks));
  num_neighbours_.resize(n);
  parallel.for_ranges(
      chunks_.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
          Chunk& chunk = chunks_[c];
          chunk.first = n * c / chunks_.size();
          chunk.last = n * (c + 1) / chunks_.size();
          chunk.neighbours.clear();
          for (std::size_t i = chunk.first; i < chunk.last; ++i) {
            const auto before = static_cast<std::ptrdiff_t>(chunk.neighbours.size());
            visit_neighbours(places, i, [&](Index j) { chunk.neighbours.push_back(j); });
            std::sort(chunk.neighbours.begin() + before, chunk.neighbours.end());
            num_neighbours_[i] = chunk.neighbours.size() - static_cast<std::size_t>(before);
          }
          // Sizes vary from list to list. With room to spare, soon no more memory is allocated.
          const std::size_t size = chunk.neighbours.size();
          if (chunk.neighbours.capacity() < size + size / 8) chunk.neighbours.reserve(2 * size);
        }
      },
      1 + points_worth_a_thread * chunks_.size() / (n + 1));
  num_pairs_ = std::accumulate(num_neighbours_.begin(), num_neighbours_.end(), std::size_t{0});
}

}  // namespace tanor::detail
