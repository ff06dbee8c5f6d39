#pragma once

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>
#include <tanor/user_kernel.hpp>

/// Andrews' squeezing mechanism has seven plane bodies, is driven by a moment, and has one degree of freedom (Hairer &
/// Wanner II, VII.7; Test Set for IVP Solvers). Lengths are in m and angles in rad.
///
/// Each body stands as two material points. The point a is at a joint, and the point c lies behind the centre of mass
/// g, at the distance I/(m |g - a|) from it. With masses m |c - g|/|c - a| and m |a - g|/|c - a| they have the body's
/// mass, its centre and its moment of inertia, since sum mu d = 0 and sum mu d^2 = m |g - a| |c - g| = I. Every place
/// of the body is an affine combination x = a + alpha (c - a) + beta perp(c - a) of its two points.
namespace tanor::andrews {

using Angles = std::array<double, 7>;  // beta, Theta, gamma, Phi, delta, Omega, epsilon

struct Place {
  double x, y;

  friend Place operator+(Place a, Place b) { return {a.x + b.x, a.y + b.y}; }
  friend Place operator-(Place a, Place b) { return {a.x - b.x, a.y - b.y}; }
  friend Place operator*(double s, Place a) { return {s * a.x, s * a.y}; }
  friend double dot(Place a, Place b) { return a.x * b.x + a.y * b.y; }
};
inline Place perp(Place a) {
  return {-a.y, a.x};
}
inline Place along(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

constexpr Place a_pin{-0.06934, -0.00227}, b_pin{-0.03635, 0.03273}, c_pin{0.014, 0.072};
constexpr double moment = 0.033, spring_stiffness = 4530.0, spring_rest = 0.07785;
constexpr Angles start{-0.0617138900142764496358948458001, 0.0,
                       0.455279819163070380255912382449,   0.222668390165885884674473185609,
                       0.487364979543842550225598953530,   -0.222668390165885884674473185609,
                       1.23054744454982119249735015568};
/// The angles at t = 0.03 s, as the test set publishes them.
constexpr double end_time = 0.03;
constexpr Angles end{15.81077119629904,  -15.75637105984298, 0.04082224013073101, -0.5347301163226948,
                     0.5244099658805304, 0.5347301163226948, 1.048080741042263};

/// The joints and the fixed end of the spring at these angles.
struct Joints {
  Place crank, f, g, h, spring;

  explicit Joints(const Angles& q) {
    const auto [beta, theta, gamma, phi, delta, omega, epsilon] = q;
    crank = 0.007 * along(beta);
    f = crank - 0.028 * along(beta + theta);
    g = a_pin + 0.04 * along(delta);
    h = a_pin - 0.04 * perp(along(epsilon));
    spring = b_pin + 0.02 * along(gamma) - 0.018 * perp(along(gamma));
  }
};

struct Body {
  double mass, inertia;  // kg, kg m^2
  Place joint, centre;   // m

  Place opposite() const {
    const Place arm = centre - joint;
    return centre + (inertia / (mass * dot(arm, arm))) * arm;
  }
  double mass_at_joint() const {
    const Place arm = centre - joint;
    return mass * inertia / (mass * dot(arm, arm) + inertia);
  }
};

/// Returns the masses, moments of inertia and centres of the test set.
inline std::array<Body, 7> bodies(const Angles& q) {
  const auto [beta, theta, gamma, phi, delta, omega, epsilon] = q;
  const Joints at(q);
  const Place k3 = along(gamma), k5 = along(delta), k7 = along(epsilon);
  return {{{0.04325, 2.194e-6, at.crank, 0.00092 * along(beta)},
           {0.00365, 4.410e-7, at.f, at.crank - 0.0115 * along(beta + theta)},
           {0.02373, 5.255e-6, at.f, b_pin + 0.01043 * k3 - 0.01874 * perp(k3)},
           {0.00706, 5.667e-7, at.g, at.g - 0.00579 * perp(along(phi + delta))},
           {0.07050, 1.169e-5, at.g, a_pin + 0.02308 * k5 + 0.00916 * perp(k5)},
           {0.00706, 5.667e-7, at.h, at.h + 0.00579 * along(omega + epsilon)},
           {0.05498, 1.912e-5, at.h, a_pin - 0.01228 * perp(k7) - 0.00449 * k7}}};
}

/// Returns the places of the 14 points, body by body, first the joint and then the opposite point.
inline std::vector<double> positions(const Angles& q) {
  std::vector<double> r;
  for (const Body& body : bodies(q))
    for (const Place& at : {body.joint, body.opposite()}) r.insert(r.end(), {at.x, at.y, 0.0});
  return r;
}

/// The coefficients alpha and beta of a place, by the first and the second point of its body.
struct Combination {
  double alpha, beta;

  Combination(Place first, Place second, Place of) {
    const Place arm = second - first;
    alpha = dot(of - first, arm) / dot(arm, arm);
    beta = dot(of - first, perp(arm)) / dot(arm, arm);
  }
};

/// Adds two equations that make a place of one body the same as a place of another body, or fix a place of one body. A
/// point that takes no part in them is left out (the place is then the other point of the body).
inline void join(System* system, const std::vector<Index>& bodies, const std::vector<Combination>& combinations,
                 Place value) {
  std::vector<Vector3> by_x, by_y;
  std::vector<Index> points;
  const auto add = [&](Index point, double x, double y) {
    if (x == 0.0 && y == 0.0) return;
    points.push_back(point);
    by_x.push_back({x, -y, 0.0});
    by_y.push_back({y, x, 0.0});
  };
  double sign = 1.0;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    const auto [alpha, beta] = combinations[k];
    add(2 * bodies[k], sign * (1.0 - alpha), -sign * beta);
    add(2 * bodies[k] + 1, sign * alpha, sign * beta);
    sign = -1.0;
  }
  system->constraints.emplace_back(Linears{"", {points}, by_x, value.x});
  system->constraints.emplace_back(Linears{"", {points}, by_y, value.y});
}

/// Returns the energy of the spring from c_pin to a place of the body whose points are 1 and 2.
inline PotentialKernel spring(const Combination& at) {
  return formula_potential(
      "k/2*(sqrt((x1 + a*(x2 - x1) - b*(y2 - y1) - cx)^2 + (y1 + a*(y2 - y1) + b*(x2 - x1) - cy)^2) - l)^2", 2,
      {{"k", spring_stiffness}, {"l", spring_rest}, {"a", at.alpha}, {"b", at.beta}, {"cx", c_pin.x}, {"cy", c_pin.y}});
}
/// Returns a moment on the body whose points are 1 and 2, as a couple of forces.
inline ForceKernel couple() {
  const std::string factor = "m/((x2 - x1)^2 + (y2 - y1)^2)";
  return formula_tuple_force(std::vector<std::string>{"(y2 - y1)*" + factor, "(x1 - x2)*" + factor, "0",
                                                      "(y1 - y2)*" + factor, "(x2 - x1)*" + factor, "0"},
                             {{"m", moment}});
}

/// Returns the masses, the forces and the start, without constraints.
inline System make_points() {
  System system;
  system.name = "andrews";
  const auto all = bodies(start);
  system.positions = positions(start);
  system.velocities.assign(system.positions.size(), 0.0);
  for (const Body& body : all) {
    const double at_joint = body.mass_at_joint();
    system.masses.insert(system.masses.end(), {at_joint, body.mass - at_joint});
  }
  const Body& third = all[2];
  system.forces = {Potential{"spring", {{4, 5}}, spring({third.joint, third.opposite(), Joints(start).spring}), {}},
                   FormulaForce{.name = "drive", .points = {}, .kernel = couple(), .tuples = {{0, 1}}}};
  return system;
}

/// Returns 14 points and 41 equations, which are planes, a rod in each body, and joints.
inline System make_system() {
  System system = make_points();
  const auto all = bodies(start);
  std::vector<Index> points(14);
  for (Index i = 0; i < 14; ++i) points[static_cast<std::size_t>(i)] = i;
  Rods rods{"bodies", {}};
  for (Index k = 0; k < 7; ++k) rods.pairs.push_back({2 * k, 2 * k + 1});
  system.constraints = {Planes{"plane", points, Vector3{0, 0, 1}, 0.0}, rods};
  const Joints at(start);
  const auto combination = [&](std::size_t body, Place of) {
    return Combination(all[body].joint, all[body].opposite(), of);
  };
  const auto join_bodies = [&](Index a, Index b, Place of) {
    join(&system, {a, b}, {combination(static_cast<std::size_t>(a), of), combination(static_cast<std::size_t>(b), of)},
         {0.0, 0.0});
  };
  const auto pin = [&](Index body, Place to) {
    join(&system, {body}, {combination(static_cast<std::size_t>(body), to)}, to);
  };
  pin(0, {0.0, 0.0});
  join_bodies(0, 1, at.crank);
  for (const Index other : {2, 3, 5}) join_bodies(1, other, at.f);
  pin(2, b_pin);
  join_bodies(3, 4, at.g);
  pin(4, a_pin);
  join_bodies(5, 6, at.h);
  pin(6, a_pin);
  return system;
}

/// Returns the same bodies with fewer points. The joints are points that bodies share, so that each body adds only its
/// opposite point. There are 11 points (4 joints and 7 opposite points), the pins as 3 supports, and 21 equations.
/// There are no planes, since nothing pushes the points out of their plane. Points 0 to 3 are crank, f, g, h, points 4
/// to 10 are the opposite points, and points 11 to 13 are the pins o, a, b.
inline System make_joint_system() {
  enum : Index { crank, f, g, h, opposite, o = 11, a, b };
  const auto all = bodies(start);
  const Joints at(start);
  const std::array<Index, 7> joint{crank, f, f, g, g, h, h}, other{o, crank, b, f, a, f, a};
  std::vector<Place> places{at.crank, at.f, at.g, at.h};
  System system;
  system.name = "andrews";
  system.masses.assign(14, 0.0);
  for (std::size_t k = 0; k < 7; ++k) {
    const double at_joint = all[k].mass_at_joint();
    system.masses[static_cast<std::size_t>(joint[k])] += at_joint;
    system.masses[4 + k] = all[k].mass - at_joint;
    places.push_back(all[k].opposite());
  }
  places.insert(places.end(), {{0.0, 0.0}, a_pin, b_pin});
  for (const Place& place : places) system.positions.insert(system.positions.end(), {place.x, place.y, 0.0});
  system.velocities.assign(system.positions.size(), 0.0);
  system.supports = {Support{"", {o, a, b}}};
  Rods rods{"bodies", {}};
  for (std::size_t k = 0; k < 7; ++k) rods.pairs.push_back({joint[k], other[k]});
  system.constraints = {rods};
  for (std::size_t k = 0; k < 7; ++k) {
    const Place first = places[static_cast<std::size_t>(joint[k])], second = places[static_cast<std::size_t>(other[k])];
    const auto [alpha, beta] = Combination(first, second, all[k].opposite());
    const std::vector<Index> points{joint[k], other[k], opposite + static_cast<Index>(k)};
    system.constraints.emplace_back(
        Linears{"", {points}, {{1.0 - alpha, beta, 0.0}, {alpha, -beta, 0.0}, {-1.0, 0.0, 0.0}}, 0.0});
    system.constraints.emplace_back(
        Linears{"", {points}, {{-beta, 1.0 - alpha, 0.0}, {beta, alpha, 0.0}, {0.0, -1.0, 0.0}}, 0.0});
  }
  // The spring's end is (1 - alpha) f + alpha b + beta perp(b - f), of which only f moves. In the same way the drive
  // acts only on the crank's outer end.
  const auto [alpha, beta] = Combination(at.f, b_pin, at.spring);
  const Place rest = alpha * b_pin + beta * perp(b_pin) - c_pin;
  system.forces = {
      Potential{"spring",
                {{f}},
                formula_potential("k/2*(sqrt((a*x1 + b*y1 + cx)^2 + (a*y1 - b*x1 + cy)^2) - l)^2", 1,
                                  {{"k", spring_stiffness},
                                   {"l", spring_rest},
                                   {"a", 1.0 - alpha},
                                   {"b", beta},
                                   {"cx", rest.x},
                                   {"cy", rest.y}}),
                {}},
      FormulaForce{"drive", {crank}, formula_force({"-m*y/(x^2 + y^2)", "m*x/(x^2 + y^2)", "0"}, {{"m", moment}})}};
  return system;
}

/// Returns the intersection of circles about a and b that lies to the left (side 1) or to the right (side -1) of the
/// line from a to b.
template <class T>
std::array<T, 2> intersect(const std::array<T, 2>& a, double ra, const std::array<T, 2>& b, double rb, double side) {
  using std::sqrt;
  const T dx = b[0] - a[0], dy = b[1] - a[1], d2 = dx * dx + dy * dy;
  const T s = 0.5 + (ra * ra - rb * rb) / (2.0 * d2), h = side * sqrt(ra * ra / d2 - s * s);
  return {a[0] + s * dx - h * dy, a[1] + s * dy + h * dx};
}

/// Returns all 14 points as functions of the angle of the crank.
inline UserCoordinates make_coordinates() {
  const auto all = bodies(start);
  const Joints at(start);
  // Two joints determine each body: (crank, pin), (f, crank), (f, pin b), (g, f), (g, pin a), (h, f), (h, pin a).
  const Place origin{0.0, 0.0};
  const std::array<Place, 7> other{origin, at.crank, b_pin, at.f, a_pin, at.f, a_pin};
  std::vector<Combination> opposite;
  for (std::size_t k = 0; k < 7; ++k) opposite.emplace_back(all[k].joint, other[k], all[k].opposite());
  const auto map = [opposite](const auto& q, const auto&) {
    using std::cos, std::sin;
    using T = std::decay_t<decltype(q[0])>;
    using Point = std::array<T, 2>;
    const auto fixed = [](Place p) { return Point{T(p.x), T(p.y)}; };
    const Point zero = fixed({0.0, 0.0}), crank{0.007 * cos(q[0]), 0.007 * sin(q[0])};
    const Point f = intersect(crank, 0.028, fixed(b_pin), 0.035, 1.0);
    const Point g = intersect(fixed(a_pin), 0.04, f, 0.02, 1.0), h = intersect(fixed(a_pin), 0.04, f, 0.02, -1.0);
    const std::array<Point, 7> first{crank, f, f, g, g, h, h},
        second{zero, crank, fixed(b_pin), f, fixed(a_pin), f, fixed(a_pin)};
    std::array<T, 42> r;
    for (std::size_t k = 0; k < 7; ++k) {
      const T dx = second[k][0] - first[k][0], dy = second[k][1] - first[k][1];
      const auto [alpha, beta] = opposite[k];
      r[6 * k] = first[k][0];
      r[6 * k + 1] = first[k][1];
      r[6 * k + 3] = first[k][0] + alpha * dx - beta * dy;
      r[6 * k + 4] = first[k][1] + alpha * dy + beta * dx;
      r[6 * k + 2] = r[6 * k + 5] = T(0.0);
    }
    return r;
  };
  std::vector<Index> points(14);
  for (Index i = 0; i < 14; ++i) points[static_cast<std::size_t>(i)] = i;
  return UserCoordinates{"crank", {points}, make_coordinate_kernel<14, 1>(map), {start[0]}, {0.0}};
}

}  // namespace tanor::andrews
