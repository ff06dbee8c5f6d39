#include "bench_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <variant>

#include <Eigen/Geometry>

#include "beside.hpp"
#include "scene/scene.hpp"

namespace {

using namespace tanor;

System melt(int chains, int count) {
  return make_generated(fmt::format(R"({{"kind": "melt", "chains": {}, "count": {}}})", chains, count));
}

/// Returns the same system with points and rods in random order.
System shuffled(System given) {
  std::mt19937 generator(2);
  std::vector<Index> place(given.masses.size());
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), generator);
  System system = given;
  const auto move = [](const std::vector<double>& from, std::size_t i, Index to, std::vector<double>* all) {
    if (!from.empty()) std::copy_n(from.begin() + 3 * static_cast<std::ptrdiff_t>(i), 3, all->begin() + 3 * to);
  };
  for (std::size_t i = 0; i < place.size(); ++i) {
    system.masses[static_cast<std::size_t>(place[i])] = given.masses[i];
    move(given.positions, i, place[i], &system.positions);
    move(given.velocities, i, place[i], &system.velocities);
  }
  auto& pairs = std::get<Rods>(system.constraints.front()).pairs;
  for (auto& [i, j] : pairs) {
    i = place[static_cast<std::size_t>(i)];
    j = place[static_cast<std::size_t>(j)];
  }
  for (Support& support : system.supports) {
    for (Index& point : support.points) point = place[static_cast<std::size_t>(point)];
  }
  std::shuffle(pairs.begin(), pairs.end(), generator);
  return system;
}

System net(int size) {
  return make_generated(fmt::format(R"({{"kind": "net", "columns": {0}, "rows": {0}}})", size));
}

/// Returns the points and rods of both systems, with nothing to join them. All rods are in one group, which the
/// baselines read.
System put_together(System first, const System& second) {
  put_beside(second, &first);
  const Rods added = std::get<Rods>(first.constraints.back());
  first.constraints.pop_back();
  auto& pairs = std::get<Rods>(first.constraints.front()).pairs;
  pairs.insert(pairs.end(), added.pairs.begin(), added.pairs.end());
  return first;
}

System many(int count, const System& one) {
  System result = one;
  for (int k = 1; k < count; ++k) result = put_together(std::move(result), one);
  return result;
}

System lattice(int size) {
  return make_generated(fmt::format(R"({{"kind": "lattice", "size": [{0}, {0}, {0}]}})", size));
}

/// Makes copies of a rigid or jointed body, each turned and thrown at random with a fixed seed.
System copies(int count, const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 2>>& rods) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const auto random_vector = [&] { return Eigen::Vector3d(normal(generator), normal(generator), normal(generator)); };
  const auto append = [](const Eigen::Vector3d& x, std::vector<double>* to) {
    to->insert(to->end(), x.data(), x.data() + 3);
  };
  System system;
  Rods group;
  for (int copy = 0; copy < count; ++copy) {
    const auto first = static_cast<Index>(system.masses.size());
    const Eigen::Quaterniond turn = Eigen::Quaterniond::UnitRandom();
    const Eigen::Vector3d place = 10.0 * random_vector(), v = random_vector(), omega = random_vector();
    for (const Eigen::Vector3d& point : points) {
      const Eigen::Vector3d arm = turn * point;
      append(place + arm, &system.positions);
      append(v + omega.cross(arm), &system.velocities);
      system.masses.push_back(std::exp(0.3 * normal(generator)));
    }
    for (const auto& [i, j] : rods) group.pairs.push_back({first + i, first + j});
  }
  system.constraints = {group};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

struct Frame {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 2>> rods;
};

Frame make_ring_of_six() {
  Frame ring;
  for (int k = 0; k < 6; ++k) {
    ring.points.emplace_back(std::cos(k * std::numbers::pi / 3.0), std::sin(k * std::numbers::pi / 3.0), 0.3 * (k % 2));
    ring.rods.push_back({k, (k + 1) % 6});
  }
  return ring;
}

System rings(int count) {
  const auto [points, rods] = make_ring_of_six();
  return copies(count, points, rods);
}

/// Makes one ring, or a chain in which every fourth point is a branch of one rod.
System branched(int count, bool is_ring) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> any(-0.3, 0.3);
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 2>> rods;
  const double radius = count / (2.0 * std::numbers::pi);
  int before = -1;
  for (int k = 0; k < count; ++k) {
    const bool hangs = !is_ring && k % 4 == 3;
    const double angle = 2.0 * std::numbers::pi * k / count, height = any(generator) - (hangs ? 1.0 : 0.0);
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    if (before >= 0) rods.push_back({before, k});
    if (!hangs) before = k;
  }
  if (is_ring) rods.push_back({count - 1, 0});
  return copies(1, points, rods);
}

/// Makes arms from one point, each rod of which ends where two others begin, `depth` rods long.
System dendrimer(int arms, int depth) {
  std::mt19937 generator(6);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};
  std::vector<std::array<int, 2>> rods;
  std::size_t first = 0;
  for (int level = 0; level < depth; ++level) {
    const std::size_t end = points.size();
    for (std::size_t from = first; from < end; ++from) {
      for (int branch = 0; branch < (level == 0 ? arms : 2); ++branch) {
        rods.push_back({static_cast<int>(from), static_cast<int>(points.size())});
        const Eigen::Vector3d along(normal(generator), normal(generator), normal(generator));
        points.push_back(points[from] + along.normalized());
      }
    }
    first = end;
  }
  return copies(1, points, rods);
}

/// Makes a tree whose points each hang on one of the `window` points before it, drawn at random.
System random_tree(int count, int window) {
  std::mt19937 generator(11);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points{Eigen::Vector3d::Zero()};
  std::vector<std::array<int, 2>> rods;
  for (int k = 1; k <= count; ++k) {
    const auto from =
        static_cast<std::size_t>(std::uniform_int_distribution<int>(std::max(0, k - window), k - 1)(generator));
    const Eigen::Vector3d along(normal(generator), normal(generator), normal(generator));
    rods.push_back({static_cast<int>(from), k});
    points.emplace_back(points[from] + along.normalized());
  }
  return copies(1, points, rods);
}

/// Gives the points masses between 0.5 and 2 kg.
System with_unequal_masses(System system) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (double& mass : system.masses) mass = std::exp2(any(generator));
  return system;
}

/// Returns chains of 1 to 200 rods, so that few of them are equal.
System unequal_polymers(int count) {
  std::mt19937 generator(3);
  System system = melt(1, 1);
  for (int k = 1; k < count; ++k)
    system = put_together(std::move(system), melt(1, std::uniform_int_distribution<int>(1, 200)(generator)));
  return with_unequal_masses(std::move(system));
}

/// Makes points in a grid on a surface, and rods between the neighbours that `joins(column, row, to_next_row,
/// columns_on)`
/// selects.
template <class Place, class Joins>
System grid(int columns, int rows, bool closes, const Place& place, const Joins& joins) {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 2>> rods;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      points.push_back(place(column, row));
      for (const auto [to_row, to_column] : {std::array{0, 1}, std::array{1, 0}, std::array{1, 1}}) {
        if (row + to_row == rows || (!closes && column + to_column == columns)) continue;
        if (joins(column, row, to_row, to_column))
          rods.push_back({row * columns + column, (row + to_row) * columns + (column + to_column) % columns});
      }
    }
  }
  return with_unequal_masses(copies(1, points, rods));
}

/// Makes a crumpled wall whose rods are the joints between bricks; the points of the first row are supports.
System brick_sheet(int size) {
  std::mt19937 generator(8);
  std::uniform_real_distribution<double> any(-0.2, 0.2);
  System sheet = grid(
      size, size, false,
      [&](int column, int row) {
        return Eigen::Vector3d(column + any(generator), row + any(generator), any(generator));
      },
      [](int column, int row, int to_row, int to_column) {
        return to_row + to_column == 1 && (to_row == 0 ? row > 0 : (column + row) % 2 == 0);
      });
  Support edge;
  for (Index k = 0; k < size; ++k) edge.points.push_back(k);
  sheet.supports = {edge};
  std::fill_n(sheet.velocities.begin(), 3 * size, 0.0);
  return sheet;
}

/// Makes rings of points, each joined to the next ring by an oblique rod.
System tube(int around, int along) {
  std::mt19937 generator(9);
  std::uniform_real_distribution<double> any(-0.1, 0.1);
  const double radius = around / (2.0 * std::numbers::pi);
  return grid(
      around, along, true,
      [&](int column, int row) {
        const double angle = 2.0 * std::numbers::pi * column / around, from_axis = radius + any(generator);
        return Eigen::Vector3d(from_axis * std::cos(angle), from_axis * std::sin(angle), row + any(generator));
      },
      [](int, int, int to_row, int to_column) { return to_column == 1 && to_row <= 1; });
}

/// Makes a cubic lattice of which one rod in five is missing.
System lattice_with_holes(int size) {
  System system = with_unequal_masses(lattice(size));
  std::mt19937 generator(10);
  std::erase_if(std::get<Rods>(system.constraints.front()).pairs, [&](const auto&) { return generator() % 5 == 0; });
  return system;
}

/// Makes rings of six, from every second point of which a tail of two rods hangs.
System rings_with_tails(int count) {
  auto [points, rods] = make_ring_of_six();
  for (int k = 0; k < 6; k += 2) {
    const auto first = static_cast<int>(points.size());
    points.push_back(2.0 * points[static_cast<std::size_t>(k)]);
    points.emplace_back(points.back() + Eigen::Vector3d(0.3, 0.1 * k, 0.8));
    rods.insert(rods.end(), {{k, first}, {first, first + 1}});
  }
  return with_unequal_masses(copies(count, points, rods));
}

System triangles(int count) {
  return copies(count, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1}, {0, 2}, {1, 2}});
}

System tetrahedra(int count) {
  return copies(count, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}});
}

std::vector<Index> all_points(const System& system) {
  std::vector<Index> result(system.masses.size());
  std::iota(result.begin(), result.end(), 0);
  return result;
}

/// Makes points, each on a sphere of its own radius around the origin.
System on_spheres(int count) {
  System system = copies(count, {{0, 0, 0}}, {});
  system.constraints = {Spheres{"", all_points(system), VectorFunction(0.0, 0.0, 0.0), {}}};
  return system;
}

/// Makes points, each on a circle of its own radius around the z axis.
System on_circles(int count) {
  System system = copies(count, {{0, 0, 0}}, {});
  for (std::size_t i = 2; i < system.positions.size(); i += 3) system.positions[i] = 0.0;
  const VectorFunction center(0.0, 0.0, 0.0), normal(0.0, 0.0, 1.0);
  system.constraints = {Circles{"", all_points(system), center, normal, {}}};
  return system;
}

}  // namespace

tanor::System make_generated(const std::string& generate) {
  System system = scene::parse_scene(R"({"tanor_scene": 1, "generate": )" + generate + "}", "bench.json").system;
  if (!system.velocities.empty()) return system;
  system.velocities.resize(system.positions.size());
  for (std::size_t i = 0; i < system.positions.size(); i += 3)
    system.velocities[i + 2] = 0.1 * std::sin(7.0 * system.positions[i] + 3.0 * system.positions[i + 1]);
  return system;
}

tanor::System make_random_walk(int count) {
  return melt(1, count);
}

const std::vector<BenchScene>& bench_scenes() {
  static const std::vector<BenchScene> scenes = {
      {"chain 1e3", [] { return melt(1, 1000); }, 8.0, 440.0},
      {"chain 1e4", [] { return melt(1, 10000); }, 8.0, 440.0},
      {"chain 1e5", [] { return melt(1, 100000); }, 8.0, 440.0},
      {"chain 1e6", [] { return melt(1, 1000000); }, 12.0, 440.0},
      {"shuffled chain 1e6", [] { return shuffled(melt(1, 1000000)); }, 12.0, 0.0},
      {"clusters 1e2 x 10", [] { return melt(100, 10); }, 8.0, 300.0},
      {"clusters 1e3 x 10", [] { return melt(1000, 10); }, 8.0, 300.0},
      {"clusters 1e4 x 10", [] { return melt(10000, 10); }, 8.0, 300.0},
      {"clusters 1e5 x 10", [] { return melt(100000, 10); }, 8.0, 300.0},
      {"rings 1e4 x 6", [] { return rings(10000); }, 8.0, 0.0},
      {"triangles 1e4", [] { return triangles(10000); }, 8.0, 0.0},
      {"tetrahedra 1e4", [] { return tetrahedra(10000); }, 8.0, 0.0},
      {"tree 1e3", [] { return branched(1000, false); }, 0.0, 0.0},
      {"tree 1e5", [] { return branched(100000, false); }, 0.0, 0.0},
      {"dendrimer 9", [] { return dendrimer(3, 9); }, 10.0, 0.0},
      {"dendrimer 14", [] { return dendrimer(3, 14); }, 10.0, 0.0},
      {"dendrimer 16", [] { return dendrimer(3, 16); }, 10.0, 0.0},
      {"shuffled dendrimer 14", [] { return shuffled(dendrimer(3, 14)); }, 10.0, 0.0},
      {"binary tree 14", [] { return dendrimer(2, 14); }, 10.0, 0.0},
      {"random tree 1e3", [] { return random_tree(1000, 100); }, 0.0, 0.0},
      {"random tree 1e5", [] { return random_tree(100000, 100); }, 0.0, 0.0},
      {"shuffled random tree 1e5", [] { return shuffled(random_tree(100000, 100)); }, 0.0, 0.0},
      {"recursive tree 1e5", [] { return shuffled(random_tree(100000, 100000)); }, 0.0, 0.0},
      {"ring 1e3", [] { return branched(1000, true); }, 0.0, 0.0},
      {"ring 1e5", [] { return branched(100000, true); }, 0.0, 0.0},
      {"spheres 1e3", [] { return on_spheres(1000); }, 13.0, 260.0},
      {"spheres 1e4", [] { return on_spheres(10000); }, 13.0, 260.0},
      {"spheres 1e5", [] { return on_spheres(100000); }, 13.0, 260.0},
      {"spheres 1e6", [] { return on_spheres(1000000); }, 13.0, 260.0},
      {"circles 1e5", [] { return on_circles(100000); }, 0.0, 0.0},
      {"melt 320 x 99", [] { return melt(320, 99); }, 8.0, 0.0},
      {"net 30", [] { return net(30); }, 1.2, 1250.0},
      {"net 100", [] { return net(100); }, 1.2, 2400.0},
      {"net 300", [] { return net(300); }, 2.0, 6700.0},
      {"lattice 10", [] { return lattice(10); }, 1.6, 8200.0},
      {"lattice 20", [] { return lattice(20); }, 22.0, 230000.0},
      {"polymers 320 x 99", [] { return with_unequal_masses(melt(320, 99)); }, 10.0, 0.0},
      {"shuffled polymers 320 x 99", [] { return shuffled(with_unequal_masses(melt(320, 99))); }, 10.0, 0.0},
      {"unequal polymers 320", [] { return unequal_polymers(320); }, 0.0, 0.0},
      {"shuffled unequal polymers 320", [] { return shuffled(unequal_polymers(320)); }, 0.0, 0.0},
      {"shuffled polymers 20 x 4999", [] { return shuffled(with_unequal_masses(melt(20, 4999))); }, 10.0, 0.0},
      {"rings with tails 3000", [] { return shuffled(rings_with_tails(3000)); }, 10.0, 0.0},
      {"sheet 60", [] { return shuffled(brick_sheet(60)); }, 5.0, 0.0},
      {"sheet 200", [] { return shuffled(brick_sheet(200)); }, 6.0, 0.0},
      {"sheet 500", [] { return shuffled(brick_sheet(500)); }, 10.0, 0.0},
      {"tube 12 x 400", [] { return shuffled(tube(12, 400)); }, 6.0, 0.0},
      {"tube 60 x 60", [] { return shuffled(tube(60, 60)); }, 8.0, 0.0},
      {"lattice with holes 12", [] { return shuffled(lattice_with_holes(12)); }, 15.0, 0.0},
      {"lattice with holes 18", [] { return shuffled(lattice_with_holes(18)); }, 40.0, 0.0},
      {"nets 100 x 22", [] { return many(100, net(22)); }, 0.0, 0.0},
      {"mixed clusters 1e4 + net 30", [] { return put_together(melt(10000, 10), net(30)); }, 0.0, 0.0},
  };
  return scenes;
}
