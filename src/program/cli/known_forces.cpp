#include <cmath>
#include <numbers>

#include "cli/known_problems.hpp"

namespace tanor::cli {

namespace {

using std::numbers::pi;

/// Solves a chain of ten rods of 0.1 m, beads of 0.1 kg, ends 0.8 m apart. All tensions have the same horizontal part
/// H, and vertical ones that grow by m g from bead to bead. H is such that the rods end where they must.
Finding hang_chain() {
  constexpr double H = 3.308923709683320025, m = 0.1, l = 0.1;
  System system;
  Rods rods{"rods", {}, l, {}};
  std::vector<double> tensions;
  double x = 0.0, y = 0.0;
  add_point({x, y, 0}, {}, m, &system);
  for (Index k = 0; k < 10; ++k) {
    const double V = m * g * (4.5 - k), T = std::hypot(H, V);
    x += l * H / T;
    y -= l * V / T;
    add_point({x, y, 0}, {}, m, &system);
    rods.pairs.push_back({k, k + 1});
    tensions.push_back(-T);
  }
  system.supports = {{"ends", {0, 10}, {}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0, -g, 0}}};
  const Answer answer = solve_start(system);
  return {relative_error(answer.multipliers, tensions), answer.outcome};
}

/// Solves a straight chain of 20 light beads and a tip of 1e12 kg that turns about its anchor at 3 rad/s while it
/// begins to fall across its rods: w_k = (-omega^2 x_k, -g), though forces of 1e12 N meet at beads of 1 kg.
Finding whirl_heavy_tip() {
  constexpr double omega = 3.0;
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<double> known;
  for (Index k = 0; k <= 20; ++k) {
    const double x = 0.1 * k;
    add_point({x, 0, 0}, {0, omega * x, 0}, k < 20 ? 1.0 : 1e12, &system);
    if (k > 0) rods.pairs.push_back({k - 1, k});
    known.insert(known.end(), {-omega * omega * x, k > 0 ? -g : 0.0, 0.0});
  }
  system.supports = {{"anchor", {0}, {}}};
  system.constraints = {rods};
  system.forces = {Gravity{"", {0, -g, 0}}};
  const Answer answer = solve_start(system);
  return {relative_error(answer.accelerations, known), answer.outcome};
}

/// Moves Fekete points, IVP test set, Release 2.4, part II-4: 20 points of 1 kg on the unit sphere repel each other by
/// (p_i - p_j)/|p_i - p_j|^2 in a drag of 0.5 v. Each of the others pushes with 1/2 along p_i, so that
///
///   lambda_i = -19/2 - |v_i|^2 for any motion.
Finding move_fekete_points() {
  System system;
  Spheres sphere{"sphere", {}, Vector3{}, 1.0};
  const struct {
    int count;
    double turn, latitude;
  } rings[] = {{3, pi / 13, 3 * pi / 8}, {7, pi / 29, pi / 8}, {6, pi / 7, -2 * pi / 15}, {4, pi / 17, -3 * pi / 10}};
  for (const auto& [count, turn, latitude] : rings) {
    for (int i = 1; i <= count; ++i) {
      const double a = 2 * pi * i / count + turn, c = std::cos(latitude);
      sphere.points.push_back(add_point({c * std::cos(a), c * std::sin(a), std::sin(latitude)}, {}, 1.0, &system));
    }
  }
  system.constraints = {sphere};
  system.forces = {Drag{"drag", sphere.points, 0.5, 0.0},
                   PairForces{.name = "repulsion", .law = PairLaw::Log, .strength = 1.0}};
  Simulation simulation(system, {.method = Method::Dop853, .rtol = 1e-8, .atol = 1e-10}, {.threads = 1});
  const Outcome outcome = simulation.advance_to(1.0);
  std::vector<double> known;
  const auto v = simulation.velocities();
  for (std::size_t i = 0; i < 20; ++i) {
    known.push_back(-9.5 - v[3 * i] * v[3 * i] - v[3 * i + 1] * v[3 * i + 1] - v[3 * i + 2] * v[3 * i + 2]);
  }
  return {relative_error(simulation.multipliers(), known), outcome};
}

}  // namespace

std::vector<KnownProblem> list_known_forces() {
  return {{"tensions of a hanging chain", "closed form", "one instant", 12.0, hang_chain},
          {"tip of 1e12 kg on beads of 1 kg", "closed form", "one instant", 12.0, whirl_heavy_tip},
          {"multipliers of Fekete points, 1 s", "closed form", "dop853", 12.0, move_fekete_points}};
}

}  // namespace tanor::cli
