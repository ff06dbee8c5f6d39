#include <cmath>
#include <numbers>

#include "cli/known_problems.hpp"

namespace tanor::cli {

namespace {

using std::numbers::pi;

// ---- planar pendulum: elliptic functions ---------------------------------------------------------------------------

/// Returns the angle of angle'' = -frequency^2 sin(angle), released at rest at `amplitude`:
///
///   sin(angle/2) = k sin(phi),   F(phi, k) = K(k) - frequency t,   k = sin(amplitude/2)
///
/// It is computed in long double, since 2000 s are some 1000 swings.
double swing(long double amplitude, long double frequency, long double t) {
  const long double k = std::sin(0.5L * amplitude), quarter = std::comp_ellint_1(k);
  const long double u = std::remainder(quarter - frequency * t, 4.0L * quarter);
  long double phi = 0.5L * std::numbers::pi_v<long double> * u / quarter;
  for (int i = 0; i < 30; ++i) {  // Newton's method, dF/dphi = 1/sqrt(1 - (k sin phi)^2)
    const long double s = k * std::sin(phi);
    phi -= (std::ellint_1(k, phi) - u) * std::sqrt(1.0L - s * s);
  }
  return static_cast<double>(2.0L * std::asin(k * std::sin(phi)));
}

/// Solves IFToMM benchmark A01: l = 1, from (-1, 0) at rest.
Finding swing_pendulum(const MotionOptions& options, double t_end) {
  System system;
  const Index pivot = add_point({0, 0, 0}, {}, 1.0, &system), bob = add_point({-1, 0, 0}, {}, 1.0, &system);
  system.supports = {{"pivot", {pivot}, {}}};
  system.constraints = {Rods{"rod", {{pivot, bob}}, {}, {}}};
  system.forces = {Gravity{"", {0, -g, 0}}};
  const double angle = swing(-0.5L * pi, std::sqrt(static_cast<long double>(g)), t_end);
  return follow(system, options, t_end, bob, {std::sin(angle), -std::cos(angle), 0.0});
}

// ---- quadruple precision, two ways each ----------------------------------------------------------------------------

/// Solves a spherical pendulum: l = 1, m = 1, 1 rad from the vertical, sent sideways.
Finding swing_spherical_pendulum() {
  System system;
  const Index pivot = add_point({0, 0, 0}, {}, 1.0, &system);
  const Index bob = add_point({std::sin(1.0), 0, -std::cos(1.0)}, {0, 1.5, 0}, 1.0, &system);
  system.supports = {{"pivot", {pivot}, {}}};
  system.constraints = {Rods{"rod", {{pivot, bob}}, 1.0, {}}};
  system.forces = {Gravity{"", {0, 0, -g}}};
  return follow(system, tightly(Method::Dop853), 5.0, bob,
                {0.2353831972905855, -0.5206158610393884, -0.8207032811360500});
}

/// Solves a bead on a hoop of radius 1 that turns about its vertical diameter.
Finding ride_hoop() {
  System system;
  const Index bead = add_point({std::sin(0.5), 0, -std::cos(0.5)}, {0, 5.0 * std::sin(0.5), 0}, 1.0, &system);
  const VectorFunction turning{ScalarFunction::formula("sin(5*t)"), ScalarFunction::formula("-cos(5*t)"), 0.0};
  system.constraints = {Circles{"hoop", {bead}, Vector3{0, 0, 0}, turning, 1.0}};
  system.forces = {Gravity{"", {0, 0, -g}}};
  return follow(system, tightly(Method::Taylor), 5.0, bead,
                {0.5657286909859283, -0.0755397194563478, -0.8211241069287126});
}

/// Solves a pendulum on a reeled line: theta = 0.5, l = 1 + 0.3 sin 2t.
Finding reel_pendulum() {
  System system;
  const Index pivot = add_point({0, 0, 0}, {}, 1.0, &system);
  const Vector3 along{std::sin(0.5), -std::cos(0.5), 0.0};
  const Index bob = add_point(along, {0.6 * along[0], 0.6 * along[1], 0}, 1.0, &system);
  system.supports = {{"pivot", {pivot}, {}}};
  system.constraints = {Rods{"rod", {{pivot, bob}}, ScalarFunction::formula("1 + 0.3*sin(2*t)"), {}}};
  system.forces = {Gravity{"", {0, -g, 0}}};
  return follow(system, tightly(Method::Radau5), 5.0, bob, {-0.3925337867436984, -0.7390134416567998, 0.0});
}

/// Solves ten rods of 0.1 m with beads of 0.1 kg, released horizontally.
Finding drop_chain() {
  System system;
  Rods rods{"rods", {}, 0.1, {}};
  for (Index i = 0; i <= 10; ++i) {
    add_point({0.1 * i, 0, 0}, {}, 0.1, &system);
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0, -g, 0}}};
  return follow(system, tightly(Method::Taylor), 1.0, 9,
                {-0.8398623031693640, -0.0817941929859863, 0.0, -0.9133122294063770, -0.1496551414188307, 0.0});
}

// ---- waves on a chain ----------------------------------------------------------------------------------------------

/// Solves nine beads of 1 kg on rods of 1 m, pulled straight by 10 N, in the shape of the first mode with amplitude 1
/// mm, for about one period.
Finding send_wave() {
  System system;
  Rods rods{"rods", {}, 1.0, {}};
  add_point({0, 0, 0}, {}, 1.0, &system);
  double x = 0.0, y = 0.0;
  for (Index i = 1; i <= 9; ++i) {
    const double height = i < 9 ? 1e-3 * std::sin(pi * i / 9.0) : 0.0;
    x += std::sqrt((1.0 - (height - y)) * (1.0 + (height - y)));
    y = height;
    add_point({x, y, 0}, {}, 1.0, &system);
    rods.pairs.push_back({i - 1, i});
  }
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {rods, Lines{"rail", {9}, Vector3{}, Vector3{1, 0, 0}}};
  system.forces = {ConstantForce{"pull", {9}, Vector3{10, 0, 0}}};

  Simulation simulation(system, tightly(Method::Taylor), {.threads = 1});
  const Outcome outcome = simulation.advance_to(5.721101367);
  std::vector<double> heights;
  for (std::size_t i = 1; i <= 8; ++i) heights.push_back(simulation.positions()[3 * i + 1]);
  const std::vector<double> known{0.0003420201530650944, 0.0006427876203066078, 0.0008660254009614006,
                                  0.0009848077405434227, 0.0009848077483215071, 0.0008660254103290960,
                                  0.0006427876162701710, 0.0003420201412388040};
  return {relative_error(heights, known), outcome};
}

// ---- repulsion -----------------------------------------------------------------------------------------------------

/// Solves four WCA beads that fly apart from rest at distances of 0.95: all energy becomes motion. epsilon = sigma = m
/// = 1.
///
///   6 u(0.95) = 4 v^2/2,   u(a) = 4 (a^-12 - a^-6) + 1
Finding explode_tetrahedron() {
  constexpr double edge = 0.95;
  const double a = edge / std::sqrt(8.0), a6 = std::pow(edge, -6.0);
  System system;
  for (const Vector3& corner : {Vector3{a, a, a}, {a, -a, -a}, {-a, a, -a}, {-a, -a, a}}) {
    add_point(corner, {}, 1.0, &system);
  }
  system.forces = {PairForces{.name = "beads", .law = PairLaw::Wca}};
  Simulation simulation(system, tightly(Method::Dopri5), {.threads = 1});
  const Outcome outcome = simulation.advance_to(1.0);
  const double speed = std::sqrt(3.0 * (4.0 * (a6 * a6 - a6) + 1.0));
  const auto v = simulation.velocities();
  return {relative_error({{std::hypot(v[0], v[1], v[2])}}, {{speed}}), outcome};
}

}  // namespace

std::vector<KnownProblem> list_known_motions() {
  struct MethodRun {
    MotionOptions options;
    double promised;
  };
  std::vector<KnownProblem> problems;
  for (const auto& [options, promised] :
       {MethodRun{tightly(Method::Taylor), 12.0}, MethodRun{tightly(Method::Dop853), 11.0},
        MethodRun{tightly(Method::Dopri5), 10.5}, MethodRun{tightly(Method::Radau5), 9.0},
        MethodRun{{.method = Method::Rk4, .step = 1e-3}, 9.0}, MethodRun{{.method = Method::Rattle, .step = 1e-3}, 4.0},
        MethodRun{{.method = Method::Rattle4, .step = 1e-3}, 8.5},
        MethodRun{{.method = Method::Rattle6, .step = 2e-3}, 10.0},
        MethodRun{{.method = Method::GeneralizedAlpha, .step = 1e-3}, 3.0}}) {
    problems.push_back({"pendulum, 10 s", "elliptic functions", std::string(name_of(options.method)), promised,
                        [options = options] { return swing_pendulum(options, 10.0); }});
  }
  const std::string quadruple = "quadruple precision, two ways";
  // The truncation errors of 15,000 steps add up.
  const MotionOptions for_long_runs{.method = Method::Taylor, .rtol = 1e-14, .atol = 1e-16};
  problems.insert(problems.end(), {{"pendulum, 2000 s (IFToMM A01)", "elliptic functions", "taylor", 8.0,
                                    [for_long_runs] { return swing_pendulum(for_long_runs, 2000.0); }},
                                   {"spherical pendulum, 5 s", quadruple, "dop853", 12.0, swing_spherical_pendulum},
                                   {"bead on a turning hoop, 5 s", quadruple, "taylor", 12.0, ride_hoop},
                                   {"pendulum on a line that is reeled, 5 s", quadruple, "radau5", 11.0, reel_pendulum},
                                   {"chain of 10 rods, 1 s", quadruple, "taylor", 9.5, drop_chain},
                                   {"wave of 1 mm on a chain of 9 rods, 5.7 s", quadruple, "taylor", 11.5, send_wave},
                                   {"four WCA beads fly apart", "energy", "dopri5", 10.0, explode_tetrahedron}});
  return problems;
}

}  // namespace tanor::cli
