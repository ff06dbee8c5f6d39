#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "scene/kind.hpp"
#include "scene/memory.hpp"
#include "scene/points.hpp"
#include "scene/random.hpp"

namespace tanor::scene {
namespace {

constexpr std::int64_t most_points = std::numeric_limits<Index>::max();

Vector3 add_scaled(const Vector3& r, double factor, const Vector3& d) {
  return {r[0] + factor * d[0], r[1] + factor * d[1], r[2] + factor * d[2]};
}

double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The keys that all kinds share, and the points and rods made so far.
class Sketch {
 public:
  explicit Sketch(const Cursor& entry)
      : spacing(entry["spacing"].positive(0.1)),
        mass(entry["mass"].positive(0.1)),
        random(static_cast<std::uint64_t>(entry["seed"].integer(0, std::int64_t{1} << 53, 1))) {
    points.source = "generate: " + entry["kind"].string();
  }

  void add_rod(Index i, Index j) { rods.pairs.push_back({i, j}); }

  /// Adds a new point at the end of a new rod.
  Index add_rod_from(Index i, const Vector3& direction) {
    const Index j = points.add_point(add_scaled(position(i), spacing, direction));
    add_rod(i, j);
    return j;
  }

  Vector3 position(Index i) const {
    const double* r = &points.positions[3 * static_cast<std::size_t>(i)];
    return {r[0], r[1], r[2]};
  }

  PointSet finish() && {
    points.masses.assign(points.positions.size() / 3, mass);
    points.constraints.emplace_back(std::move(rods));
    return std::move(points);
  }

  const double spacing;  // m
  const double mass;     // kg
  Random random;
  PointSet points;
  Rods rods{.name = "rods", .pairs = {}, .length = {}, .offsets = {}};
};

/// Refuses more points than this machine has memory for, before any is made.
void check_room(std::int64_t num_points) {
  constexpr double bytes_a_point = 660.0;  // measured for a chain whose dynamics were planned and no more
  const double needed = bytes_a_point * static_cast<double>(num_points), there = measure_memory();
  if (needed <= there) return;
  throw std::length_error(
      fmt::format("/generate: {} points need {:.3g} GB of memory at least; there are {:.3g} GB for this program",
                  num_points, 1e-9 * needed, 1e-9 * there));
}

/// Reads a number of things, each of which makes some points.
std::int64_t read_count(const Cursor& count, std::int64_t points_each = 1, std::int64_t least = 1) {
  return count.integer(least, std::max(least, most_points / points_each - 1), 10);
}

PointSet generate_chain(const Cursor& entry, const Context&) {
  Sketch sketch(entry);
  const std::int64_t count = read_count(entry["count"]);
  check_room(count + 1);
  const Vector3 given = entry["direction"].vector3(Vector3{1.0, 0.0, 0.0});
  const double length = std::hypot(given[0], given[1], given[2]);
  if (!(length > 0.0)) entry["direction"].complain("found the zero vector, wanted a direction");

  // Use r_k = k spacing direction instead of a sum of rounded steps.
  for (Index k = 0; k <= count; ++k) sketch.points.add_point(add_scaled({}, k * sketch.spacing / length, given));
  for (Index k = 0; k < count; ++k) sketch.add_rod(k, k + 1);
  if (entry["anchored"].boolean(false))
    sketch.points.supports.push_back({.name = "anchor", .points = {0}, .displacement = {}});
  return std::move(sketch).finish();
}

PointSet generate_ring(const Cursor& entry, const Context&) {
  Sketch sketch(entry);
  const auto count = static_cast<Index>(read_count(entry["count"], 1, 3));
  check_room(count);
  // The edge is 2 R sin(pi/count).
  const double radius = 0.5 * sketch.spacing / std::sin(std::numbers::pi / count);
  for (Index k = 0; k < count; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / count;
    sketch.points.add_point({radius * std::cos(angle), radius * std::sin(angle), 0.0});
  }
  for (Index k = 0; k < count; ++k) sketch.add_rod(k, (k + 1) % count);
  return std::move(sketch).finish();
}

PointSet make_lattice(Sketch sketch, std::int64_t a, std::int64_t b, std::int64_t c) {
  check_room(a * b * c);
  const auto number = [=](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<Index>((z * b + y) * a + x);
  };
  const auto place = [&](std::int64_t k) { return static_cast<double>(k) * sketch.spacing; };
  for (std::int64_t z = 0; z < c; ++z)
    for (std::int64_t y = 0; y < b; ++y)
      for (std::int64_t x = 0; x < a; ++x) {
        const Index point = sketch.points.add_point({place(x), place(y), place(z)});
        if (x > 0) sketch.add_rod(number(x - 1, y, z), point);
        if (y > 0) sketch.add_rod(number(x, y - 1, z), point);
        if (z > 0) sketch.add_rod(number(x, y, z - 1), point);
      }
  return std::move(sketch).finish();
}

PointSet generate_net(const Cursor& entry, const Context&) {
  const std::int64_t columns = read_count(entry["columns"]);
  const std::int64_t rows = read_count(entry["rows"], columns);
  return make_lattice(Sketch(entry), columns, rows, 1);
}

PointSet generate_lattice(const Cursor& entry, const Context&) {
  std::vector<std::int64_t> size;
  std::int64_t num_points = 1;
  if (const Cursor given = entry["size"]) {
    for (const Cursor edge : given.list("3 whole numbers [a, b, c]")) {
      size.push_back(edge.integer(1, most_points / num_points));
      num_points *= size.back();
    }
    if (size.size() != 3) given.fail("3 whole numbers [a, b, c]");
  } else {
    size = {4, 4, 4};
  }
  return make_lattice(Sketch(entry), size[0], size[1], size[2]);
}

PointSet generate_tree(const Cursor& entry, const Context&) {
  Sketch sketch(entry);
  const std::int64_t count = read_count(entry["count"]);
  check_room(count + 1);
  sketch.points.add_point({});
  for (std::int64_t k = 1; k <= count; ++k) {
    const auto parent = static_cast<Index>(sketch.random.below(k));
    sketch.add_rod_from(parent, sketch.random.direction());
  }
  return std::move(sketch).finish();
}

PointSet generate_clusters(const Cursor& entry, const Context&) {
  Sketch sketch(entry);
  const std::int64_t count = read_count(entry["count"]);
  const std::int64_t clusters = read_count(entry["clusters"], count + 1);
  check_room(clusters * (count + 1));
  const auto edge = static_cast<std::int64_t>(std::ceil(std::cbrt(static_cast<double>(clusters))));
  const double pitch = static_cast<double>(count + 1) * sketch.spacing;
  const auto place = [&](std::int64_t k) { return static_cast<double>(k) * pitch; };
  for (std::int64_t c = 0; c < clusters; ++c) {
    Index end = sketch.points.add_point({place(c % edge), place(c / edge % edge), place(c / (edge * edge))});
    for (std::int64_t k = 0; k < count; ++k) end = sketch.add_rod_from(end, sketch.random.direction());
  }
  return std::move(sketch).finish();
}

/// Removes the part of the velocities that would change the lengths of a chain's rods: v <- v - K (K'K)^-1 K'v (equal
/// masses cancel). K'K is tridiagonal, with 2 on the diagonal and -e_k.e_(k+1) beside it, where e_k is the direction of
/// rod k.
void project_chain_velocities(const std::vector<Vector3>& directions, std::vector<Vector3>* velocities) {
  const std::size_t num_rods = directions.size();
  std::vector<double> ratio(num_rods), mu(num_rods);
  for (std::size_t k = 0; k < num_rods; ++k) {
    // Perform one row of Gaussian elimination: pivot mu_k + beside mu_(k+1) = e_k.(v_(k+1) - v_k).
    const double before = k > 0 ? -dot(directions[k - 1], directions[k]) : 0.0;
    const double pivot = 2.0 - (k > 0 ? before * ratio[k - 1] : 0.0);
    const double rate = dot(directions[k], add_scaled((*velocities)[k + 1], -1.0, (*velocities)[k]));
    ratio[k] = k + 1 < num_rods ? -dot(directions[k], directions[k + 1]) / pivot : 0.0;
    mu[k] = (rate - (k > 0 ? before * mu[k - 1] : 0.0)) / pivot;
  }
  for (std::size_t k = num_rods; k-- > 0;) {
    if (k + 1 < num_rods) mu[k] -= ratio[k] * mu[k + 1];
    (*velocities)[k] = add_scaled((*velocities)[k], mu[k], directions[k]);
    (*velocities)[k + 1] = add_scaled((*velocities)[k + 1], -mu[k], directions[k]);
  }
}

constexpr double melt_density = 0.85;  // points per spacing^3, as in bead-spring melts

struct Melt {
  std::int64_t count, chains;  ///< bonds of a chain, and number of chains
  double speed;                ///< square root of k T/m
};

/// Returns site k of a path from neighbour to neighbour through a cube with `edge` sites along each edge.
std::array<std::int64_t, 3> snake(std::int64_t k, std::int64_t edge) {
  const std::int64_t row = k / edge, layer = row / edge;
  const std::int64_t x = k % edge, y = row % edge;
  return {row % 2 == 0 ? x : edge - 1 - x, layer % 2 == 0 ? y : edge - 1 - y, layer};
}

/// Generates the bead-spring model of Kremer & Grest (1990), which starts as a crystal: chains follow each other on a
/// simple cubic lattice, on which no beads overlap. It has FENE bonds with 30 epsilon/spacing^2 and 1.5 spacing,
/// bendings k (1 + cos theta), and repulsion (wca) in a periodic box.
PointSet generate_beads(Sketch sketch, const Melt& melt, double epsilon, double bending) {
  const double pitch = sketch.spacing / std::cbrt(melt_density);
  const std::int64_t beads = melt.count + 1, num_points = melt.chains * beads;
  const auto edge = std::max<std::int64_t>(std::llround(std::cbrt(static_cast<double>(num_points))), 1);
  const std::int64_t layers = (num_points + edge * edge - 1) / (edge * edge);
  PointSet& points = sketch.points;
  for (std::int64_t k = 0; k < num_points; ++k) {
    Vector3 place;
    std::ranges::transform(snake(k, edge), place.begin(),
                           [&](std::int64_t x) { return static_cast<double>(x) * pitch; });
    points.add_point(place);
    for (int axis = 0; axis < 3; ++axis) points.velocities.push_back(melt.speed * sketch.random.normal());
  }
  Bonds bonds{.name = "bonds",
              .law = BondLaw::Fene,
              .stiffness = 30.0 * epsilon / (sketch.spacing * sketch.spacing),
              .limit = 1.5 * sketch.spacing};
  Bendings bendings{.name = "bendings", .law = BendingLaw::Cosine, .stiffness = bending};
  for (std::int64_t k = 0; k < num_points; ++k) {
    const auto bead = static_cast<Index>(k);
    if (k % beads >= 1) bonds.pairs.push_back({bead - 1, bead});
    if (k % beads >= 2) bendings.triples.push_back({bead - 2, bead - 1, bead});
  }
  const double side = static_cast<double>(edge) * pitch;
  points.forces = {std::move(bonds), PairForces{.name = "beads",
                                                .law = PairLaw::Wca,
                                                .epsilon = epsilon,
                                                .sigma = sketch.spacing,
                                                .box = {side, side, static_cast<double>(layers) * pitch}}};
  if (bending > 0.0 && !bendings.triples.empty()) points.forces.emplace_back(std::move(bendings));
  points.masses.assign(points.positions.size() / 3, sketch.mass);
  return std::move(points);
}

PointSet generate_melt(const Cursor& entry, const Context&) {
  Sketch sketch(entry);
  const std::int64_t count = read_count(entry["count"]);
  const std::int64_t chains = read_count(entry["chains"], count + 1);
  check_room(chains * (count + 1));
  const double speed = std::sqrt(entry["temperature"].non_negative(1.0) / sketch.mass);
  if (entry["bonds"].choice<bool>({{"rods", false}, {"energies", true}}, false)) {
    const double epsilon = entry["epsilon"].positive(1.0), bending = entry["bending"].non_negative(1.5);
    return generate_beads(std::move(sketch), {count, chains, speed}, epsilon, bending);
  }
  for (const char* key : {"epsilon", "bending"})
    if (const Cursor given = entry[key]) given.complain(R"(it is read where "bonds" is "energies" alone)");
  const double num_points = static_cast<double>(chains) * static_cast<double>(count + 1);
  const double edge = sketch.spacing * std::max(2.0, std::cbrt(num_points / melt_density));
  const auto is_inside = [edge](const Vector3& r) {
    return std::all_of(r.begin(), r.end(), [edge](double x) { return x >= 0.0 && x <= edge; });
  };

  Random& random = sketch.random;
  std::vector<Vector3> directions(static_cast<std::size_t>(count)), velocities(directions.size() + 1);
  for (std::int64_t c = 0; c < chains; ++c) {
    Index end = sketch.points.add_point({edge * random.uniform(), edge * random.uniform(), edge * random.uniform()});
    for (Vector3& direction : directions) {
      do direction = random.direction();
      while (!is_inside(add_scaled(sketch.position(end), sketch.spacing, direction)));
      end = sketch.add_rod_from(end, direction);
    }
    for (Vector3& velocity : velocities)
      for (double& component : velocity) component = speed * random.normal();
    project_chain_velocities(directions, &velocities);
    for (const Vector3& velocity : velocities)
      sketch.points.velocities.insert(sketch.points.velocities.end(), velocity.begin(), velocity.end());
  }
  return std::move(sketch).finish();
}

const std::vector<Kind<PointSet>> kinds = {
    {"chain", {"spacing", "mass", "seed", "count", "direction", "anchored"}, generate_chain},
    {"ring", {"spacing", "mass", "seed", "count"}, generate_ring},
    {"net", {"spacing", "mass", "seed", "columns", "rows"}, generate_net},
    {"lattice", {"spacing", "mass", "seed", "size"}, generate_lattice},
    {"tree", {"spacing", "mass", "seed", "count"}, generate_tree},
    {"clusters", {"spacing", "mass", "seed", "clusters", "count"}, generate_clusters},
    {"melt",
     {"spacing", "mass", "seed", "chains", "count", "temperature", "bonds", "epsilon", "bending"},
     generate_melt},
};

}  // namespace

PointSet read_generate(const Cursor& generate, const Context& context) {
  return read_kind(generate, kinds, {}, context);
}

}  // namespace tanor::scene
