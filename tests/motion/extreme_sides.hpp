#pragma once

/// \file Scenes with ropes and guides to one side at the edge of what can be simulated, for bench/extreme.cpp.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "motion/extreme_scenes.hpp"

namespace tanor::extreme {

/// Methods that know sides.
inline const std::vector<Method> of_sides{Method::Rk4, Method::Dopri5, Method::Dop853, Method::Taylor, Method::Rattle};

inline Case one_sided(std::string name, System system, double t_end, double step,
                      std::function<double(const Simulation&)> error, double extra = 1e-9) {
  Case scene{"sides", std::move(name), std::move(system), t_end, step, std::move(error)};
  scene.methods = of_sides;
  scene.extra = scene.extra_of_fixed_steps = extra;
  return scene;
}

inline System make_points(const std::vector<Vector3>& places, std::vector<double> masses) {
  System system;
  for (const Vector3& place : places) scenes::add_point(place, &system);
  system.masses = std::move(masses);
  system.velocities.assign(system.positions.size(), 0.0);
  system.forces = {scenes::gravity};
  return system;
}

inline Planes floor_of(std::vector<Index> points, double restitution = 0.0) {
  return {.name = "floor",
          .points = std::move(points),
          .normal = Vector3{0, 0, 1},
          .offset = 0.0,
          .side = OneSide::AtLeast,
          .restitution = restitution};
}

/// A weight under a light bead, both on ropes, is thrown up and falls into them: all stands where it began.
inline Case catch_heavy_tip(double ratio) {
  System system = make_points({{0, 0, 0}, {0, 0, -1}, {0, 0, -2}}, {1, 1, ratio});
  system.velocities = {0, 0, 0, 0, 0, 2, 0, 0, 2};
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {Ropes{.name = "ropes", .paths = {{0, 1}, {1, 2}}}};
  return one_sided("ropes catch a tip " + power(ratio), system, 1.0, 1e-3, shift(system, 1.0));
}

/// A ball bounces from a height with restitution e, scaled to any length and speed; impacts follow one another by e.
inline Case bounce(const std::string& name, double height, double e, double bounces, double away = 0.0) {
  System system = make_points({{away, 0, height}}, {1});
  system.constraints = {floor_of({0}, e)};
  const double first = std::sqrt(2.0 * height / g), t_end = first * (1.0 + 2.0 * bounces);
  double t = first, u = e * g * first;
  while (t + 2.0 * u / g < t_end) {
    t += 2.0 * u / g;
    u *= e;
  }
  const double z = u * (t_end - t) - 0.5 * g * (t_end - t) * (t_end - t);
  Case scene = one_sided(name, system, t_end, t_end / 2000, miss(0, {away, 0, z}, height), 1e-8);
  scene.atol = 1e-12 * height;
  return scene;
}

/// It stands after infinitely many bounces.
inline Case bounce_to_rest() {
  System system = make_points({{0, 0, 1}}, {1});
  system.constraints = {floor_of({0}, 0.5)};
  return one_sided("bounces of e = 0.5 end", system, 3.0, 1e-3, miss(0, {0, 0, 0}, 1.0));
}

/// A weight on a spring of 1e6 N/m stands on a shoe, which stands on the floor and never lifts.
inline Case stand_on_stiff_spring() {
  const double k = 1e6, amplitude = 5e-6, t = 0.02;
  System system = make_points({{0, 0, 0}, {0, 0, 1.0 - g / k + amplitude}}, {1, 1});
  system.constraints = {floor_of({0})};
  system.forces.push_back(Springs{.name = "spring", .pairs = {{0, 1}}, .stiffness = k, .rest_length = 1.0});
  return one_sided("stiff spring on a contact", system, t, 1e-5,
                   miss(1, {0, 0, 1.0 - g / k + amplitude * std::cos(std::sqrt(k) * t)}, 1.0), 1e-10);
}

/// Balls that lie on a floor to the rounding of their gap.
inline Case lie_at_gap(double gap) {
  System system = make_points({{0, 0, gap}, {3, 0, 0}}, {1, 1});
  system.constraints = {floor_of({0, 1}, 0.5)};
  return one_sided("gap of " + power(gap) + " m", system, 1.0, 1e-3, miss(0, {0, 0, 0}, 1.0));
}

/// A ball is thrown to a ceiling at `above` its highest place.
inline Case graze(double above) {
  const double up = 2.0, top = 0.5 * up * up / g, ceiling = top + above, t_end = 0.6;
  System system = make_points({{0, 0, 0}}, {1});
  system.velocities = {1, 0, up};
  system.constraints = {
      Planes{.name = "ceiling", .points = {0}, .normal = Vector3{0, 0, 1}, .offset = ceiling, .side = OneSide::AtMost}};
  const double last = above < 0.0 ? std::sqrt(-2.0 * g * above) : 0.0, t = (up - last) / g, fall = t_end - t;
  const double z = above < 0.0 ? ceiling - 0.5 * g * fall * fall : up * t_end - 0.5 * g * t_end * t_end;
  return one_sided(std::string("grazes a ceiling 1e-10 m ") + (above < 0.0 ? "below" : "above") + " its top", system,
                   t_end, 1e-3, miss(0, {t_end, 0, z}, 0.2), 1e-6);
}

/// A weight falls from the middle of a ring of `count` supports until all of its strings are taut at once.
inline Case hang_on_strings(int count) {
  System system = make_points({{0, 0, 0}}, {1});
  Ropes strings{.name = "strings", .length = 2.0};
  Support ring{"ring", {}, {}};
  for (int k = 0; k < count; ++k) {
    const double angle = 2.0 * pi * k / count;
    ring.points.push_back(scenes::add_point({std::cos(angle), std::sin(angle), 0}, &system));
    strings.paths.push_back({0, ring.points.back()});
  }
  system.masses.assign(system.num_points(), 1.0);
  system.velocities.assign(system.positions.size(), 0.0);
  system.supports = {ring};
  system.constraints = {strings};
  return one_sided(std::to_string(count) + " strings on one point", system, 1.5, 1e-3,
                   miss(0, {0, 0, -std::sqrt(3.0)}, 1.0));
}

/// A chain of ropes, each of them twice.
inline Case drop_double_ropes() {
  System system = scenes::make_chain(10);
  Ropes ropes{.name = "ropes"};
  for (const auto& [i, j] : std::get<Rods>(system.constraints[0]).pairs)
    for (int twice = 0; twice < 2; ++twice) ropes.paths.push_back({i, j});
  system.constraints = {ropes};
  return one_sided("chain, every rope twice", system, 0.3, 1e-3, {});
}

/// A weight on a rope of 1 m under another one on a rope of 1e6 m; the lower one swings.
inline Case swing_below_long_rope() {
  System system = make_points({{0, 0, 0}, {0, 0, -1e6}, {0.5, 0, -1e6 - std::sqrt(0.75)}}, {1, 1, 1});
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {Ropes{.name = "ropes", .paths = {{0, 1}, {1, 2}}}};
  return one_sided("ropes of 1e6 m and 1 m", system, 1.0, 1e-3, {});
}

/// A winch takes up 0.5 m of rope in 1 s, then lifts a weight from the floor.
inline Case lift_by_winch() {
  System system = make_points({{0, 0, 1}, {0, 0, 0}}, {1, 1});
  system.supports = {{"winch", {0}, {}}};
  system.constraints = {Ropes{.name = "rope", .paths = {{0, 1}}, .length = ScalarFunction::formula("1.5-0.5*t")},
                        floor_of({1})};
  return one_sided("a winch lifts from the floor", system, 1.5, 1e-3, miss(1, {0, 0, 0.25}, 1.0));
}

/// A bead slides from the top of a sphere of 1 m and leaves it; its speed is that of its depth.
inline Case leave_sphere() {
  System system = make_points({{1e-3, 0, std::sqrt(1.0 - 1e-6)}}, {1});
  system.constraints = {
      Spheres{.name = "ball", .points = {0}, .center = Vector3{0, 0, 0}, .radius = 1.0, .side = OneSide::AtLeast}};
  const double top = system.positions[2];
  return one_sided("a bead leaves a sphere", system, 3.2, 1e-3, [top](const Simulation& at) {
    const auto v = at.velocities();
    // cos = 2/3 of the height of the start where it leaves, so that v_x stays sqrt(g cos) cos.
    const double cosine = 2.0 * top / 3.0, along = std::sqrt(g * cosine) * cosine;
    const double energy = 0.5 * (v[0] * v[0] + v[2] * v[2]) - g * (top - at.positions()[2]);
    return std::max(std::abs(v[0] / along - 1.0), std::abs(energy) / g);
  });
}

/// Five balls in a row hand on the speed of the first one, over gaps of `gap`.
inline Case hand_on(double gap) {
  System system = make_points({{0, 0, 0}}, {1});
  Rods apart{.name = "balls", .length = 1.0, .side = OneSide::AtLeast, .restitution = 1.0};
  for (Index k = 1; k < 5; ++k) {
    scenes::add_point({k * (1.0 + gap), 0, 0}, &system);
    apart.pairs.push_back({k - 1, k});
  }
  system.masses.assign(5, 1.0);
  system.velocities.assign(15, 0.0);
  system.velocities[0] = 1.0;
  system.forces.clear();
  system.constraints = {apart};
  return one_sided("balls hand on a speed over gaps of " + power(gap) + " m", system, 1.0, 1e-3,
                   miss(4, {4.0 * (1.0 + gap) + 1.0 - 4.0 * gap, 0, 0}, 1.0));
}

/// A bead stands between two planes that are nearly walls: 1000 N each hold 9.81 N.
inline Case stand_in_wedge() {
  const double slope = 9.81 / 2000.0;
  System system = make_points({{0, 0, 0.1}}, {1});
  for (const double side : {-1.0, 1.0})
    system.constraints.push_back(Planes{.name = side < 0.0 ? "left" : "right",
                                        .points = {0},
                                        .normal = Vector3{side, 0, slope},
                                        .offset = 0.0,
                                        .side = OneSide::AtLeast});
  return one_sided("a bead falls into a wedge", system, 1.0, 1e-3, miss(0, {0, 0, 0}, 1.0), 1e-8);
}

/// A ball falls on three floors in one place, of which each has its own e; the liveliest one counts.
inline Case fall_on_three_floors() {
  System system = make_points({{0, 0, 1}}, {1});
  for (const double e : {0.0, 0.8, 0.3}) {
    system.constraints.push_back(floor_of({0}, e));
    std::get<Planes>(system.constraints.back()).name += std::to_string(system.constraints.size());
  }
  const double t = std::sqrt(2.0 / g), fall = 0.5, u = 0.8 * g * t;
  return one_sided("three floors in one place", system, t + fall, 1e-3,
                   miss(0, {0, 0, u * fall - 0.5 * g * fall * fall}, 1.0));
}

inline std::vector<Case> list_one_sided_cases() {
  std::vector<Case> cases;
  for (const double ratio : {1e3, 1e6, 1e9}) cases.push_back(catch_heavy_tip(ratio));
  cases.push_back(bounce("bounces of e = 0.999", 1.0, 0.999, 9.3));
  cases.push_back(bounce("bounces of e = 1", 1.0, 1.0, 30.3));
  cases.push_back(bounce("bounces from 1e-6 m", 1e-6, 0.9, 3.3));
  cases.push_back(bounce("bounces from 1e6 m", 1e6, 0.5, 0.7));
  cases.push_back(bounce_to_rest());
  cases.push_back(stand_on_stiff_spring());
  for (const double gap : {1e-15, 1e-9}) cases.push_back(lie_at_gap(gap));
  for (const double above : {1e-10, -1e-10}) cases.push_back(graze(above));
  for (const int count : {12, 200}) cases.push_back(hang_on_strings(count));
  cases.push_back(drop_double_ropes());
  cases.push_back(swing_below_long_rope());
  cases.push_back(lift_by_winch());
  cases.push_back(leave_sphere());
  for (const double gap : {1e-3, 1e-9}) cases.push_back(hand_on(gap));
  cases.push_back(stand_in_wedge());
  cases.push_back(fall_on_three_floors());
  return cases;
}

}  // namespace tanor::extreme
