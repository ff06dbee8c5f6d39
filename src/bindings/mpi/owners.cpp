#include <metis.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/disjoint_sets.hpp"
#include "base/groups.hpp"
#include "mpi/metis_counts.hpp"
#include "mpi/tanor_mpi.hpp"
#include "system/chosen_members.hpp"

namespace tanor {
using namespace detail;

namespace {

constexpr int nobody = -1;

/// Points that are joined. A cluster may be cut unless something holds it together.
struct Cluster {
  std::vector<Index> points;
  double rows = 0.0;
  bool may_be_cut = true;

  /// Returns the predicted time of an evaluation, ns. It was measured on chains (20 a row) and nets
  /// (bench/linear_solvers), where rows that close rings make fill.
  double cost() const {
    const double rings = std::max(0.0, rows + 1.0 - static_cast<double>(points.size()));
    return 10.0 * static_cast<double>(points.size()) + 20.0 * rows + std::pow(rings, 1.5);
  }
};

/// Calls visit(points, rows) for what joins points and may be cut: members of constraints, and tuples of forces, which
/// have no rows.
template <class Visit>
void for_each_link(const System& system, const Visit& visit) {
  for_each_member(system, visit);
  for_each_tuple(system, [&](std::span<const Index> points) { visit(points, 0); });
}

class Clusters {
 public:
  Clusters(const System& system, Islands islands) : system_(system), root_(system.num_points()) {
    std::iota(root_.begin(), root_.end(), 0);
    for (const Support& support : system.supports)
      for (const Index point : support.points) root_[static_cast<std::size_t>(point)] = nobody;
    for_each_link(system, [&](std::span<const Index> points, int) { join_all(points, &root_); });
    join_bundles(islands);
    number();
    for_each_link(system, [&](std::span<const Index> points, int rows) {
      const auto moves = std::ranges::find_if(points, [&](Index point) { return of_point(point) != nobody; });
      if (moves != points.end()) clusters_[static_cast<std::size_t>(of_point(*moves))].rows += rows;
    });
    for (const Index point : bundled_) clusters_[static_cast<std::size_t>(of_point(point))].may_be_cut = false;
    if (islands == Islands::AreWhole)
      for (Cluster& cluster : clusters_) cluster.may_be_cut = false;
  }

  const std::vector<Cluster>& all() const { return clusters_; }
  /// True if some pair forces reach from cluster to cluster.
  bool has_shared_pairs() const { return has_shared_pairs_; }

  /// Cuts one cluster with METIS into pieces of equally many points, and returns the piece of each of its points.
  /// Points that a force joins to a support stay together, since what the support carries is counted there.
  std::vector<int> cut(const Cluster& cluster, int pieces) {
    std::vector<idx_t> weights = number_vertices(cluster);
    const auto is_here = [&](Index point) { return of_point(point) == of_point(cluster.points.front()); };
    const auto vertex_of = [&](Index point) { return vertex_[static_cast<std::size_t>(point)]; };
    const auto for_each_neighbour = [&](const auto& visit) {
      for_each_link(system_, [&](std::span<const Index> points, int) {
        for (const Index a : points) {
          for (const Index b : points)
            if (is_here(a) && is_here(b) && vertex_of(a) != vertex_of(b)) visit(vertex_of(a), vertex_of(b));
        }
      });
    };
    std::size_t count = 0;
    for_each_neighbour([&](idx_t, idx_t) { ++count; });
    require_metis_counts(count);
    const Groups<idx_t> neighbours(weights.size(), for_each_neighbour);
    auto num_vertices = static_cast<idx_t>(weights.size()), num_weights = idx_t{1}, wanted = idx_t{pieces};
    std::vector<idx_t> start(neighbours.start.begin(), neighbours.start.end()), ends = neighbours.entries,
                                                                                part(weights.size());
    idx_t options[METIS_NOPTIONS], num_cut = 0;
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    constexpr int few = 8;
    const auto partition = pieces <= few ? METIS_PartGraphRecursive : METIS_PartGraphKway;
    if (partition(&num_vertices, &num_weights, start.data(), ends.data(), weights.data(), nullptr, nullptr, &wanted,
                  nullptr, nullptr, options, &num_cut, part.data()) != METIS_OK)
      throw std::runtime_error("METIS could not cut " + std::to_string(num_vertices) + " points");
    std::vector<int> result;
    for (const Index point : cluster.points) result.push_back(part[static_cast<std::size_t>(vertex_of(point))]);
    return result;
  }

 private:
  /// Numbers the vertices of a cluster's graph, each of one point or of several that stay together. Returns how many
  /// points each vertex has.
  std::vector<idx_t> number_vertices(const Cluster& cluster) {
    std::vector<Index> together(root_.size());
    std::iota(together.begin(), together.end(), 0);
    for_each_tuple(system_, [&](std::span<const Index> points) {
      if (std::ranges::any_of(points, [&](Index point) { return is_support(point); })) join_all(points, &together);
    });
    vertex_.assign(root_.size(), -1);
    std::vector<idx_t> weights;
    for (const Index point : cluster.points) {
      idx_t& vertex = vertex_[static_cast<std::size_t>(find_root(together.data(), point))];
      if (vertex < 0) {
        vertex = static_cast<idx_t>(weights.size());
        weights.push_back(0);
      }
      ++weights[static_cast<std::size_t>(vertex)];
      vertex_[static_cast<std::size_t>(point)] = vertex;
    }
    return weights;
  }
  bool is_support(Index point) const { return root_[static_cast<std::size_t>(point)] == nobody; }
  /// Joins those of the points that are no supports. Returns the first of them, or nobody.
  Index join_all(std::span<const Index> points, std::vector<Index>* roots) const {
    Index first = nobody;
    for (const Index point : points) {
      if (is_support(point)) continue;
      if (first == nobody) first = point;
      join_sets(roots->data(), first, point);
    }
    return first;
  }
  /// Joins points that one rank must have: those that coordinates tie to one another, and those of pair forces which
  /// ranks may not share. What a support carries is counted by one rank, which has all of the group.
  void join_bundles(Islands islands) {
    const auto bundle = [&](std::span<const Index> points) {
      const Index first = join_all(points, &root_);
      if (first != nobody && points.size() > 1) bundled_.push_back(first);
    };
    for (const Force& force : system_.forces) {
      const auto* const pairs = std::get_if<PairForces>(&force);
      if (pairs == nullptr) continue;
      const std::vector<Index> points = points_of(system_, *pairs);
      const bool holds = std::ranges::any_of(points, [&](Index point) { return is_support(point); });
      if (islands == Islands::AreWhole || holds)
        bundle(points);
      else
        has_shared_pairs_ = true;
    }
    const auto bundle_group = [&]<class Group>(const Group& group) {
      if constexpr (requires { KindOf<Group>::tied_points(group); }) {
        bundle(KindOf<Group>::tied_points(group));
      } else if constexpr (!has_single_points<Group>) {
        for (const auto& points : list_of(group)) bundle(points);
      }
    };
    for (const Coordinates& coordinates : system_.coordinates) std::visit(bundle_group, coordinates);
  }
  void number() {
    cluster_of_.assign(root_.size(), nobody);
    for (std::size_t i = 0; i < root_.size(); ++i) {
      if (is_support(static_cast<Index>(i))) continue;
      int& of_root = cluster_of_[static_cast<std::size_t>(find_root(root_.data(), static_cast<Index>(i)))];
      if (of_root == nobody) {
        of_root = static_cast<int>(clusters_.size());
        clusters_.emplace_back();
      }
      cluster_of_[i] = of_root;
      clusters_[static_cast<std::size_t>(of_root)].points.push_back(static_cast<Index>(i));
    }
  }
  int of_point(Index point) const { return cluster_of_[static_cast<std::size_t>(point)]; }
  const System& system_;
  std::vector<Index> root_;  // -1 for a support
  std::vector<int> cluster_of_;
  std::vector<Cluster> clusters_;
  std::vector<Index> bundled_;  // a point of each bundle
  bool has_shared_pairs_ = false;
  std::vector<idx_t> vertex_;  // [point] vertex in the cluster that is cut
};

/// Points that go to one rank.
struct Piece {
  std::vector<Index> points;
  double cost = 0.0;
  std::array<double, 3> centre{};
  int rank = 0;
};

Piece make_piece(const System& system, std::vector<Index> points, double cost) {
  Piece piece{std::move(points), cost};
  for (const Index point : piece.points)
    for (std::size_t c = 0; c < 3; ++c)
      piece.centre[c] +=
          system.positions[3 * static_cast<std::size_t>(point) + c] / static_cast<double>(piece.points.size());
  return piece;
}

/// Returns each cluster whole, or in pieces if it costs much more than a rank's share. The most expensive ones come
/// first.
std::vector<Piece> make_pieces(const System& system, Clusters* clusters, int num_ranks) {
  double total = 0.0;
  std::vector<const Cluster*> order;
  for (const Cluster& cluster : clusters->all()) {
    total += cluster.cost();
    order.push_back(&cluster);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const Cluster* a, const Cluster* b) { return a->cost() > b->cost(); });
  // A cluster that costs a little more than a share stays whole: its cut would cost more than it gains.
  constexpr double much = 1.25;
  const double share = total / num_ranks;
  std::vector<Piece> pieces;
  for (const Cluster* const cluster : order) {
    const int wanted = static_cast<int>(std::ceil(cluster->cost() / (much * share)));
    const int count = std::min({wanted, num_ranks, static_cast<int>(cluster->points.size())});
    std::vector<int> part(cluster->points.size(), 0);
    if (cluster->may_be_cut && count > 1) part = clusters->cut(*cluster, count);
    std::vector<std::vector<Index>> points(static_cast<std::size_t>(1 + *std::ranges::max_element(part)));
    for (std::size_t k = 0; k < part.size(); ++k)
      points[static_cast<std::size_t>(part[k])].push_back(cluster->points[k]);
    const double cost = cluster->cost() / static_cast<double>(points.size());
    for (std::vector<Index>& each : points) pieces.push_back(make_piece(system, std::move(each), cost));
  }
  return pieces;
}

/// Gives each piece to the rank with the least load so far.
void balance(std::span<Piece> pieces, int num_ranks) {
  std::vector<double> loads(static_cast<std::size_t>(num_ranks), 0.0);
  for (Piece& piece : pieces) {
    const auto least = std::ranges::min_element(loads);
    *least += piece.cost;
    piece.rank = static_cast<int>(least - loads.begin());
  }
}

/// Gives neighbouring pieces to one rank, so that few points are near to others', by recursive bisection across the
/// longest side.
void bisect(std::span<Piece> pieces, int first_rank, int num_ranks) {
  for (Piece& piece : pieces) piece.rank = first_rank;
  const auto count = static_cast<std::ptrdiff_t>(pieces.size());
  if (num_ranks == 1 || count < 2) return;
  std::size_t axis = 0;
  double longest = -1.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto [low, high] =
        std::ranges::minmax_element(pieces, {}, [&](const Piece& piece) { return piece.centre[c]; });
    if (const double side = high->centre[c] - low->centre[c]; side > longest) {
      longest = side;
      axis = c;
    }
  }
  std::ranges::stable_sort(pieces, {}, [&](const Piece& piece) { return piece.centre[axis]; });
  const int on_the_left = num_ranks / 2;
  double total = 0.0, left = 0.0;
  for (const Piece& piece : pieces) total += piece.cost;
  std::ptrdiff_t split = 0;
  while (split < count && left + 0.5 * pieces[static_cast<std::size_t>(split)].cost < total * on_the_left / num_ranks)
    left += pieces[static_cast<std::size_t>(split++)].cost;
  // No rank is left without a piece if there are enough of them.
  const std::ptrdiff_t least = std::min<std::ptrdiff_t>(on_the_left, count - 1);
  split = std::clamp(split, least, std::max(least, count - (num_ranks - on_the_left)));
  bisect(pieces.first(static_cast<std::size_t>(split)), first_rank, on_the_left);
  bisect(pieces.subspan(static_cast<std::size_t>(split)), first_rank + on_the_left, num_ranks - on_the_left);
}

void require_all(std::span<const int> owner, int num_ranks) {
  std::vector<char> has_some(static_cast<std::size_t>(num_ranks), 0);
  for (const int rank : owner)
    if (rank >= 0) has_some[static_cast<std::size_t>(rank)] = 1;
  const auto idle = std::ranges::find(has_some, 0);
  if (idle == has_some.end()) return;
  throw InputError("", "rank " + std::to_string(idle - has_some.begin()) + " of " + std::to_string(num_ranks) +
                           " would own no point; take fewer ranks");
}

}  // namespace

std::vector<int> assign_owners(const System& system, int num_ranks, Islands islands) {
  std::vector<int> owner(system.num_points(), 0);
  if (num_ranks == 1) return owner;
  if (has_contacts(system) || !system.coordinates.empty()) islands = Islands::AreWhole;
  Clusters clusters(system, islands);
  std::vector<Piece> pieces = make_pieces(system, &clusters, num_ranks);
  clusters.has_shared_pairs() ? bisect(pieces, 0, num_ranks) : balance(pieces, num_ranks);
  for (const Piece& piece : pieces)
    for (const Index point : piece.points) owner[static_cast<std::size_t>(point)] = piece.rank;
  for (const Support& support : system.supports)
    for (const Index point : support.points) owner[static_cast<std::size_t>(point)] = nobody;
  require_all(owner, num_ranks);
  for (int& rank : owner) rank = std::max(rank, 0);
  return owner;
}

}  // namespace tanor
