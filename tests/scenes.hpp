#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "measures.hpp"
#include "methods.hpp"

/// Systems for tests and measurements, in which z is up, rods are 0.1 m, beads 0.1 kg, and g is 9.81 m/s^2.
namespace tanor::scenes {

constexpr double spacing = 0.1, mass = 0.1, g = 9.81;

inline const Force gravity = Gravity{"gravity", {0, 0, -g}};

inline Index add_point(const Vector3& place, System* system) {
  system->positions.insert(system->positions.end(), place.begin(), place.end());
  system->velocities.resize(system->positions.size(), 0.0);
  system->masses.push_back(mass);
  return static_cast<Index>(system->masses.size() - 1);
}

inline Vector3 place_of(const System& system, std::size_t i) {
  return {system.positions[3 * i], system.positions[3 * i + 1], system.positions[3 * i + 2]};
}

/// Sets velocities of a rigid motion, v + omega x r, which rods allow.
inline void set_rigid_motion(const Vector3& v, const Vector3& omega, System* system) {
  for (std::size_t i = 0; i < system->num_points(); ++i) {
    const auto [x, y, z] = place_of(*system, i);
    system->velocities[3 * i] = v[0] + omega[1] * z - omega[2] * y;
    system->velocities[3 * i + 1] = v[1] + omega[2] * x - omega[0] * z;
    system->velocities[3 * i + 2] = v[2] + omega[0] * y - omega[1] * x;
  }
}

/// Sets velocities that violate the rods. StartMode::Project makes them admissible.
inline void set_random_velocities(double speed, unsigned seed, System* system) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> component(-speed, speed);
  for (double& v : system->velocities) v = component(random);
}

/// Returns a falling chain of rods through these places, with a support at the first one.
inline System make_chain_through(const std::vector<Vector3>& places) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (const Vector3& place : places) {
    const Index i = add_point(place, &system);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {rods};
  system.forces = {gravity};
  return system;
}

/// Returns `count` rods along x, falling. The first bead is a support if `anchored`.
inline System make_chain(std::size_t count, bool anchored = true) {
  System system;
  Rods rods{"rods", {}, spacing, {}};
  for (std::size_t k = 0; k <= count; ++k) {
    const Index i = add_point({spacing * static_cast<double>(k), 0, 0}, &system);
    if (k > 0) rods.pairs.push_back({i - 1, i});
  }
  if (anchored) system.supports = {{"anchor", {0}, {}}};
  system.constraints = {rods};
  system.forces = {gravity};
  return system;
}

/// Returns `count` rods from the origin, each of them `step` long and along it. The chain is free and without forces.
inline System make_chain_along(int count, const Vector3& step, double bead = mass) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (int k = 0; k <= count; ++k) {
    const Index i = add_point({k * step[0], k * step[1], k * step[2]}, &system);
    if (k > 0) rods.pairs.push_back({i - 1, i});
  }
  std::ranges::fill(system.masses, bead);
  system.constraints = {rods};
  return system;
}

/// Returns a pendulum of one rod, at rest and horizontal.
inline System make_pendulum() {
  return make_chain(1);
}

/// Returns a bob at rest on a rod from the origin, whose length is that of the drawing.
inline System make_pendulum(const Vector3& bob, double bob_mass) {
  System system = make_chain_through({{0, 0, 0}, bob});
  system.velocities.clear();
  system.masses = {1.0, bob_mass};
  return system;
}

/// Returns parallel cranks of 1 m between pivots at these x and unit masses in a plane, which turn at `rate`. Couplers
/// join the tips of neighbours. The pivots are the first points.
inline System make_cranks(const std::vector<double>& pivots, double angle, double rate) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto count = static_cast<Index>(pivots.size());
  System system;
  Rods bars{"bars", {}, {}, {}};
  Support held{"pivots", {}, {}};
  Planes sheet{"plane", {}, {0, 0, 1}, 0.0};
  for (const double x : pivots) held.points.push_back(add_point({x, 0, 0}, &system));
  for (const double x : pivots) {
    const Index tip = add_point({x + c, s, 0}, &system);
    system.velocities[3 * static_cast<std::size_t>(tip)] = -rate * s;
    system.velocities[3 * static_cast<std::size_t>(tip) + 1] = rate * c;
    bars.pairs.push_back({tip - count, tip});
    sheet.points.push_back(tip);
  }
  for (Index tip = count + 1; tip < 2 * count; ++tip) bars.pairs.push_back({tip - 1, tip});
  system.masses.assign(system.num_points(), 1.0);
  system.supports = {held};
  system.constraints = {bars, sheet};
  return system;
}

/// Returns a parallelogram of two cranks on pivots `base` apart, m. It is flat at angle 0 and after each half turn,
/// where the motion could continue as an antiparallelogram.
inline System make_four_bar(double angle, double rate, double base = 1.0) {
  return make_cranks({0.0, base}, angle, rate);
}

/// Returns a closed ring of rods that turns and tumbles, free and without forces.
inline System make_ring(std::size_t count) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t k = 0; k < count; ++k) {
    const double angle = 2.0 * M_PI * static_cast<double>(k) / static_cast<double>(count);
    const Index i = add_point({0.2 * std::cos(angle), 0.2 * std::sin(angle), 0.0}, &system);
    rods.pairs.push_back({i, static_cast<Index>((k + 1) % count)});
  }
  system.constraints = {rods};
  set_rigid_motion({0, 0, 0}, {0.5, 0, 3}, &system);
  return system;
}

/// Returns beads on a grid with rods along its axes, `size` beads along each of them.
inline System make_grid(const std::array<int, 3>& size) {
  System system;
  Rods rods{"rods", {}, spacing, {}};
  const auto number = [&](int a, int b, int c) { return static_cast<Index>((a * size[1] + b) * size[2] + c); };
  for (int a = 0; a < size[0]; ++a) {
    for (int b = 0; b < size[1]; ++b) {
      for (int c = 0; c < size[2]; ++c) {
        const Index i = add_point({spacing * a, spacing * b, spacing * c}, &system);
        if (a > 0) rods.pairs.push_back({number(a - 1, b, c), i});
        if (b > 0) rods.pairs.push_back({number(a, b - 1, c), i});
        if (c > 0) rods.pairs.push_back({number(a, b, c - 1), i});
      }
    }
  }
  system.constraints = {rods};
  return system;
}

/// Returns the same system, falling and held at these points.
inline System hang(System system, const std::vector<Index>& points) {
  system.supports = {{"corners", points, {}}};
  system.forces = {gravity};
  return system;
}

/// Returns a net that hangs at two opposite corners, since a straight row of rods between two supports would be
/// redundant.
inline System make_net(int columns, int rows) {
  return hang(make_grid({columns, rows, 1}), {0, static_cast<Index>(columns * rows - 1)});
}

/// Returns a flat square net that hangs from two neighbouring corners. Unequal masses are 0.05 to 0.15 kg, and columns
/// go from light below to heavy below. Each column swings by itself, and so no two of them have a frequency in common.
inline System make_hung_net(int side, bool has_unequal_masses = false) {
  System system = hang(make_grid({side, side, 1}), {0, static_cast<Index>(side - 1)});
  if (!has_unequal_masses) return system;
  for (int k = 0; k < side * side; ++k) {
    const double x = 2.0 * (k / side) / (side - 1) - 1.0, y = 2.0 * (k % side) / (side - 1) - 1.0;
    system.masses[static_cast<std::size_t>(k)] = 0.1 + 0.05 * x * y;
  }
  return system;
}

/// Returns a net that hangs straight down from a row of supports and swings a little out of its plane. No cell folds,
/// however long the motion lasts.
inline System make_curtain(int columns, int rows) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  Support row{"row", {}, {}};
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const Index point = add_point({spacing * x, 0.0, -spacing * y}, &system);
      if (y == 0) row.points.push_back(point);
      if (y > 0) system.velocities[3 * static_cast<std::size_t>(point) + 1] = 0.1 * std::sin(x + y);
      if (x > 0 && y > 0) rods.pairs.push_back({point - 1, point});
      if (y > 0) rods.pairs.push_back({point - columns, point});
    }
  }
  system.supports = {row};
  system.constraints = {rods};
  system.forces = {gravity};
  return system;
}

/// Returns a cube without forces, with random velocities.
inline System make_lattice(int size) {
  System system = make_grid({size, size, size});
  set_random_velocities(1.0, 5, &system);
  return system;
}

/// Returns free random walks of 10 rods each, with random velocities and without forces.
inline System make_clusters(std::size_t clusters) {
  System system;
  std::mt19937 random(7);
  std::normal_distribution<double> component;
  Rods rods{"rods", {}, spacing, {}};
  for (std::size_t cluster = 0; cluster < clusters; ++cluster) {
    Vector3 place{2.0 * static_cast<double>(cluster), 0, 0};
    for (int k = 0; k <= 10; ++k) {
      const Index i = add_point(place, &system);
      if (k > 0) rods.pairs.push_back({i - 1, i});
      const Vector3 step{component(random), component(random), component(random)};
      const double length = std::hypot(step[0], step[1], step[2]);
      for (std::size_t axis = 0; axis < 3; ++axis) place[axis] += spacing * step[axis] / length;
    }
  }
  system.constraints = {rods};
  set_random_velocities(1.0, 11, &system);
  return system;
}

/// Returns groups of four beads, one on each guide, held together by damped springs, in air.
///
///   circle --spring-- sphere --spring-- plane --spring-- line
inline System make_beads(int groups) {
  System system;
  Circles circles{"circles", {}, Vector3{0, 0, 0}, Vector3{0, 0, 1}, 1.0};
  Spheres spheres{"spheres", {}, Vector3{0, 0, 0}, 1.5};
  Planes planes{"planes", {}, Vector3{0, 1, 1}, 2.0};
  Lines lines{"lines", {}, Vector3{0, 0, 3}, Vector3{1, 0, 0}};
  Springs springs{"springs", {}, 2.0, 0.05, 0.3};
  for (int k = 0; k < groups; ++k) {
    const double angle = 0.37 * k, c = std::cos(angle), s = std::sin(angle);
    const Index first = add_point({c, s, 0}, &system);
    add_point({1.2 * c, 1.2 * s, 0.9}, &system);
    add_point({1.5 * c, s, 2.0 - s}, &system);
    add_point({2.0 * c, 0, 3}, &system);
    circles.points.push_back(first);
    spheres.points.push_back(first + 1);
    planes.points.push_back(first + 2);
    lines.points.push_back(first + 3);
    for (Index j = 0; j < 3; ++j) springs.pairs.push_back({first + j, first + j + 1});
  }
  Drag air{"air", {}, 0.02, 0.01};
  for (std::size_t i = 0; i < system.num_points(); ++i) air.points.push_back(static_cast<Index>(i));
  system.constraints = {circles, spheres, planes, lines};
  system.forces = {gravity, springs, air};
  return system;
}

/// Returns the same beads on rough guides, pulled to and fro through the springs so that they stick and slide.
inline System make_rough_beads(int groups) {
  System system = make_beads(groups);
  system.friction = {Coulomb{"rust", {"circles"}, 0.2, 0.3}, Coulomb{"felt", {"planes"}, 0.3, 0.35},
                     Coulomb{"ball", {"spheres"}, 0.1, 0.15}, Coulomb{"wire", {"lines"}, 0.25, 0.3}};
  return system;
}

/// Returns a hanging chain whose support is shaken.
inline System make_shaken_chain(std::size_t count = 5) {
  System system = make_chain(count);
  system.supports[0].displacement = {ScalarFunction::formula("0.05*sin(3*t)^2"),
                                     ScalarFunction::formula("0.03*(1-cos(5*t))"), ScalarFunction::formula("0.1*t^2")};
  return system;
}

/// Returns a shaken chain in air with damped springs, which has all that depends on the start and all that does work.
inline System make_shaken_chain_in_air(double damping) {
  System system = make_shaken_chain();
  std::get<Rods>(system.constraints[0]).length = {};
  system.forces.push_back(Drag{"air", {1, 3, 5}, 0.05, 0.1});
  system.forces.push_back(Springs{"springs", {{0, 2}, {1, 4}}, 20.0, damping, 0.15});
  return system;
}

/// Returns a chain whose rods change their length periodically.
inline System make_breathing_chain(std::size_t count = 5) {
  System system = make_chain(count);
  std::get<Rods>(system.constraints[0]).length = ScalarFunction::formula("0.1*(1 + 0.2*sin(2*t)^2)");
  return system;
}

/// Returns a chain in air.
inline System make_chain_in_air(std::size_t count = 5) {
  System system = make_chain(count);
  Drag air{"air", {}, 0.05, 0.1};
  for (std::size_t i = 1; i <= count; ++i) air.points.push_back(static_cast<Index>(i));
  system.forces.push_back(air);
  return system;
}

/// Returns a chain whose beads pull at their second neighbours through damped springs.
inline System make_damped_chain(std::size_t count = 5) {
  System system = make_chain(count);
  Springs springs{"springs", {}, 20.0, 0.1, 0.15};
  for (std::size_t i = 2; i <= count; ++i) springs.pairs.push_back({static_cast<Index>(i - 2), static_cast<Index>(i)});
  system.forces.push_back(springs);
  return system;
}

/// Returns a chain whose last bead is pulled to and fro.
inline System make_driven_chain(std::size_t count = 5) {
  System system = make_chain(count);
  system.forces.push_back(
      ConstantForce{"drive",
                    {static_cast<Index>(count)},
                    {ScalarFunction::formula("0.3*sin(4*t)"), 0.0, ScalarFunction::formula("0.5*cos(t)")}});
  return system;
}

/// Returns unit masses on a cubic grid, each moved by up to a tenth of 1 m along each axis, without velocities and
/// rods.
inline System make_shaken_grid(const std::array<int, 3>& size, double distance, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shake(-0.1, 0.1);
  System system;
  for (int a = 0; a < size[0]; ++a) {
    for (int b = 0; b < size[1]; ++b) {
      for (int c = 0; c < size[2]; ++c) {
        for (const int k : {a, b, c}) system.positions.push_back(distance * k + shake(random));
        system.masses.push_back(1.0);
      }
    }
  }
  return system;
}

/// Returns chains of three rods side by side in a periodic box, `size`^3 beads (a multiple of 4 along an edge) that
/// repel each other. Their random velocities need StartMode::Project.
inline System make_melt(int size) {
  System system = make_grid({size, size, size});
  Rods& rods = std::get<Rods>(system.constraints[0]);
  std::erase_if(rods.pairs,
                [](const std::array<Index, 2>& pair) { return pair[1] - pair[0] != 1 || pair[1] % 4 == 0; });
  const double edge = spacing * size;
  system.forces = {PairForces{.name = "beads",
                              .law = PairLaw::Wca,
                              .epsilon = 0.1,
                              .sigma = 0.95 * spacing,
                              .box = {edge, edge, edge},
                              .exclude_rods = true}};
  set_random_velocities(1.0, 11, &system);
  return system;
}

/// Returns coordinates of every kind, falling, without equivalent constraints.
inline System make_coordinates() {
  System system;
  system.supports = {{"anchor", {add_point({0, 0, 0}, &system)}, {}}};
  ChainAngles chain{"chain", {}, 0, spacing, {}};
  for (int k = 1; k <= 3; ++k) chain.points.push_back(add_point({spacing * k, 0, 0}, &system));
  RigidBody body{"body", {}};
  for (const Vector3& place : {Vector3{1, 0, 0}, Vector3{1.1, 0, 0}, Vector3{1, 0.1, 0}, Vector3{1, 0, 0.1}}) {
    body.points.push_back(add_point(place, &system));
  }
  const Index free = add_point({2, 0, 0}, &system), bead = add_point({3, 0, 0}, &system);
  const Index leaf = add_point({4, 0, 0}, &system), ball = add_point({5, 0, 0}, &system);
  const Index ring = add_point({6, 0, 0}, &system), user = add_point({7, 0, 0}, &system);
  const VectorFunction turning = {ScalarFunction::formula("sin(20*t)"), 0.0, ScalarFunction::formula("cos(20*t)")};
  const std::vector<std::string> names = {"a"}, components = {"7 + sin(a)", "0.1*t", "1 - cos(a)"};
  system.coordinates = {chain,
                        body,
                        FreeCoordinates{"free", {free}},
                        LineCoordinates{"line", {bead}, Vector3{3, 0, 0}, Vector3{1, 0, -1}},
                        PlaneCoordinates{"plane", {leaf}, turning, 0.0},
                        SphereCoordinates{"sphere", {ball}, Vector3{5, 0, -1}, 1.0},
                        CircleCoordinates{"circle", {ring}, Vector3{6, 0.2, 0}, turning, 0.2},
                        UserCoordinates{"formula", {{user}}, formula_coordinates(names, components), {0.0}, {1.0}}};
  system.forces = {gravity, Springs{"springs", {{free, bead}, {leaf, ball}}, 1.0, 0.0, {}}};
  return system;
}

/// Returns an observer that stops a run after this number of further steps.
inline Simulation::Observer stop_after(std::size_t steps) {
  return [left = steps](const MotionReport&) mutable { return --left > 0; };
}

}  // namespace tanor::scenes
