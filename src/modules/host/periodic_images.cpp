#include "host/periodic_images.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/groups.hpp"
#include "system/members.hpp"

namespace tanor::detail {

// ---- the lattice ----

Lattice::Lattice(const PeriodicCell& cell) : repeats_(cell.repeats) {
  for (std::size_t k = 0; k < 3; ++k) edge_[k] = make_vec3(cell.edges[k]);
  const double volume = dot(edge_[0], cross(edge_[1], edge_[2]));
  const double largest = norm(edge_[0]) * norm(edge_[1]) * norm(edge_[2]);
  for (std::size_t k = 0; k < 3; ++k) reciprocal_[k] = (1.0 / volume) * cross(edge_[(k + 1) % 3], edge_[(k + 2) % 3]);
  // Edges of 1e-320 span space, but their reciprocals are not finite.
  const double sizes = volume + norm(reciprocal_[0]) + norm(reciprocal_[1]) + norm(reciprocal_[2]);
  if (!(std::abs(volume) > 1e-10 * largest) || !std::isfinite(sizes))
    throw InputError("/cell", "the three edges of a cell are finite and span space, also those that do not repeat");
}

/// A coordinate that is no number has no image, or it would spoil the others.
Vec3 Lattice::round(Vec3 fraction) const {
  const auto nearest = [&](double x, std::size_t k) {
    return repeats_[k] && std::isfinite(x) ? std::nearbyint(x) : 0.0;
  };
  return {nearest(fraction.x, 0), nearest(fraction.y, 1), nearest(fraction.z, 2)};
}

double Lattice::smallest_height() const {
  double result = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    if (repeats_[k]) result = std::min(result, 1.0 / norm(reciprocal_[k]));
  }
  return result;
}

// ---- the tree ----

namespace {

/// A member with its first row.
struct Joined {
  std::vector<Index> points;
  std::size_t row;
};

Vec3 make_counts(const std::array<int, 3>& n) {
  return {static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])};
}

bool is_zero(Vec3 n) {
  return n.x == 0.0 && n.y == 0.0 && n.z == 0.0;
}

}  // namespace

PeriodicImages::PeriodicImages(const System& system, const Periodicity& given)
    : cell_(given.cell), lattice_(given.cell) {
  if (!given.images.empty() && given.images.size() != num_equations(system)) {
    throw InputError("/cell", "images has " + std::to_string(given.images.size()) + " entries; " +
                                  std::to_string(num_equations(system)) + " are needed, one a row");
  }
  grow_tree(system, given.images);
  count_edges_apart(system, given.images);
}

void PeriodicImages::set_cell(const PeriodicCell& cell) {
  lattice_ = Lattice(cell);
  cell_ = cell;
}

/// Grows a tree breadth first from each point that is not reached yet, along members with their first rows.
void PeriodicImages::grow_tree(const System& system, std::span<const std::array<int, 3>> images) {
  std::vector<Joined> members;
  std::size_t row = 0;
  for_each_member(system, [&](std::span<const Index> points, int rows) {
    if (points.size() > 1) members.push_back({{points.begin(), points.end()}, row});
    row += static_cast<std::size_t>(rows);
  });
  const Groups<Index> members_of_point(system.num_points(), [&](const auto& add) {
    for (std::size_t k = 0; k < members.size(); ++k)
      for (const Index point : members[k].points) add(point, static_cast<Index>(k));
  });
  const bool are_given = !images.empty();
  if (are_given) counts_.assign(system.num_points(), {});
  std::vector<char> is_reached(system.num_points(), 0);
  for (std::size_t root = 0; root < system.num_points(); ++root) {
    if (std::exchange(is_reached[root], 1) != 0) continue;
    tree_start_.push_back(branches_.size());
    branches_.push_back({static_cast<Index>(root), -1});
    for (std::size_t head = tree_start_.back(); head < branches_.size(); ++head) {
      const Index parent = branches_[head].point;
      for (const Index k : members_of_point[static_cast<std::size_t>(parent)]) {
        const Joined& member = members[static_cast<std::size_t>(k)];
        for (const Index point : member.points) {
          if (std::exchange(is_reached[static_cast<std::size_t>(point)], 1) != 0) continue;
          branches_.push_back({point, parent});
          if (!are_given) continue;
          // r_j + H n is the image that belongs to r_i
          const Vec3 n = make_counts(images[member.row]);
          const Vec3 own = counts_[static_cast<std::size_t>(parent)];
          counts_[static_cast<std::size_t>(point)] = parent == member.points[0] ? own + n : own - n;
        }
      }
    }
  }
  tree_start_.push_back(branches_.size());
}

/// Finds by how many edges the ends of each rod are apart. Only rods of a net that closes round the cell have such
/// offsets.
void PeriodicImages::count_edges_apart(const System& system, std::span<const std::array<int, 3>> images) {
  std::vector<double> x(system.positions.size());
  unwrap(Parallel(1), lattice_, system.positions.data(), x.data());
  const auto apart = [&](Index i, Index j, std::size_t row) {
    if (!are_nearest())
      return counts_[static_cast<std::size_t>(i)] + make_counts(images[row]) - counts_[static_cast<std::size_t>(j)];
    return lattice_.round(lattice_.fraction(load(x.data(), i) - load(x.data(), j)));
  };
  std::size_t row = 0;
  for (std::size_t g = 0; g < system.constraints.size(); ++g) {
    apart_.emplace_back();
    const auto look = [&]<class Group>(const Group& group) {
      bool some = false;
      for (std::size_t k = 0; k < num_members(group); ++k) {
        const std::span<const Index> points = member_points(group, k);
        for (std::size_t p = 1; p < points.size(); ++p) {
          const Vec3 n = apart(points[0], points[p], row);
          some = some || !is_zero(n);
          if constexpr (std::is_same_v<Group, Rods>) apart_.back().push_back(n);
          if (!std::is_same_v<Group, Rods> && !is_zero(n))
            throw InputError("/cell",
                             equation_name(system, row) + " closes a way round the cell, which rods alone can");
        }
        row += static_cast<std::size_t>(rows_per_member<Group>());
      }
      if constexpr (std::is_same_v<Group, Rods>) {
        if (!group.offsets.empty())
          throw InputError("/cell", constraint_name(system, g) + " has offsets; in a cell rods have images instead");
      }
      if (!some) apart_.back().clear();
      closes_ = closes_ || some;
    };
    std::visit(look, system.constraints[g]);
  }
}

void PeriodicImages::set_positions(System* system) const {
  const std::vector<double> host = system->positions;
  unwrap(Parallel(1), lattice_, host.data(), system->positions.data());
}

void PeriodicImages::set_offsets(System* system) const {
  for (std::size_t g = 0; g < apart_.size(); ++g) {
    if (apart_[g].empty()) continue;
    Rods& rods = std::get<Rods>(system->constraints[g]);
    rods.offsets.clear();
    for (const Vec3& n : apart_[g]) {
      const Vec3 offset = lattice_.vector(n);
      rods.offsets.push_back({offset.x, offset.y, offset.z});
    }
  }
}

// ---- in a step ----

void PeriodicImages::use(const System& system, const Numbering& numbering) {
  std::size_t member = 0;
  for (std::size_t g = 0; g < system.constraints.size(); ++g) {
    for (std::size_t k = 0; k < apart_[g].size(); ++k) {
      if (!is_zero(apart_[g][k]))
        closing_rods_.push_back({static_cast<std::size_t>(numbering.member_row[member + k]), apart_[g][k]});
    }
    member += shape_of(system.constraints[g]).members;
  }
  std::ranges::sort(closing_rods_, {}, &ClosingRod::row);
  const auto inner = [&](Index point) { return numbering.inner_point[static_cast<std::size_t>(point)]; };
  for (Branch& branch : branches_) {
    branch.point = inner(branch.point);
    if (branch.parent >= 0) branch.parent = inner(branch.parent);
  }
  if (counts_.empty()) return;
  const std::vector<Vec3> of_user = counts_;
  for (std::size_t i = 0; i < counts_.size(); ++i)
    counts_[i] = of_user[static_cast<std::size_t>(numbering.user_point[i])];
}

std::span<const Constraints::RowOffset> PeriodicImages::find_offsets(const Lattice& lattice, const Lattice* before) {
  offsets_.clear();
  for (const auto& [row, apart] : closing_rods_)
    offsets_.push_back({row, lattice.vector(apart) - (before != nullptr ? before->vector(apart) : Vec3{})});
  return offsets_;
}

void PeriodicImages::unwrap(const Parallel& parallel, const Lattice& lattice, const double* host, double* x) const {
  if (!are_nearest()) {
    parallel.for_ranges(counts_.size(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) store(x, i, load(host, i) + lattice.vector(counts_[i]));
    });
    return;
  }
  const std::size_t num_trees = tree_start_.size() - 1, mean = branches_.size() / std::max<std::size_t>(1, num_trees);
  const auto unwrap_trees = [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = tree_start_[begin]; k < tree_start_[end]; ++k) {
      const auto [point, parent] = branches_[k];
      const Vec3 r = load(host, point);
      if (parent < 0) {
        store(x, point, r);
        continue;
      }
      store(x, point, r + lattice.vector(lattice.round(lattice.fraction(load(x, parent) - r))));
    }
  };
  parallel.for_ranges(num_trees, unwrap_trees, std::max<std::size_t>(1, 2048 / std::max<std::size_t>(1, mean)));
}

void PeriodicImages::follow(const Parallel& parallel, const Lattice& before, const double* x, double* r) const {
  const std::size_t count = branches_.size();
  parallel.for_ranges(count, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 now = load(r, i);
      const Vec3 n = are_nearest() ? lattice_.round(before.fraction(load(x, i)) - lattice_.fraction(now)) : counts_[i];
      store(r, i, now + lattice_.vector(n));
    }
  });
}

}  // namespace tanor::detail
