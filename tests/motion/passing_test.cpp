/// Steps must not jump what lies between two evaluations: beads that meet and part, wells that are narrow. Random ones,
/// against closed forms and against runs that cannot jump. TANOR_DRAWS: how many are drawn of each kind.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using scenes::add_point;

int num_draws(int usual) {
  const char* const wanted = std::getenv("TANOR_DRAWS");
  return wanted != nullptr ? std::max(std::atoi(wanted), 1) : usual;
}

class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double uniform(double a, double b) { return a + (b - a) * std::generate_canonical<double, 53>(generator_); }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  int below(int count) { return static_cast<int>(uniform(0.0, count)); }
  Vector3 direction() {
    for (;;) {
      const Vector3 d{uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
      const double length = std::hypot(d[0], d[1], d[2]);
      if (length > 0.1 && length < 1.0) return {d[0] / length, d[1] / length, d[2] / length};
    }
  }

 private:
  std::mt19937_64 generator_;
};

std::string number(double x) {
  std::array<char, 40> buffer;
  std::snprintf(buffer.data(), buffer.size(), "(%.17g)", x);
  return buffer.data();
}

/// What one run says; the worst error over what the tolerance allows, in positions and velocities.
struct Verdict {
  std::string told{};  // an outcome that is not ok, or a warning
  double error = 0.0;
  std::size_t steps = 0;
};

constexpr double rtol = 1e-8, atol = 1e-10;

double over_tolerance(std::span<const double> found, std::span<const double> right) {
  double worst = 0.0;
  for (std::size_t i = 0; i < found.size(); i += 3) {
    const double size = std::hypot(right[i], right[i + 1], right[i + 2]);
    for (std::size_t k = i; k < i + 3; ++k) worst = larger(worst, std::abs(found[k] - right[k]) / (atol + rtol * size));
  }
  return worst;
}

struct State {
  std::vector<double> r, v;
};

State state_of(const Simulation& simulation) {
  return {{simulation.positions().begin(), simulation.positions().end()},
          {simulation.velocities().begin(), simulation.velocities().end()}};
}

/// The error in units of rtol and atol, with `part` of them.
Verdict compare(const System& system, Method method, double t_end, const State& right, double part = 1.0) {
  Simulation simulation(system, {.method = method, .rtol = part * rtol, .atol = part * atol}, {.threads = 1});
  const Outcome outcome = simulation.advance_to(t_end);
  return {outcome.what + simulation.report().accuracy_warning,
          std::max(over_tolerance(simulation.positions(), right.r), over_tolerance(simulation.velocities(), right.v)),
          simulation.report().steps};
}

/// How many of the runs were wrong and silent, or told that they were.
struct Tally {
  int runs = 0, wrong = 0, told = 0;

  void add(const Verdict& verdict, double allowed, const std::string& what) {
    ++runs;
    if (!verdict.told.empty()) {
      ++told;
      std::printf("told: %s: %s\n", what.c_str(), verdict.told.c_str());
    } else if (!(verdict.error <= allowed)) {
      ++wrong;
      ADD_FAILURE() << what << ": off by " << verdict.error << " tolerances, " << allowed << " are allowed";
    }
  }
  void expect_good() const {
    EXPECT_EQ(wrong, 0) << "of " << runs;
    EXPECT_LE(told, runs / 100) << "of " << runs;
  }
};

// ---- wells
// -----------------------------------------------------------------------------------------------------------

/// t = integral of slowness ds from 0: the inverse, by Gauss's quadrature on cells that are fine around `centre`.
double distance_after(double time, const std::function<double(double)>& slowness, double far, double centre,
                      double width) {
  static constexpr std::array<std::array<double, 2>, 4> gauss{{{0.1834346424956498, 0.3626837833783620},
                                                               {0.5255324099163290, 0.3137066458778873},
                                                               {0.7966664774136267, 0.2223810344533745},
                                                               {0.9602898564975363, 0.1012285362903763}}};
  const auto integral = [&](double a, double b) {
    double sum = 0.0;
    for (const auto& [node, weight] : gauss)
      for (const double sign : {-1.0, 1.0}) sum += weight * slowness(0.5 * (a + b) + 0.5 * sign * (b - a) * node);
    return 0.5 * (b - a) * sum;
  };
  std::vector<double> cells;
  for (int i = 0; i <= 1000; ++i) cells.push_back(far * i / 1000.0);
  for (int i = -1500; i <= 1500; ++i) {
    const double s = centre + width * std::sinh(i / 250.0);
    if (s > 0.0 && s < far) cells.push_back(s);
  }
  std::sort(cells.begin(), cells.end());
  double passed = 0.0, from = 0.0;
  for (const double to : cells) {
    const double more = integral(from, to);
    if (passed + more >= time) break;
    passed += more;
    from = to;
  }
  double s = from;
  for (int iteration = 0; iteration < 50; ++iteration) s += (time - passed - integral(from, s)) / slowness(s);
  return s;
}

/// A potential -depth g(s/width) with its force, as text in a name for s/width.
struct Shape {
  const char* name;
  double (*value)(double u);
  const char* slope;  ///< g'(u)
};
const std::array<Shape, 5> shapes{{
    {"gauss", [](double u) { return std::exp(-u * u); }, "-2*U*exp(-(U)^2)"},
    {"lorentz", [](double u) { return 1 / (1 + u * u); }, "-2*U/(1 + (U)^2)^2"},
    {"sech", [](double u) { return std::abs(u) > 300 ? 0.0 : 1 / (std::cosh(u) * std::cosh(u)); },
     "-2*tanh(U)*(1 - tanh(U)^2)"},
    {"hat", [](double u) { return std::abs(u) < 1 ? (1 - u * u) * (1 - u * u) : 0.0; }, "-4*U*max(0, 1 - (U)^2)"},
    {"plummer", [](double u) { return 1 / std::sqrt(1 + u * u); }, "-U/(1 + (U)^2)^1.5"},
}};

std::string with(const std::string& text, const std::string& u) {
  std::string result;
  for (const char c : text) result += c == 'U' ? u : std::string(1, c);
  return result;
}

enum class Way { Free, Line, LineCoordinates, Circle };

struct Well {
  System system;
  double t_end = 0.0;
  State right;
  std::string what;
};

/// A bead of 0.1 kg with speed v0 on a straight line or a circle meets a well (or a hill) on its way.
Well draw_well(Random& random) {
  Well well;
  const double v0 = random.log_uniform(0.3, 3.0), energy = 0.5 * scenes::mass * v0 * v0;
  well.t_end = random.log_uniform(0.3, 10.0);
  const double length = v0 * well.t_end, width = length * random.log_uniform(1e-3, 1.0);
  const double centre = length * random.uniform(0.15, 0.85);
  const bool is_hill = random.below(3) == 0;
  const double depth = energy * (is_hill ? -random.log_uniform(1e-3, 0.6) : random.log_uniform(1e-3, 3.0));
  const Shape& shape = shapes[static_cast<std::size_t>(random.below(shapes.size()))];
  const auto way = static_cast<Way>(random.below(4));
  const double radius = length / random.uniform(0.5, 5.0);  // of the circle: so many radians
  const Vector3 d = random.direction();
  well.what = std::string(shape.name) + ", way " + std::to_string(static_cast<int>(way)) + ", width " +
              std::to_string(width / length) + ", centre " + std::to_string(centre / length) +
              " of the length, depth " + std::to_string(depth / energy);

  // u(s): s itself, or the straight distance from the well's centre on the circle.
  const auto u = [=](double s) {
    return way == Way::Circle ? 2.0 * radius * std::sin(0.5 * (s - centre) / radius) / width : (s - centre) / width;
  };
  const auto speed = [=](double s) {
    return std::sqrt(2.0 * (energy + depth * (shape.value(u(s)) - shape.value(u(0.0)))) / scenes::mass);
  };
  const double s = distance_after(
      well.t_end, [&](double x) { return 1.0 / speed(x); }, 2.5 * length, centre, width);

  System& system = well.system;
  if (way == Way::Circle) {
    // Force towards the centre of the well: depth g'(u) grad u, u = |r - p|/width.
    const double angle = centre / radius;
    add_point({radius, 0, 0}, &system);
    system.velocities = {0, v0, 0};
    system.constraints = {Circles{"wire", {0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, radius}};
    const std::array p{number(radius * std::cos(angle)), number(radius * std::sin(angle))};
    const std::string distance = "sqrt((x - " + p[0] + ")^2 + (y - " + p[1] + ")^2 + 1e-300)";
    const std::string slope =
        number(depth / width) + "*(" + with(shape.slope, "(" + distance + "/" + number(width) + ")") + ")/" + distance;
    system.forces = {
        FormulaForce{"well", {0}, formula_force({slope + "*(x - " + p[0] + ")", slope + "*(y - " + p[1] + ")", "0"})}};
    const double at = s / radius, v = speed(s);
    well.right = {{radius * std::cos(at), radius * std::sin(at), 0}, {-v * std::sin(at), v * std::cos(at), 0}};
    return well;
  }
  add_point({0, 0, 0}, &system);
  system.velocities = {v0 * d[0], v0 * d[1], v0 * d[2]};
  if (way == Way::Line) system.constraints = {Lines{"wire", {0}, {0.0, 0.0, 0.0}, {d[0], d[1], d[2]}}};
  if (way == Way::LineCoordinates)
    system.coordinates = {LineCoordinates{"wire", {0}, {0.0, 0.0, 0.0}, {d[0], d[1], d[2]}}};
  const std::string place = "((x*" + number(d[0]) + " + y*" + number(d[1]) + " + z*" + number(d[2]) + " - " +
                            number(centre) + ")/" + number(width) + ")";
  std::array<std::string, 3> force;
  for (std::size_t k = 0; k < 3; ++k) force[k] = number(depth / width * d[k]) + "*(" + with(shape.slope, place) + ")";
  system.forces = {FormulaForce{"well", {0}, formula_force(force)}};
  const double v = speed(s);
  well.right = {{s * d[0], s * d[1], s * d[2]}, {v * d[0], v * d[1], v * d[2]}};
  return well;
}

class PassingByMethod : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(, PassingByMethod,
                         testing::Values(Method::Auto, Method::Dop853, Method::Dopri5, Method::Radau5),
                         [](const auto& of) { return std::string(name_of(of.param)); });

/// Each scene that is drawn, against its closed form.
void expect_none_is_jumped(Method method, unsigned seed, int draws, Well (*draw_scene)(Random&)) {
  Random random(seed);
  Tally tally;
  for (int draw = num_draws(draws); draw-- > 0;) {
    const Well scene = draw_scene(random);
    if (method == Method::Radau5 && !scene.system.coordinates.empty()) continue;  // it steps on constraints alone
    tally.add(compare(scene.system, method, scene.t_end, scene.right), 100.0, std::to_string(draw) + ": " + scene.what);
  }
  tally.expect_good();
}

TEST_P(PassingByMethod, NarrowWellsAreNotJumped) {
  expect_none_is_jumped(GetParam(), 7, 100, draw_well);
}

// ---- bumps
// -----------------------------------------------------------------------------------------------------------

/// Heights, their slopes and widths: eta(u), u = (x - centre)/width, as text in U.
struct Bump {
  const char* name;
  const char* height;
  double (*value)(double u);
  double (*slope)(double u);
};
const std::array<Bump, 4> bumps{{
    {"gauss", "exp(-(U)^2)", [](double u) { return std::exp(-u * u); },
     [](double u) { return -2 * u * std::exp(-u * u); }},
    {"lorentz", "1/(1 + (U)^2)", [](double u) { return 1 / (1 + u * u); },
     [](double u) { return -2 * u / ((1 + u * u) * (1 + u * u)); }},
    {"step", "0.5*(1 + tanh(U))", [](double u) { return 0.5 * (1 + std::tanh(u)); },
     [](double u) { return 0.5 * (1 - std::tanh(u) * std::tanh(u)); }},
    {"hat", "max(0, 1 - (U)^2)^4", [](double u) { return std::pow(std::max(0.0, 1 - u * u), 4); },
     [](double u) { return -8 * u * std::pow(std::max(0.0, 1 - u * u), 3); }},
}};

/// A bead that slides along x on a surface, a wire or in a coordinate with a narrow bump, with gravity or without:
///
///   m (1 + (a^2 + b^2) eta'^2/width^2) x_dot^2/2 + m g a eta = E,   z = a eta, y = b eta
Well draw_bump(Random& random) {
  enum class Guide { Surface, Wire, Coordinate, TwoBeads };
  Well scene;
  const double v0 = random.log_uniform(0.3, 3.0), g = random.below(2) == 0 ? 0.0 : 9.81;
  scene.t_end = random.log_uniform(0.3, 10.0);
  const double length = v0 * scene.t_end, width = length * random.log_uniform(1e-3, 1.0);
  const double centre = length * random.uniform(0.15, 0.85);
  const double most = g > 0.0 ? 0.25 * v0 * v0 / g : 1e300;
  const double a = std::min(width * random.log_uniform(1e-3, 2.0), most) * (random.below(2) == 0 ? 1.0 : -1.0);
  const auto way = static_cast<Guide>(random.below(4));
  const double b = way == Guide::Wire ? width * random.log_uniform(1e-3, 1.0) : 0.0;
  const Bump& bump = bumps[static_cast<std::size_t>(random.below(bumps.size()))];
  scene.what = std::string(bump.name) + ", way " + std::to_string(static_cast<int>(way)) + ", width " +
               std::to_string(width / length) + ", centre " + std::to_string(centre / length) +
               " of the length, height " + std::to_string(a / width) + " of the width, g " + std::to_string(g);

  const auto u = [=](double x) { return (x - centre) / width; };
  const auto stretch = [=](double x) {
    const double slope = bump.slope(u(x)) / width;
    return 1.0 + (a * a + b * b) * slope * slope;
  };
  const double energy = 0.5 * stretch(0.0) * v0 * v0 + g * a * bump.value(u(0.0));
  const auto speed = [=](double x) { return std::sqrt(2.0 * (energy - g * a * bump.value(u(x))) / stretch(x)); };
  const double x = distance_after(
      scene.t_end, [&](double at) { return 1.0 / speed(at); }, 3.0 * length, centre, width);
  const auto state_at = [&](double at, double rate) {
    const double eta = bump.value(u(at)), slope = bump.slope(u(at)) / width;
    return State{{at, b * eta, a * eta}, {rate, b * slope * rate, a * slope * rate}};
  };
  scene.right = state_at(x, speed(x));
  const State start = state_at(0.0, v0);

  System& system = scene.system;
  add_point({start.r[0], start.r[1], start.r[2]}, &system);
  system.velocities = start.v;
  if (g > 0.0) system.forces = {Gravity{"gravity", {0, 0, -g}}};
  const auto eta_of = [&](const std::string& name) {
    return with(bump.height, "((" + name + " - " + number(centre) + ")/" + number(width) + ")");
  };
  if (way == Guide::Coordinate) {
    const std::array<std::string, 1> names{"q"};
    const std::array<std::string, 3> places{"q", "0", number(a) + "*" + eta_of("q")};
    system.coordinates = {UserCoordinates{"ramp", {{0}}, formula_coordinates(names, places), {0.0}, {v0}}};
    return scene;
  }
  const auto add = [&](const char* name, const std::string& equation) {
    system.constraints.push_back(UserConstraints{name, {{0}}, formula_constraint(equation, 1)});
  };
  add("height", "z1 - " + number(a) + "*" + eta_of("x1"));
  add("side", "y1 - " + number(b) + "*" + eta_of("x1"));
  if (way != Guide::TwoBeads) return scene;
  // Another one keeps beside it, at the distance 1 along y: a constraint of two points.
  add_point({start.r[0], 1.0, start.r[2]}, &system);
  system.velocities.resize(6);
  std::copy_n(start.v.begin(), 3, system.velocities.begin() + 3);
  system.constraints.push_back(UserConstraints{"beside", {{0, 1}}, formula_constraint("y2 - y1 - 1", 2)});
  system.constraints.push_back(UserConstraints{"level", {{0, 1}}, formula_constraint("z2 - z1", 2)});
  system.constraints.push_back(UserConstraints{"abreast", {{0, 1}}, formula_constraint("x2 - x1", 2)});
  scene.right.r.insert(scene.right.r.end(), {x, 1.0, scene.right.r[2]});
  scene.right.v.insert(scene.right.v.end(), {scene.right.v[0], 0.0, scene.right.v[2]});
  return scene;
}

TEST_P(PassingByMethod, NarrowBumpsOfGuidesAreNotJumped) {
  expect_none_is_jumped(GetParam(), 17, 60, draw_bump);
}

// ---- pairs
// -----------------------------------------------------------------------------------------------------------

System make_two_beads(double gap) {
  System system;
  system.positions = {0, 0, 0, gap, 0.1, 0};
  system.velocities = {1, 0, 0, 0, 0, 0};
  system.masses = {1, 1};
  system.forces = {PairForces{}};
  return system;
}

/// Where a longer flight ends: everything happens later by the same time, and nothing else.
State shift(State state, double gap, double more) {
  for (std::size_t i = 0; i < 6; ++i) state.r[i] += more * state.v[i];
  state.r[0] += gap;
  state.r[3] += gap;
  return state;
}

TEST_P(PassingByMethod, TwoBeadsMeetHoweverFarTheyAre) {
  Simulation exact(make_two_beads(2.0), {.method = Method::Rattle6, .step = 2.5e-4}, {.threads = 1});
  ASSERT_TRUE(exact.advance_to(4.0).ok());
  ASSERT_LT(exact.velocities()[0], 0.1) << "they have met";

  for (double gap = 2.0; gap <= 60.0; gap += 1.0) {
    Simulation simulation(make_two_beads(gap), {.method = GetParam(), .rtol = rtol, .atol = atol}, {.threads = 1});
    ASSERT_TRUE(simulation.advance_to(2.0 * gap).ok()) << gap;

    // They meet at gap - 2 later, and gap - 2 farther, and fly on for the rest.
    const State right = shift(state_of(exact), gap - 2.0, gap - 2.0);
    EXPECT_LT(over_tolerance(simulation.velocities(), right.v), 100.0) << gap;
    EXPECT_LT(over_tolerance(simulation.positions(), right.r), 100.0 * gap) << gap;
    EXPECT_TRUE(simulation.report().accuracy_warning.empty()) << gap;
  }
}

/// It cannot jump: steps end after every twentieth of the time in which beads pass each other.
State run_in_pieces(const System& system, double t_end, double piece) {
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14}, {.threads = 1});
  const int pieces = static_cast<int>(std::ceil(t_end / piece));
  for (int k = 1; k <= pieces; ++k) {
    const Outcome outcome = simulation.advance_to(t_end * k / pieces);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
  }
  return state_of(simulation);
}

struct Gas {
  System system;
  double t_end = 0.0, piece = 0.0;
  std::string what;
};

/// Beads of size 1 in pairs, each of which meets once: two free ones, one at rest on a support, one that a support
/// carries along, or a dumbbell that spins; in space or in a periodic box.
Gas draw_gas(Random& random) {
  constexpr std::array names{"free", "obstacle", "carried", "dumbbell"};
  Gas gas;
  System& system = gas.system;
  const double speed = random.log_uniform(0.5, 2.0), length = 1.0 / random.log_uniform(1e-3, 1.0);
  gas.t_end = (length + 3.0) / speed;
  gas.piece = 0.1 / speed;
  PairForces pairs;
  pairs.exclude_rods = true;
  pairs.law = std::array{PairLaw::Wca, PairLaw::Lj, PairLaw::Log}[static_cast<std::size_t>(random.below(3))];
  if (pairs.law == PairLaw::Lj) pairs.cutoff = random.uniform(1.2, 3.0);
  if (pairs.law == PairLaw::Lj) pairs.epsilon = 0.1;
  if (pairs.law == PairLaw::Log) pairs.strength = 0.02 * speed * speed;
  gas.what = std::string(kind_name(Force{pairs})) + " law " + std::to_string(static_cast<int>(pairs.law)) +
             ", length " + std::to_string(length);
  const bool has_box = pairs.law != PairLaw::Log && random.below(4) == 0;
  if (has_box) pairs.box = {std::max(8.0, 0.3 * length), std::max(8.0, 0.3 * length), 0.0};
  if (has_box) gas.what += ", box";
  const int num_pairs = 1 + random.below(2);
  for (int k = 0; k < num_pairs; ++k) {
    const int kind = random.below(names.size());
    gas.what += std::string(", ") + names[static_cast<std::size_t>(kind)];
    const Vector3 d = random.direction();
    const double away = 40.0 * k, reach = 1.5 + length * random.uniform(0.1, 0.8), offset = random.uniform(0.1, 0.9);
    // The target, and a bead that flies along d past it, at `offset`.
    const Vector3 e = std::abs(d[2]) < 0.9 ? Vector3{-d[1], d[0], 0.0} : Vector3{0.0, -d[2], d[1]};
    const double scale = offset / std::hypot(e[0], e[1], e[2]);
    Vector3 from;
    for (std::size_t c = 0; c < 3; ++c) from[c] = -reach * d[c] + scale * e[c];
    const Index target = add_point({0, 0, away}, &system);
    const auto t = static_cast<std::size_t>(target);
    const Index bead = add_point({from[0], from[1], from[2] + away}, &system);
    for (std::size_t c = 0; c < 3; ++c) system.velocities[3 * static_cast<std::size_t>(bead) + c] = speed * d[c];
    if (kind == 1) system.supports.push_back({"", {target}, {}});
    if (kind == 2) {
      const std::string back = number(-0.5 * speed) + "*t*";
      system.supports.push_back(
          {"",
           {target},
           {ScalarFunction::formula(back + number(d[0])), ScalarFunction::formula(back + number(d[1])),
            ScalarFunction::formula(back + number(d[2]))}});
    }
    if (kind == 3) {
      const Index other = add_point({0.0, 1.0, away}, &system);
      const double spin = speed * random.log_uniform(0.01, 1.0);
      system.velocities[3 * t] = spin;
      system.velocities[3 * static_cast<std::size_t>(other)] = -spin;
      system.constraints.push_back(Rods{"rod" + std::to_string(k), {{target, other}}, 1.0, {}});
    }
  }
  std::fill(system.masses.begin(), system.masses.end(), 1.0);
  system.forces = {pairs};
  return gas;
}

TEST_P(PassingByMethod, BeadsOfAThinGasMeet) {
  Random random(11), noise(12);
  Tally tally;
  for (int draw = num_draws(120); draw-- > 0;) {
    const Gas gas = draw_gas(random);
    const State right = run_in_pieces(gas.system, gas.t_end, gas.piece);
    // What becomes of ten tolerances at the start.
    System moved = gas.system;
    for (std::size_t i = 0; i < moved.velocities.size(); ++i)
      moved.velocities[i] += 10.0 * noise.uniform(-1.0, 1.0) * (atol + rtol * std::abs(moved.velocities[i]));
    MotionOptions options{.method = Method::Dop853, .rtol = 1e-12, .atol = 1e-14, .start = StartMode::Project};
    Simulation other(moved, options, {.threads = 1});
    for (int k = 1; k <= 1000; ++k) ASSERT_TRUE(other.advance_to(gas.t_end * k / 1000).ok());
    const double growth =
        0.1 * std::max(over_tolerance(other.positions(), right.r), over_tolerance(other.velocities(), right.v));

    const std::string what = std::to_string(draw) + ": " + gas.what;
    const double each = std::max(growth, 1.0), allowed = 100.0 * each;
    const Verdict verdict = compare(gas.system, GetParam(), gas.t_end, right);
    if (!verdict.told.empty() || verdict.error <= allowed) {
      tally.add(verdict, allowed, what);
      continue;
    }
    // Dumbbells that spin for long make thousands of steps, each of which may err by a tolerance in the same sense.
    // That falls with the tolerance, and what was jumped does not.
    EXPECT_LE(verdict.error, each * static_cast<double>(verdict.steps)) << what;
    tally.add(compare(gas.system, GetParam(), gas.t_end, right, 0.1), 0.2 * verdict.error, what);
  }
  tally.expect_good();
}

/// Beads at random places of a wide grid with random velocities.
System make_gas_of_sixty() {
  Random random(5);
  System system;
  for (int i = 0; i < 60; ++i) {
    const double x = i % 4, y = i / 4 % 4, z = i / 16;
    add_point({12 * x + random.uniform(0, 10), 12 * y + random.uniform(0, 10), 12 * z + random.uniform(0, 10)},
              &system);
  }
  for (double& v : system.velocities) v = random.uniform(-1, 1);
  std::fill(system.masses.begin(), system.masses.end(), 1.0);
  system.forces = {PairForces{.box = {48, 48, 48}}};
  return system;
}

State run(const System& system, double tolerance, double t_end) {
  Simulation simulation(system, {.method = Method::Dop853, .rtol = tolerance, .atol = tolerance}, {.threads = 1});
  EXPECT_TRUE(simulation.advance_to(t_end).ok());
  return state_of(simulation);
}

TEST(PassingTest, AGasOfSixtyBeadsIsTheSameAtEachTolerance) {
  constexpr double t_end = 60.0, move = 1e-10;
  const System gas = make_gas_of_sixty();
  System moved = gas;
  for (std::size_t i = 0; i < moved.positions.size(); ++i) moved.positions[i] += i % 2 == 0 ? move : -move;
  const State right = run(gas, 1e-12, t_end);
  const double growth = largest_difference(run(moved, 1e-12, t_end).r, right.r) / move;
  ASSERT_LT(growth, 1e6) << "the motion is known";

  for (const double tolerance : {1e-9, 1e-10, 1e-11}) {
    const double size = 48.0;  // to which relative tolerances belong
    EXPECT_LT(largest_difference(run(gas, tolerance, t_end).r, right.r), 100 * tolerance * size * growth) << tolerance;
  }
}

/// What is looked for between the looks depends on nothing that a snapshot does not hold.
TEST(PassingTest, ARunThatGoesOnFromASnapshotMeetsTheSameBeads) {
  const System gas = make_gas_of_sixty();
  const MotionOptions options{.method = Method::Dopri5, .rtol = 1e-7, .atol = 1e-9};
  Simulation whole(gas, options, {.threads = 1}), again(gas, options, {.threads = 1});
  ASSERT_TRUE(whole.advance_to(30.0).ok());
  const std::vector<std::byte> saved = whole.save();
  const std::size_t rejected = whole.report().rejected;
  ASSERT_TRUE(whole.advance_to(60.0).ok());

  again.restore(saved);
  ASSERT_TRUE(again.advance_to(60.0).ok());

  EXPECT_EQ(state_of(again).r, state_of(whole).r);
  EXPECT_EQ(again.report().rejected, whole.report().rejected);
  EXPECT_GT(whole.report().rejected, rejected);
}

/// Fixed steps are taken as they were told; the report says where they jump.
TEST(PassingTest, FixedStepsThatJumpAreWarnedOf) {
  Random random(3);
  System well;
  add_point({0, 0, 0}, &well);
  well.velocities = {1, 0, 0};
  well.forces = {FormulaForce{"well", {0}, formula_force({"-5*(x - 5.3)*exp(-100*(x - 5.3)^2)", "0", "0"})}};
  for (const Method method : {Method::Rk4, Method::Rattle, Method::Rattle4, Method::GeneralizedAlpha}) {
    for (const System& system : {make_two_beads(7.3), well}) {
      Simulation jumps(system, {.method = method, .step = 4.0}, {.threads = 1});
      Simulation sees(system, {.method = method, .step = 0.002}, {.threads = 1});
      ASSERT_TRUE(jumps.advance_to(12.0).ok());
      ASSERT_TRUE(sees.advance_to(12.0).ok());

      EXPECT_FALSE(jumps.report().accuracy_warning.empty()) << name_of(method);
      EXPECT_EQ(sees.report().accuracy_warning, "") << name_of(method);
    }
  }
}

/// Under 1 N a bead of 0.1 kg gains speed, but for a window of velocities where next to nothing is left of the force:
/// t = integral m dv/f(v).
TEST_P(PassingByMethod, NarrowWindowsOfVelocityAreNotJumped) {
  Random random(17);
  Tally tally;
  for (int draw = num_draws(30); draw-- > 0;) {
    const double depth = random.uniform(0.1, 0.95), width = 20.0 * random.log_uniform(1e-3, 0.3);
    const double middle = random.uniform(4.0, 16.0), t_end = 2.0;
    const auto force = [=](double v) { return 1.0 - depth * std::exp(-std::pow((v - middle) / width, 2)); };
    System system;
    add_point({0, 0, 0}, &system);
    const std::string u = "((vx - " + number(middle) + ")/" + number(width) + ")";
    system.forces = {
        FormulaForce{"window", {0}, formula_force({"1 - " + number(depth) + "*exp(-" + u + "^2)", "0", "0"})}};
    const double v = distance_after(
        t_end, [=](double at) { return scenes::mass / force(at); }, 25.0, middle, width);
    Simulation simulation(system, {.method = GetParam(), .rtol = rtol, .atol = atol}, {.threads = 1});
    const Outcome outcome = simulation.advance_to(t_end);

    tally.add({outcome.what, std::abs(simulation.velocities()[0] - v) / (atol + rtol * v)}, 100.0,
              std::to_string(draw) + ": width " + std::to_string(width) + " at " + std::to_string(middle));
  }
  tally.expect_good();
}

/// Wide wells cost no step: the looks of every scheme resolve them.
TEST_P(PassingByMethod, SmoothForcesRejectNothing) {
  System planet;
  add_point({1, 0, 0}, &planet);
  planet.velocities = {0, 1, 0};
  planet.masses = {1};
  const std::string cube = "/(x^2 + y^2 + z^2)^1.5";
  planet.forces = {FormulaForce{"sun", {0}, formula_force({"-x" + cube, "-y" + cube, "-z" + cube})}};
  Simulation simulation(planet, {.method = GetParam(), .rtol = rtol, .atol = atol}, {.threads = 1});

  ASSERT_TRUE(simulation.advance_to(20.0).ok());

  EXPECT_LE(simulation.report().rejected, 3u);
  EXPECT_TRUE(simulation.report().accuracy_warning.empty());
}

}  // namespace
}  // namespace tanor
