#pragma once

/// \file Scenes at the edge of what can be simulated, for tests and for bench/extreme.cpp.

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "motion/elliptic.hpp"
#include "scenes.hpp"

namespace tanor::extreme {

constexpr double pi = 3.14159265358979323846, g = 9.81;

struct Case {
  std::string group, name;
  System system;
  double t_end;                                      ///< s
  double step;                                       ///< s, of methods with fixed steps
  std::function<double(const Simulation&)> error{};  ///< relative, against a closed form; empty if none is known
  double atol = 1e-12;                               ///< m
  std::vector<Method> methods{};                     ///< all if empty
  StartMode start = StartMode::Check;
  double patience = 1.0;              ///< times the usual time limit
  double rate = 0.0;                  ///< rad/s, of the fastest turn or swing; 0 if nothing moves
  double extra = 1e-12;               ///< relative error besides that of the steps, from rounding and singular places
  double extra_of_fixed_steps = 0.0;  ///< cost of singular places where there is no tolerance
};

/// Returns the scene with the numbers that bound its error.
inline Case bounded(double rate, double extra, Case scene) {
  scene.rate = rate;
  scene.extra = extra;
  return scene;
}

/// Returns tolerances that decide the steps, or the scene's step, with which they only stop Newton's iterations.
inline MotionOptions options_of(const Case& scene, Method method) {
  if (has_fixed_steps(method))
    return {.method = method, .step = scene.step, .rtol = 1e-8, .atol = 100.0 * scene.atol, .start = scene.start};
  return {.method = method, .rtol = 1e-10, .atol = scene.atol, .start = scene.start};
}

/// Returns how large the error of a scene may be; a larger one without a warning is a silent failure. A tolerance
/// applies to one step and errors add up, so that each turn (2 pi) may cost a hundred tolerances. A scheme of order p
/// with fixed steps errs by less than (rate h)^p in each radian while steps are short. An error that can be seen in a
/// picture is too large whatever the step.
inline double largest_error_of(const Case& scene, Method method) {
  const MotionOptions options = options_of(scene, method);
  if (scene.rate == 0.0) return scene.extra;
  const double radians = scene.rate * scene.t_end;
  if (!has_fixed_steps(method)) return scene.extra + 100.0 * options.rtol * std::max(1.0, radians / (2.0 * pi));
  constexpr double visible = 0.02;
  const double of_steps = std::pow(scene.rate * options.step, traits_of(method).order) * radians;
  return std::min(visible, scene.extra + scene.extra_of_fixed_steps + of_steps);
}

/// Returns how much rods and ropes may be violated, relative: max(1e-12, 8 eps |r|/L) with the shortest one as L.
inline double largest_violation(const System& system) {
  double shortest = HUGE_VAL;
  for (const Constraint& constraint : system.constraints) {
    const auto take = [&](Index i, Index j) {
      const Vector3 a = scenes::place_of(system, static_cast<std::size_t>(i)),
                    b = scenes::place_of(system, static_cast<std::size_t>(j));
      shortest = std::min(shortest, std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]));
    };
    if (const Rods* rods = std::get_if<Rods>(&constraint))
      for (const auto& [i, j] : rods->pairs) take(i, j);
    if (const Ropes* ropes = std::get_if<Ropes>(&constraint))
      for (const std::vector<Index>& path : ropes->paths)
        for (std::size_t k = 1; k < path.size(); ++k) take(path[k - 1], path[k]);
  }
  return std::max(1e-12, 8.0 * std::numeric_limits<double>::epsilon() * largest(system.positions) / shortest);
}

inline std::string power(double x) {
  const int exponent = static_cast<int>(std::lround(std::log10(x)));
  return "1e" + std::to_string(exponent);
}

/// Measures how far a point is from where it should be, over the given length.
inline std::function<double(const Simulation&)> miss(Index point, const Vector3& place, double length) {
  return [=](const Simulation& simulation) {
    const auto r = simulation.positions().subspan(3 * static_cast<std::size_t>(point), 3);
    return std::hypot(r[0] - place[0], r[1] - place[1], r[2] - place[2]) / length;
  };
}

/// Measures how far any point moved, over the given length, for scenes that must stay where they are.
inline std::function<double(const Simulation&)> shift(const System& system, double length) {
  return [start = system.positions, length](const Simulation& simulation) {
    return largest_difference(simulation.positions(), start) / length;
  };
}

// ---- masses --------------------------------------------------------------------------------------------------------

/// 20 light beads and a heavy tip turn about their anchor as one straight line. Light beads vibrate like sqrt(ratio).
inline Case turn_heavy_tip(double ratio) {
  System system = scenes::make_chain(20);
  system.masses.back() *= ratio;
  system.forces.clear();
  scenes::set_rigid_motion({}, {0, 0, 1}, &system);
  const double t = 0.5;
  // Rods round to 1e-13, and light beads vibrate with that error.
  return bounded(1.0, 1e-11 * std::sqrt(ratio),
                 {"masses", "tip " + power(ratio) + " turns", system, t, 1e-3,
                  miss(20, {2.0 * std::cos(t), 2.0 * std::sin(t), 0}, 2.0)});
}

inline Case drop_heavy_tip(double ratio) {
  System system = scenes::make_chain(10);
  system.masses.back() *= ratio;
  return {"masses", "tip " + power(ratio) + " falls", system, 0.2, 1e-3};
}

inline Case drop_alternating(double ratio) {
  System system = scenes::make_chain(10);
  for (std::size_t i = 2; i <= 10; i += 2) system.masses[i] *= ratio;
  return {"masses", "alternating " + power(ratio), system, 0.2, 1e-3};
}

// ---- lengths -------------------------------------------------------------------------------------------------------

/// A pendulum swings from the horizontal for about a period.
inline Case swing_scaled(double length) {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({length, 0, 0}, &system);
  system.supports = {{"pivot", {0}, {}}};
  system.constraints = {Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {scenes::gravity};
  const double t = 7.0 * std::sqrt(length / g), angle = elliptic::swing(0.5 * pi, std::sqrt(g / length), t).angle;
  return bounded(std::sqrt(g / length), 1e-12,
                 {"lengths", "pendulum of " + power(length) + " m", system, t, t / 1000,
                  miss(1, {length * std::sin(angle), 0, -length * std::cos(angle)}, length), 1e-12 * length});
}

inline Case drop_scaled_chain(double length) {
  System system = scenes::make_chain(10);
  for (double& x : system.positions) x *= length / scenes::spacing;
  std::get<Rods>(system.constraints[0]).length = {};
  const double t = 0.3 * std::sqrt(length / scenes::spacing);
  return {"lengths", "chain of " + power(length) + " m rods", system, t, t / 1000, {}, 1e-12 * length};
}

/// Rods of 0.1 m fall far from the origin, where positions round to eps |r|/L of a rod.
inline Case drop_far_chain(double distance) {
  System system = scenes::make_chain(10);
  for (std::size_t i = 0; i < system.positions.size(); i += 3) system.positions[i] += distance;
  std::get<Rods>(system.constraints[0]).length = {};
  return {"lengths", "chain " + power(distance) + " m away", system, 0.3, 1e-3};
}

/// Three rods fall, one of which is a millionth as long as the others.
inline Case drop_unequal(int place) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  double x = 0.0;
  scenes::add_point({x, 0, 0}, &system);
  for (Index k = 0; k < 3; ++k) {
    x += k == place ? 1e-6 : 1.0;
    scenes::add_point({x, 0, 0}, &system);
    rods.pairs.push_back({k, k + 1});
  }
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {rods};
  system.forces = {scenes::gravity};
  return {"lengths", "rod of 1e-6 m among rods of 1 m, place " + std::to_string(place), system, 0.02, 1e-5};
}

// ---- speeds --------------------------------------------------------------------------------------------------------

/// A bead on a rod turns by `angle` in a step. Methods of low order lose its phase.
inline Case turn_fast(double angle) {
  System system = scenes::make_pendulum();
  system.forces.clear();
  const double omega = 1e3, h = angle / omega, t = 20 * h, turned = omega * t;
  scenes::set_rigid_motion({}, {0, -omega, 0}, &system);
  return bounded(omega, 1e-12,
                 {"speeds", "rod turns by " + std::to_string(angle).substr(0, 3) + " rad a step", system, t, h,
                  miss(1, {0.1 * std::cos(turned), 0, 0.1 * std::sin(turned)}, 0.1)});
}

// ---- straight ------------------------------------------------------------------------------------------------------

/// A straight chain at rest is pulled with 1 kN.
inline Case pull_straight() {
  System system = scenes::make_chain(20);
  system.forces = {ConstantForce{"pull", {20}, Vector3{1000, 0, 0}}};
  return {"straight", "chain pulled straight by 1 kN", system, 1.0, 1e-3, shift(system, 2.0)};
}

/// A chain is held at both ends, so that no bead can move, though K alone would let the beads move.
inline Case hold_taut() {
  System system = scenes::make_chain(20);
  system.supports.push_back({"end", {20}, {}});
  return {"straight", "chain taut between supports", system, 1.0, 1e-3, shift(system, 2.0)};
}

/// A bead on two rods of about 1 m, at the distance `sag` from the line of their supports, swings as a pendulum of that
/// length. Rods that hold to 1e-13 fix the length to 1e-13/sag^2.
inline Case swing_on_flat_triangle(double sag) {
  System system;
  scenes::add_point({-1, 0, 0}, &system);
  scenes::add_point({1, 0, 0}, &system);
  scenes::add_point({0, sag, 0}, &system);
  system.supports = {{"ends", {0, 1}, {}}};
  system.constraints = {Rods{"rods", {{0, 2}, {1, 2}}, {}, {}}};
  system.forces = {scenes::gravity};
  const double t = 7.0 * std::sqrt(sag / g), angle = elliptic::swing(0.5 * pi, std::sqrt(g / sag), t).angle;
  // A relative error d of the length changes a turn of 7 rad by 7 d/2.
  return bounded(std::sqrt(g / sag), 3.5e-13 / (sag * sag),
                 {"straight", "flat triangle, sag " + power(sag), system, t, t / 1000,
                  miss(2, {0, sag * std::sin(angle), -sag * std::cos(angle)}, sag), std::max(1e-12 * sag, 1e-14)});
}

// ---- singular and redundant ----------------------------------------------------------------------------------------

/// Two cranks and a coupler of 1 m are flat at angle 0. Both cranks turn at the same constant rate.
inline Case turn_four_bar(double angle, double t, const std::string& name) {
  // The extrapolation past each flat place leaves 1e-11 of the rate wrong, and the cranks turn on with that error.
  double turned = 0.0;  // since the flat places, rad, all of them together
  for (double flat = angle; flat < t; flat += pi) turned += t - flat;
  return bounded(1.0, 1e-11 * turned,
                 {"singular", name, scenes::make_four_bar(angle, -1.0), t, 1e-3,
                  miss(3, {1 + std::cos(angle - t), std::sin(angle - t), 0}, 1.0)});
}

inline Case pass_flat_place() {
  return turn_four_bar(0.5, 1.5, "four-bar passes the flat place");
}

inline Case start_flat() {
  return turn_four_bar(0.0, 1.0, "four-bar starts flat");
}

/// Integrates angle'' = -g cos(angle) of four-bars that start upright by Runge-Kutta steps of order 4 (to 1e-12).
inline double angle_of_four_bars(double t) {
  constexpr int steps = 20'000;
  const double h = t / steps;
  const auto turn = [](double at) { return -g * std::cos(at); };
  double angle = 0.5 * pi, rate = -1.0;
  for (int i = 0; i < steps; ++i) {
    const double k1 = turn(angle), k2 = turn(angle + 0.5 * h * rate),
                 k3 = turn(angle + 0.5 * h * (rate + 0.5 * h * k1)), k4 = turn(angle + h * (rate + 0.5 * h * k2));
    angle += h * (rate + h * (k1 + k2 + k3) / 6.0);
    rate += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
  }
  return angle;
}

/// Four-bars side by side start upright, in gravity (IFToMM A02 with masses at the joints).
inline Case turn_four_bars(Index loops) {
  System system;
  Support ground{"ground", {}, {}};
  Rods bars{"bars", {}, 1.0, {}};
  Planes sheet{"sheet", {}, Vector3{0, 1, 0}, 0.0};
  for (Index k = 0; k <= loops; ++k) {
    ground.points.push_back(scenes::add_point({1.0 * k, 0, 0}, &system));
    sheet.points.push_back(scenes::add_point({1.0 * k, 0, 1}, &system));
    system.velocities[system.velocities.size() - 3] = 1.0;
    bars.pairs.push_back({ground.points.back(), sheet.points.back()});
    if (k > 0) bars.pairs.push_back({sheet.points[static_cast<std::size_t>(k) - 1], sheet.points.back()});
  }
  system.supports = {ground};
  system.constraints = {bars, sheet};
  system.forces = {scenes::gravity};
  constexpr double t = 5.0;
  // The angle is computed once, since each process makes all scenes for the names of tests.
  static const double angle = angle_of_four_bars(t);
  // The extrapolation past each of five flat places costs up to 100 tolerances, or about (rate h)^2 of a fixed step.
  const double fastest = std::sqrt(1.0 + 2.0 * g);
  Case result = bounded(fastest, 5e-8,
                        {"singular", std::to_string(loops) + " four-bars, 5 s", system, t, 1e-3,
                         miss(1, {std::cos(angle), 0, std::sin(angle)}, 1.0)});
  result.extra_of_fixed_steps = 5e-6;
  return result;
}

/// A net is held at two adjacent corners, so that the edge between them is taut.
inline Case drop_adjacent_net(int size) {
  System system = scenes::make_net(size, size);
  system.supports = {{"corners", {0, static_cast<Index>(size) - 1}, {}}};
  return {"singular", "net " + std::to_string(size) + " on adjacent corners", system, 0.1, 5e-4};
}

inline Case swing_parallelogram() {
  constexpr double x[] = {0.0, 1.0, 2.5};
  System system;
  for (const double pivot : x) scenes::add_point({pivot, 0, 0}, &system);
  for (const double pivot : x) scenes::add_point({pivot + std::sin(0.7), 0, -std::cos(0.7)}, &system);
  system.masses = {1, 1, 1, 1, 2, 3};
  system.supports = {{"pivots", {0, 1, 2}, {}}};
  system.constraints = {Rods{"cranks", {{0, 3}, {1, 4}, {2, 5}}, 1.0, {}},
                        Rods{"couplers", {{3, 4}, {4, 5}, {3, 5}}, std::vector{1.0, 1.5, 2.5}, {}}};
  system.forces = {scenes::gravity};
  return bounded(std::sqrt(g), 1e-12,
                 {"redundant", "parallelogram, a coupler too many", system, 5.0, 1e-3,
                  miss(3, {-0.5703965679671275, 0, -0.8213694389562604}, 1.0)});
}

inline Case drop_duplicates() {
  System system = scenes::make_chain(10);
  Rods& rods = std::get<Rods>(system.constraints[0]);
  rods.pairs.insert(rods.pairs.end(), rods.pairs.begin(), rods.pairs.end());
  return {"redundant", "chain, every rod twice", system, 0.5, 5e-4};
}

/// Two triangles on a hinge are thrown.
inline Case throw_diamond() {
  System system;
  for (const Vector3& place : {Vector3{0, 0, 0}, {0.49, 0, 0}, {0.57, 0.26, 0}, {0.9, -0.2, 0.5}}) {
    scenes::add_point(place, &system);
  }
  system.masses = {12, 14, 12, 16};
  system.constraints = {Rods{"rods", {{0, 1}, {0, 2}, {1, 2}, {3, 1}, {3, 2}}, {}, {}}};
  system.velocities = {0.3, -1.0, 0.5, 0.2, 0.9, -0.4, -0.7, 0.1, 1.1, 0.6, -0.2, -0.8};
  Case result{"redundant", "diamond of five rods, 10 s", system, 10.0, 1e-3};
  result.start = StartMode::Project;
  return result;
}

// ---- nothing happens -----------------------------------------------------------------------------------------------

inline Case rest_free_point() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  return {"rest", "one free point at the origin", system, 1.0, 1e-2, shift(system, 1.0)};
}

inline Case rest_chain() {
  System system = scenes::make_chain(10);
  system.forces.clear();
  return {"rest", "chain without forces", system, 1.0, 1e-2, shift(system, 1.0)};
}

inline Case rest_hanging() {
  System system = scenes::make_chain(10);
  for (std::size_t i = 0; i <= 10; ++i) std::swap(system.positions[3 * i], system.positions[3 * i + 2]);
  for (std::size_t i = 0; i <= 10; ++i) system.positions[3 * i + 2] *= -1.0;
  return {"rest", "chain hangs", system, 1.0, 1e-3, shift(system, 1.0)};
}

// ---- stiff ---------------------------------------------------------------------------------------------------------

/// Two masses of 0.1 kg on a spring of 1e8 N/m, 1 m long, swing from 1 mm beyond rest: 7100 Hz for 14 swings.
inline Case ring_spring() {
  System system;
  scenes::add_point({0, 0, 0}, &system);
  scenes::add_point({1.001, 0, 0}, &system);
  system.forces = {Springs{"spring", {{0, 1}}, 1e8, 0.0, 1.0}};
  const double omega = std::sqrt(2e9), t = 2e-3;
  return bounded(omega, 1e-12,
                 {"stiff", "two masses on a spring of 1e8 N/m", system, t, 1e-6,
                  miss(1, {0.5005 + 0.5 + 0.0005 * std::cos(omega * t), 0, 0}, 1e-3)});
}

/// A bead on a rod carries another one by a spring of 1e8 N/m. Both start at rest on a horizontal line.
inline Case swing_spring_pendulum() {
  System system = scenes::make_chain(2);
  std::get<Rods>(system.constraints[0]).pairs.pop_back();
  system.forces.push_back(Springs{"spring", {{1, 2}}, 1e8, 0.0, 0.1});
  return {"stiff", "pendulum with a spring of 1e8 N/m, steps of 1 ms", system, 0.2, 1e-3};
}

// ---- long and large ------------------------------------------------------------------------------------------------

inline Case swing_for_long() {
  const double t = 100.0, angle = elliptic::swing(0.5 * pi, std::sqrt(g / 0.1), t).angle;
  Case result{"long",
              "pendulum of 0.1 m, 1e6 steps of 1e-4 s",
              scenes::make_pendulum(),
              t,
              1e-4,
              miss(1, {0.1 * std::sin(angle), 0, -0.1 * std::cos(angle)}, 0.1)};
  result.methods = {Method::Rattle, Method::Taylor, Method::Dop853};
  result.patience = 5.0;
  return bounded(std::sqrt(g / 0.1), 1e-9, result);
}

inline Case drop_million() {
  Case result{"large", "chain of 1e6 rods", scenes::make_chain(1'000'000), 1e-3, 5e-4};
  result.methods = {Method::Rattle, Method::Taylor};
  result.patience = 20.0;
  return result;
}

inline std::vector<Case> list_cases() {
  std::vector<Case> cases;
  for (const double ratio : {1e3, 1e6, 1e9, 1e12}) cases.push_back(turn_heavy_tip(ratio));
  for (const double ratio : {1e3, 1e6, 1e9, 1e12}) cases.push_back(drop_heavy_tip(ratio));
  for (const double ratio : {1e3, 1e6, 1e9, 1e12}) cases.push_back(drop_alternating(ratio));
  for (const double length : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9}) cases.push_back(swing_scaled(length));
  for (const double length : {1e-9, 1e-3, 1e3, 1e9}) cases.push_back(drop_scaled_chain(length));
  for (const double distance : {1e3, 1e5, 1e7}) cases.push_back(drop_far_chain(distance));
  for (const int place : {0, 1, 2}) cases.push_back(drop_unequal(place));
  for (const double angle : {0.1, 0.5, 1.0, 1.5, 2.0, 3.0}) cases.push_back(turn_fast(angle));
  cases.push_back(pull_straight());
  cases.push_back(hold_taut());
  for (const double sag : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) cases.push_back(swing_on_flat_triangle(sag));
  cases.push_back(pass_flat_place());
  cases.push_back(start_flat());
  cases.push_back(turn_four_bar(0.5, 20.0, "four-bar, 7 flat places"));
  cases.push_back(turn_four_bars(5));
  cases.push_back(turn_four_bars(40));
  cases.push_back(drop_adjacent_net(10));
  cases.push_back(drop_adjacent_net(30));
  cases.push_back(swing_parallelogram());
  cases.push_back(drop_duplicates());
  cases.push_back(throw_diamond());
  cases.push_back(rest_free_point());
  cases.push_back(rest_chain());
  cases.push_back(rest_hanging());
  cases.push_back(ring_spring());
  cases.push_back(swing_spring_pendulum());
  cases.push_back(swing_for_long());
  cases.push_back(drop_million());
  return cases;
}

}  // namespace tanor::extreme
