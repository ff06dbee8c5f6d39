#pragma once

/// \file Random systems with coordinates of all kinds, the equivalent constraints, and a motion that is known as a
/// function of time. Every point follows a curve that was projected onto its surface.

#include <functional>
#include <random>
#include <vector>

#include <rapidcheck.h>
#include <tanor/dynamics.hpp>
#include <tanor/user_kernel.hpp>

#include "reference.hpp"

namespace tanor {

struct RandomCoordinates {
  using Number = Jet<2>;
  using Place = reference::Place;

  System system;                                        ///< coordinates and constraints; positions at t = 0
  std::function<std::vector<Place>(const Number&)> at;  ///< [point] the places as functions of time

  /// Returns the k-th derivative of all places at t, 3n.
  std::vector<double> derivative(double t, int k) const {
    std::vector<double> result;
    for (const Place& place : at(Number::variable(t))) {
      for (const Number& x : place) result.push_back(x.derivative(k));
    }
    return result;
  }
};

class RandomCoordinatesMaker {
 public:
  explicit RandomCoordinatesMaker(std::uint32_t seed, bool time_dependent = true)
      : random_(seed), time_dependent_(time_dependent) {}

  /// Adds entries of the given kinds, 0 to 8 in the order of `adders`.
  RandomCoordinates make(const std::vector<int>& kinds) {
    for (const int kind : kinds) (this->*adders[kind])();
    auto curves = curves_;
    RandomCoordinates result{std::move(system_), {}};
    result.at = [curves](const Number& t) {
      std::vector<Place> places;
      for (const auto& curve : curves) places.push_back(curve(t));
      return places;
    };
    result.system.positions = result.derivative(0.0, 0);
    result.system.velocities = result.derivative(0.0, 1);
    for (Support& support : result.system.supports) {
      const auto curve = curves[static_cast<std::size_t>(support.points[0])];
      for (std::size_t k = 0; k < 3; ++k) {
        const double first = curve(Number(0.0))[k].value();
        support.displacement.components[k] =
            ScalarFunction::custom([curve, k, first](const Number& t) { return curve(t)[k] - first; });
      }
    }
    result.system.forces.push_back(Gravity{"", {0.3, -0.2, -9.81}});
    return result;
  }

  static constexpr int num_kinds = 10;

 private:
  using Number = RandomCoordinates::Number;
  using Place = RandomCoordinates::Place;
  using Curve = std::function<Place(const Number&)>;
  using Swing = std::function<Number(const Number&)>;

  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }

  /// Returns value + amplitude sin(rate t + phase).
  Swing any_swing(double value, double amplitude) {
    const double rate = uniform(0.5, 2.5), phase = uniform(0.0, 6.0);
    return [=](const Number& t) { return value + amplitude * sin(rate * t + phase); };
  }
  /// Returns a parameter, which may swing in systems that depend on time.
  Swing any_parameter(double value, double amplitude) {
    return any_swing(value, time_dependent_ && uniform(0.0, 1.0) < 0.6 ? amplitude : 0.0);
  }
  static ScalarFunction as_function(const Swing& swing) {
    const bool moves = swing(Number::variable(0.3)).derivative(1) != 0.0;
    return moves ? ScalarFunction::custom(swing) : ScalarFunction(swing(Number(0.0)).value());
  }
  /// Returns a curve around a place in a box of the given half-width.
  Curve any_curve(double box, double amplitude) {
    const std::array<Swing, 3> x = {any_swing(uniform(-box, box), amplitude), any_swing(uniform(-box, box), amplitude),
                                    any_swing(uniform(-box, box), amplitude)};
    return [x](const Number& t) { return Place{x[0](t), x[1](t), x[2](t)}; };
  }
  Curve any_vector(double length, double amplitude) {
    std::normal_distribution<double> normal;
    double a[3], size = 0.0;
    do {
      for (double& component : a) component = normal(random_);
      size = std::hypot(a[0], a[1], a[2]);
    } while (size < 0.3);
    const std::array<Swing, 3> x = {any_parameter(length * a[0] / size, amplitude),
                                    any_parameter(length * a[1] / size, amplitude),
                                    any_parameter(length * a[2] / size, amplitude)};
    return [x](const Number& t) { return Place{x[0](t), x[1](t), x[2](t)}; };
  }
  static VectorFunction as_function(const Curve& curve) {
    VectorFunction result;
    for (std::size_t k = 0; k < 3; ++k)
      result.components[k] = as_function([curve, k](const Number& t) { return curve(t)[k]; });
    return result;
  }
  static Place unit(const Place& a) { return reference::operator*(1.0 / reference::norm(a), a); }
  /// Returns a without its part along the unit vector n.
  static Place across(const Place& a, const Place& n) {
    return reference::operator-(a, reference::operator*(reference::dot(n, a), n));
  }

  Index add_point(const Curve& curve) {
    curves_.push_back(curve);
    system_.masses.push_back(std::exp(uniform(-1.5, 1.5)));
    return static_cast<Index>(curves_.size() - 1);
  }
  /// Add the coordinates and the constraints that say the same.
  void add(Coordinates coordinates) { system_.coordinates.push_back(std::move(coordinates)); }
  void hold(Constraint constraint) { system_.constraints.push_back(std::move(constraint)); }
  std::string name(const char* kind) { return kind + std::to_string(system_.coordinates.size()); }

  // ---- kinds ----

  void add_free() {
    add(FreeCoordinates{name("free"), {add_point(any_curve(2.0, 1.0)), add_point(any_curve(2.0, 1.0))}});
  }

  void add_line() {
    const Curve origin = any_vector(1.0, 0.3), direction = any_vector(1.5, 0.4);
    const Swing s = any_swing(0.5, 1.0);
    const Index i = add_point([=](const Number& t) {
      return reference::operator+(origin(t), reference::operator*(s(t), unit(direction(t))));
    });
    add(LineCoordinates{name("line"), {i}, as_function(origin), as_function(direction)});
    hold(Lines{name("line"), {i}, as_function(origin), as_function(direction)});
  }

  void add_plane() {
    const Curve normal = any_vector(1.5, 0.4);
    const Swing offset = any_parameter(0.7, 0.3);
    const auto on_plane = [=](const Curve& p) {
      return [=](const Number& t) {
        const Place n = normal(t), u = unit(n);
        return reference::operator+(across(p(t), u), reference::operator*(offset(t) / reference::norm(n), u));
      };
    };
    const std::vector<Index> points = {add_point(on_plane(any_curve(1.0, 1.0))),
                                       add_point(on_plane(any_curve(1.0, 1.0)))};
    add(PlaneCoordinates{name("plane"), points, as_function(normal), as_function(offset)});
    hold(Planes{name("plane"), points, as_function(normal), as_function(offset)});
  }

  void add_circle() {
    const Curve center = any_vector(1.0, 0.3), normal = any_vector(1.5, 0.3);
    const Swing radius = any_parameter(0.8, 0.2), angle = any_swing(0.0, 3.0);
    // The arm is the axis that is far from the normal.
    const Place n0 = unit(normal(Number(0.7)));
    const std::size_t axis = std::abs(n0[0].value()) < 0.6 ? 0 : 1;
    const Index i = add_point([=](const Number& t) {
      const Place n = unit(normal(t));
      Place e{};
      e[axis] = 1.0;
      const Place e1 = unit(across(e, n)), e2 = reference::cross(n, e1);
      const Number a = angle(t), c = cos(a), s = sin(a);
      return reference::operator+(
          center(t), reference::operator*(
                         radius(t), reference::operator+(reference::operator*(c, e1), reference::operator*(s, e2))));
    });
    add(CircleCoordinates{name("circle"), {i}, as_function(center), as_function(normal), as_function(radius)});
    hold(Circles{name("circle"), {i}, as_function(center), as_function(normal), as_function(radius)});
  }

  void add_sphere() {
    const Curve center = any_vector(1.0, 0.3), way = any_vector(2.0, 0.0), swing = any_curve(0.0, 0.6);
    const Swing radius = any_parameter(1.1, 0.2);
    const Index i = add_point([=](const Number& t) {
      const Place u = unit(reference::operator+(way(t), swing(t)));
      return reference::operator+(center(t), reference::operator*(radius(t), u));
    });
    add(SphereCoordinates{name("sphere"), {i}, as_function(center), as_function(radius)});
    hold(Spheres{name("sphere"), {i}, as_function(center), as_function(radius)});
  }

  Index add_support() {
    const Index anchor = add_point(any_vector(1.0, time_dependent_ ? 0.4 : 0.0));
    system_.supports.push_back({"", {anchor}, {}});
    return anchor;
  }

  void add_chain(const Place* normal) {
    const Index anchor = add_support();
    ChainAngles chain{name("chain"), {}, anchor, {}, {}};
    Rods rods{name("rods"), {}, {}, {}};
    Curve before = curves_[static_cast<std::size_t>(anchor)];
    const Curve start = before;
    const Place n = normal != nullptr ? *normal : Place{};
    const bool is_planar = normal != nullptr;
    for (int link = 0; link < 4; ++link) {
      const Curve way = any_vector(2.0, 0.0), swing = any_curve(0.0, 0.6);
      const Swing length = any_parameter(0.7, 0.1);
      const Curve place = [=](const Number& t) {
        // The main part is longer than the part that swings, so that the direction does not reverse in an instant.
        const Place main = is_planar ? reference::operator*(2.0, unit(across(way(t), n))) : way(t);
        Place direction = reference::operator+(main, swing(t));
        if (is_planar) direction = across(direction, n);
        return reference::operator+(before(t), reference::operator*(length(t), unit(direction)));
      };
      const Index i = add_point(place);
      rods.pairs.push_back({chain.points.empty() ? anchor : chain.points.back(), i});
      chain.points.push_back(i);
      chain.length.functions.push_back(as_function(length));
      before = place;
    }
    rods.length = chain.length;
    if (is_planar) {
      for (std::size_t k = 0; k < 3; ++k) chain.normal[k] = 2.0 * n[k].value();
      const Swing height = [start, n](const Number& t) { return reference::dot(n, start(t)); };
      hold(Planes{name("sheet"), chain.points, Vector3{n[0].value(), n[1].value(), n[2].value()}, as_function(height)});
    }
    hold(std::move(rods));
    add(std::move(chain));
  }
  void add_chain_in_space() { add_chain(nullptr); }
  void add_chain_in_plane() {
    const Place n = unit(any_vector(1.0, 0.0)(Number(0.0)));
    add_chain(&n);
  }

  void add_body() {
    const Curve center = any_curve(1.0, 1.0);
    const Swing a = any_swing(0.0, 2.0), b = any_swing(0.0, 2.0);
    RigidBody body{name("body"), {}};
    for (int p = 0; p < 6; ++p) {
      // The corners of an octahedron are moved a little, so that no three of them lie nearly on one line.
      Place rho{};
      rho[static_cast<std::size_t>(p / 2)] = p % 2 == 0 ? 0.6 : -0.5;
      for (Number& x : rho) x += uniform(-0.1, 0.1);
      body.points.push_back(add_point([=](const Number& t) {
        const Number c1 = cos(a(t)), s1 = sin(a(t)), c2 = cos(b(t)), s2 = sin(b(t));
        const Place once = {c1 * rho[0] - s1 * rho[1], s1 * rho[0] + c1 * rho[1], rho[2]};
        return reference::operator+
            (center(t), Place{once[0], c2 * once[1] - s2 * once[2], s2 * once[1] + c2 * once[2]});
      }));
    }
    Rods rods{name("frame"), {}, {}, {}};
    const auto& i = body.points;
    rods.pairs = {{i[0], i[2]}, {i[0], i[4]}, {i[2], i[4]}};
    for (const std::size_t p : {1u, 3u, 5u}) {
      // These corners are joined to corners that are not opposite to them.
      const std::size_t used[3] = {p == 1 ? 2u : 0u, p == 5 ? 2u : 4u, p == 1 ? 4u : p == 3 ? 1u : 3u};
      for (std::size_t k = 0; k < (p == 1 ? 2u : 3u); ++k) rods.pairs.push_back({i[p], i[used[k]]});
    }
    rods.pairs.push_back({i[1], i[0]});
    hold(std::move(rods));
    add(std::move(body));
  }

  /// Adds angles around a moving place, on a radius that changes with time.
  void add_user_direction() {
    const Swing radius = any_parameter(0.9, 0.2), a = any_swing(1.5, 0.8), b = any_swing(0.0, 2.0);
    const double rate = time_dependent_ ? 1.3 : 0.0;
    const auto map = [=](const auto& q, const auto& t) {
      using T = std::decay_t<decltype(t)>;
      const T r = 0.9 + 0.2 * sin(rate * t);
      return std::array<T, 3>{0.3 * sin(rate * t) + r * sin(q[0]) * cos(q[1]), r * sin(q[0]) * sin(q[1]),
                              r * cos(q[0])};
    };
    const Index i = add_point([=](const Number& t) { return map(std::array<Number, 2>{a(t), b(t)}, t); });
    add(UserCoordinates{name("angles"), {{i}}, make_coordinate_kernel<1, 2>(map), start({a, b}, 0), start({a, b}, 1)});
    const Curve center = [=](const Number& t) { return Place{0.3 * sin(rate * t), 0.0, 0.0}; };
    hold(Spheres{name("ball"), {i}, as_function(center), as_function([=](const Number& t) {
                   return 0.9 + 0.2 * sin(rate * t);
                 })});
  }

  /// Adds two points on a rod, by the place of the first one and two angles.
  void add_user_dumbbell() {
    const std::vector<Swing> q = {any_swing(0.0, 1.0), any_swing(1.0, 1.0), any_swing(-1.0, 1.0), any_swing(1.5, 0.8),
                                  any_swing(0.0, 2.0)};
    const double rate = time_dependent_ ? 1.7 : 0.0;
    const auto map = [=](const auto& x, const auto& t) {
      using T = std::decay_t<decltype(t)>;
      const T l = 0.7 + 0.1 * cos(rate * t);
      return std::array<T, 6>{
          x[0], x[1], x[2], x[0] + l * sin(x[3]) * cos(x[4]), x[1] + l * sin(x[3]) * sin(x[4]), x[2] + l * cos(x[3])};
    };
    std::array<Index, 2> pair;
    for (std::size_t p = 0; p < 2; ++p) {
      pair[p] = add_point([=](const Number& t) {
        std::array<Number, 5> x;
        for (std::size_t j = 0; j < 5; ++j) x[j] = q[j](t);
        const auto r = map(x, t);
        return Place{r[3 * p], r[3 * p + 1], r[3 * p + 2]};
      });
    }
    add(UserCoordinates{
        name("dumbbell"), {{pair[0], pair[1]}}, make_coordinate_kernel<2, 5>(map), start(q, 0), start(q, 1)});
    hold(Rods{name("bar"), {pair}, as_function([=](const Number& t) { return 0.7 + 0.1 * cos(rate * t); }), {}});
  }

  static std::vector<double> start(const std::vector<Swing>& q, int k) {
    std::vector<double> result;
    for (const Swing& swing : q) result.push_back(swing(Number::variable(0.0)).derivative(k));
    return result;
  }

  using Add = void (RandomCoordinatesMaker::*)();
  static constexpr Add adders[num_kinds] = {
      &RandomCoordinatesMaker::add_free,           &RandomCoordinatesMaker::add_line,
      &RandomCoordinatesMaker::add_plane,          &RandomCoordinatesMaker::add_circle,
      &RandomCoordinatesMaker::add_sphere,         &RandomCoordinatesMaker::add_chain_in_space,
      &RandomCoordinatesMaker::add_chain_in_plane, &RandomCoordinatesMaker::add_body,
      &RandomCoordinatesMaker::add_user_direction, &RandomCoordinatesMaker::add_user_dumbbell};

  std::mt19937 random_;
  const bool time_dependent_;
  System system_;
  std::vector<Curve> curves_;
};

/// Draws up to 5 entries of any kinds inside a RapidCheck property.
inline RandomCoordinates any_coordinates() {
  // The range of a number grows with the size. It is full here, while lists stay short.
  const auto kind = rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, RandomCoordinatesMaker::num_kinds));
  const auto kinds = *rc::gen::resize(5, rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(kind))).as("kinds");
  const auto seed = *rc::gen::noShrink(rc::gen::arbitrary<std::uint32_t>()).as("seed");
  return RandomCoordinatesMaker(seed).make(kinds);
}

}  // namespace tanor
