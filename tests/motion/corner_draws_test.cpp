/// \file Random guides with corners, against a dense program that integrates rounded ones.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "methods.hpp"
#include "motion/corner_program.hpp"

namespace tanor {
namespace {

using namespace corner_program;

/// A system and the same for the dense program.
struct Draw {
  System system;
  DenseMotion motion;
  std::string text;
};

std::string text_of(double x) {
  char buffer[40];
  (void)std::snprintf(buffer, sizeof(buffer), "(%.17g)", x);
  return buffer;
}
std::string text_of(const Vector3d& a) {
  return "(" + text_of(a[0]) + "*x1+" + text_of(a[1]) + "*y1+" + text_of(a[2]) + "*z1)";
}

class Drawer {
 public:
  explicit Drawer(unsigned seed) : random_(seed) {}

  Draw draw() {
    Draw result;
    const auto kind = whole(6);
    const auto beads = kind == 5 ? 1 : kind == 4 ? 2 : whole(2) + (kind == 3 ? 2 : 1);
    DenseMotion& motion = result.motion;
    motion.r = Vector::Zero(3 * beads);
    motion.v = Vector::Zero(3 * beads);
    motion.masses = Vector::Zero(3 * beads);
    for (Eigen::Index i = 0; i < beads; ++i) {
      motion.masses.segment<3>(3 * i).setConstant(number(0.3, 2.0));
      motion.r.segment<3>(3 * i) = Vector3d(0.7 * static_cast<double>(i), 0.0, 0.0) + 0.3 * vector();
    }
    // The first bead is on a surface or on a wire with corners, the second one of kind 3 as well. Kind 5 is a wire in
    // coordinates.
    if (kind != 4) add_guide(0, kind == 0 || kind == 2 || kind == 5, &result);
    if (kind == 3) add_guide(1, whole(2) == 0, &result);
    if (kind == 4) add_plane(&result);
    for (Eigen::Index i = 1; i < beads; ++i) join(i - 1, i, kind, &result);
    start(&result);
    if (kind == 5) take_coordinates(&result);
    return result;
  }

 private:
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int whole(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  Vector3d vector() { return {number(-1.0, 1.0), number(-1.0, 1.0), number(-1.0, 1.0)}; }

  /// Writes |u| in one of its ways.
  std::string absolute(const std::string& u) {
    switch (whole(9)) {
      case 0:
        return "abs(" + u + ")";
      case 1:
        return "max(" + u + ",-(" + u + "))";
      case 2:
        return "(-min(" + u + ",-(" + u + ")))";
      case 3:
        return "sqrt((" + u + ")*(" + u + "))";
      case 4:
        return "(4*(" + u + ")^2)^0.5/2";
      case 5:
        return "sqrt(sqrt((" + u + ")^4))";
      case 6:
        return "(" + u + ")*sin(atan2(" + u + ",0))";
      case 7:
        return "exp(0.5*log((" + u + ")^2))";
      default:
        return "sqrt((" + u + ")^2)";
    }
  }

  void add_guide(Eigen::Index bead, bool is_wire, Draw* to) {
    const Vector3d up = (Vector3d(0.0, 0.0, 1.0) + 0.5 * vector()).normalized();
    Vector3d along = vector();
    along = (along - along.dot(up) * up).normalized();
    const Vector3d across = up.cross(along);
    const Vector3d place = to->motion.r.segment<3>(3 * bead);
    Guide guide{bead, up, 0.0, {}};
    std::string equation = text_of(up);
    const int count = 1 + whole(2);
    for (int k = 0; k < count; ++k) {
      Vector3d a = along + (is_wire ? Vector3d(Vector3d::Zero()) : Vector3d(0.3 * number(-1.0, 1.0) * across));
      Kink kink{(whole(2) == 0 ? 1.0 : -1.0) * number(0.1, 1.5), a,
                a.dot(place) + number(0.05, 0.4) * (k == 0 ? -1 : 1)};
      equation += "-" + text_of(kink.weight) + "*" + absolute(text_of(a) + "-" + text_of(kink.b));
      guide.kinks.push_back(kink);
    }
    guide.shift = up.dot(place);
    for (const Kink& kink : guide.kinks) guide.shift -= kink.weight * std::abs(kink.a.dot(place) - kink.b);
    equation += "-" + text_of(guide.shift);
    to->motion.guides.push_back(guide);
    to->system.constraints.emplace_back(UserConstraints{.name = "guide" + std::to_string(bead),
                                                        .tuples = {{static_cast<Index>(bead)}},
                                                        .kernel = formula_constraint(equation, 1)});
    to->text += equation + "\n";
    if (!is_wire) return;
    to->motion.guides.push_back({bead, across, across.dot(place), {}});
    to->system.constraints.emplace_back(Planes{.name = "sheet" + std::to_string(bead),
                                               .points = {static_cast<Index>(bead)},
                                               .normal = Vector3{across[0], across[1], across[2]},
                                               .offset = across.dot(place)});
  }

  /// Describes the wire by the coordinate q along it instead, r = q along + (across'r) across + (shift + w |q - b|) up.
  void take_coordinates(Draw* to) {
    const Guide &wire = to->motion.guides[0], &sheet = to->motion.guides[1];
    const Vector3d along = wire.kinks[0].a, fixed = sheet.shift * sheet.n;
    std::string height = text_of(wire.shift);
    for (const Kink& kink : wire.kinks) height += "+" + text_of(kink.weight) + "*" + absolute("q-" + text_of(kink.b));
    std::vector<std::string> places;
    for (Eigen::Index c = 0; c < 3; ++c)
      places.push_back(text_of(along[c]) + "*q+" + text_of(fixed[c]) + "+" + text_of(wire.n[c]) + "*(" + height + ")");
    to->system.constraints.clear();
    to->system.coordinates = {UserCoordinates{.name = "wire",
                                              .tuples = {{0}},
                                              .kernel = formula_coordinates(std::vector<std::string>{"q"}, places),
                                              .q = {along.dot(to->motion.r)},
                                              .q_dot = {along.dot(to->motion.v)}}};
    to->text = height;
  }

  /// Adds a plane whose offset has a corner in time.
  void add_plane(Draw* to) {
    const Vector3d n = vector().normalized(), place = to->motion.r.segment<3>(0);
    const Kink kink{number(-0.8, 0.8), Vector3d::Zero(), number(0.1, 0.5)};
    const double shift = n.dot(place) - kink.weight * kink.b;
    to->motion.guides.push_back({0, n, shift, {kink}});
    to->system.constraints.emplace_back(
        Planes{.name = "plane",
               .points = {0},
               .normal = Vector3{n[0], n[1], n[2]},
               .offset = ScalarFunction::formula(text_of(shift) + "+" + text_of(kink.weight) + "*" +
                                                 absolute("t-" + text_of(kink.b)))});
  }

  void join(Eigen::Index i, Eigen::Index j, int kind, Draw* to) {
    const double length = (to->motion.r.segment<3>(3 * j) - to->motion.r.segment<3>(3 * i)).norm();
    const auto first = static_cast<Index>(i), second = static_cast<Index>(j);
    if (kind != 4 && whole(3) == 0) {
      const double stiffness = number(5.0, 40.0);
      to->motion.springs.push_back({i, j, stiffness, length});
      to->system.forces.emplace_back(Springs{.name = "spring" + std::to_string(j),
                                             .pairs = {{first, second}},
                                             .stiffness = stiffness,
                                             .rest_length = length});
      return;
    }
    Rod rod{i, j, length, {}};
    Rods rods{.name = "rod" + std::to_string(j), .pairs = {{first, second}}, .length = length, .offsets = {}};
    if (whole(3) == 0) {
      const Kink kink{number(-0.3, 0.3), Vector3d::Zero(), number(0.1, 0.5)};
      rod.length -= kink.weight * kink.b;
      rod.kinks = {kink};
      rods.length = ScalarFunction::formula(text_of(rod.length) + "+" + text_of(kink.weight) + "*" +
                                            absolute("t-" + text_of(kink.b)));
    }
    to->motion.rods.push_back(rod);
    to->system.constraints.emplace_back(rods);
  }

  /// Sets a consistent start with random velocities.
  void start(Draw* to) {
    DenseMotion& motion = to->motion;
    for (Eigen::Index i = 0; i < motion.v.size(); ++i) motion.v[i] = number(-1.5, 1.5);
    motion.advance(0.0, 1e-3);
    System& system = to->system;
    system.positions.assign(motion.r.data(), motion.r.data() + motion.r.size());
    system.velocities.assign(motion.v.data(), motion.v.data() + motion.v.size());
    for (Eigen::Index i = 0; i < motion.masses.size(); i += 3) system.masses.push_back(motion.masses[i]);
    system.forces.emplace_back(Gravity{"", {0.0, 0.0, -10.0}});
  }

  std::mt19937 random_;
};

constexpr unsigned num_draws = 300;

/// Returns how far a simulation is from the dense program with steps of that length, over the size of the scene.
double distance(const Simulation& simulation, DenseMotion motion, double step, std::size_t* corners) {
  motion.advance(simulation.time(), step);
  *corners = motion.corners;
  double size = 1.0, most = 0.0;
  for (Eigen::Index i = 0; i < motion.r.size(); ++i) {
    size = std::max(size, std::abs(motion.r[i]));
    most = std::max(most, std::abs(simulation.positions()[static_cast<std::size_t>(i)] - motion.r[i]));
  }
  return most / size;
}

/// Compares a draw by one of the methods. Returns false if the motion is refused by name.
bool compare(unsigned seed, std::size_t* corners) {
  static const std::vector<Method> methods = with_auto(list_adaptive_methods());
  constexpr double end = 0.6, same = 1e-8;
  static const std::vector<Method> in_coordinates{Method::Auto, Method::Dop853, Method::Dopri5};
  const Draw draw = Drawer(seed).draw();
  const std::vector<Method>& known = draw.system.coordinates.empty() ? methods : in_coordinates;
  const Method method = known[seed % known.size()];
  Simulation simulation(draw.system, {.method = method, .rtol = 1e-12, .atol = 1e-12});
  const Outcome outcome = simulation.advance_to(end);
  if (!outcome.ok()) {
    EXPECT_NE(outcome.what.find("corner"), std::string::npos) << seed << ": " << outcome.what;
    return false;
  }
  // Steps of 1/200 s are enough for most draws.
  std::size_t own = 0;
  double missed = distance(simulation, draw.motion, 1.0 / 200.0, &own);
  if (missed > same) missed = distance(simulation, draw.motion, 1.0 / 1600.0, &own);
  EXPECT_LT(missed, same) << seed << ", " << name_of(method) << ", corners " << own << "\n" << draw.text;
  EXPECT_TRUE(simulation.certify().passed()) << seed << ": " << simulation.certify().line();
  *corners += own;
  return true;
}

TEST(CornerDraws, AgreeWithADenseProgramOfRoundedCorners) {
  std::size_t corners = 0, refused = 0;
  for (unsigned seed = 0; seed < num_draws; ++seed) refused += compare(seed, &corners) ? 0 : 1;
  EXPECT_GT(corners, num_draws);
  EXPECT_LT(refused, num_draws / 50);
}

}  // namespace
}  // namespace tanor
