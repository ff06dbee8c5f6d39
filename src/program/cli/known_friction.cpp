#include <cmath>
#include <numbers>

#include "cli/known_problems.hpp"

namespace tanor::cli {

namespace {

using std::numbers::pi;

/// Makes a point of 2 kg on a rough line, 30 degrees steep, mu = 0.3, with the given speed downhill along it.
System make_incline(double speed) {
  const Vector3 downhill{std::sqrt(0.75), -0.5, 0.0};
  System system;
  add_point({0, 0, 0}, {speed * downhill[0], speed * downhill[1], 0}, 2.0, &system);
  system.constraints = {Lines{"rail", {0}, Vector3{}, downhill}};
  system.forces = {Gravity{"", {0, -g, 0}}};
  system.friction = {Coulomb{.name = "", .at = {"rail"}, .coefficient = 0.3}};
  return system;
}

/// Solves the slide downhill, s = t + g (sin 30 - 0.3 cos 30) t^2/2.
Finding slide_down() {
  const double s = 2.0 + 2.0 * g * (0.5 - 0.3 * std::sqrt(0.75));
  return follow(make_incline(1.0), tightly(Method::Dop853), 2.0, 0, {s * std::sqrt(0.75), -0.5 * s, 0.0});
}

/// Solves the slide uphill. The point is at rest after 1/(g (sin 30 + 0.3 cos 30)), then slides back (0.3 < tan 30).
Finding slide_up() {
  Simulation simulation(make_incline(-1.0), tightly(Method::Dopri5), {.threads = 1});
  const Outcome outcome = simulation.advance_to(0.5);
  return {relative_error({{simulation.report().last_event}}, {{1.0 / (g * (0.5 + 0.3 * std::sqrt(0.75)))}}), outcome};
}

/// Solves a bead at 3 m/s on a rough ring of 1 m, mu = 0.2, which goes through the angle ln(1 + 0.6 t)/0.2.
Finding circle_around() {
  System system;
  add_point({1, 0, 0}, {0, 3, 0}, 1.0, &system);
  system.constraints = {Circles{"ring", {0}, Vector3{}, Vector3{0, 0, 1}, 1.0}};
  system.friction = {Coulomb{.name = "", .at = {"ring"}, .coefficient = 0.2}};
  const double angle = std::log(4.0) / 0.2;
  return follow(system, tightly(Method::Dop853), 5.0, 0, {std::cos(angle), std::sin(angle), 0.0});
}

/// Solves the rope of Euler and Eytelwein: 10 beads half around a rough cylinder, mu = 0.3, about to slide. At each
/// bead
///
///   T'/T = (1 + mu tan(D/2))/(1 - mu tan(D/2)),   D = pi/10;   2.5884 in all, e^(mu pi) = 2.5663 for fine beads
Finding pull_rope() {
  constexpr Index count = 10;
  constexpr double mu = 0.3, radius = 0.3, turn = pi / count;
  const double ratio = (1.0 + mu * std::tan(0.5 * turn)) / (1.0 - mu * std::tan(0.5 * turn));
  System system;
  Circles cylinder{"cylinder", {}, Vector3{}, Vector3{0, 0, 1}, radius};
  Rods rods{"rods", {}, {}, {}};
  std::vector<double> tensions;
  for (Index k = 0; k < count; ++k) {
    const double c = std::cos(k * turn), s = std::sin(k * turn);
    cylinder.points.push_back(add_point({radius * c, radius * s, 0}, {-1e-9 * s, 1e-9 * c, 0}, 0.1, &system));
    if (k == 0) continue;
    rods.pairs.push_back({k - 1, k});
    tensions.push_back(std::pow(ratio, k));
  }
  const auto pull = [](double from, double sense, double force) {  // along the next rod, if there were one
    const double angle = from + sense * 0.5 * turn;
    return Vector3{-sense * force * std::sin(angle), sense * force * std::cos(angle), 0.0};
  };
  system.constraints = {cylinder, rods};
  system.forces = {ConstantForce{"slack end", {0}, pull(0.0, -1.0, 1.0)},
                   ConstantForce{"pulled end", {count - 1}, pull(pi - turn, 1.0, std::pow(ratio, count))}};
  system.friction = {Coulomb{.name = "", .at = {"cylinder"}, .coefficient = mu}};

  Answer answer = solve_start(system);
  for (double& multiplier : answer.multipliers) multiplier = -multiplier;  // tension
  return {relative_error(std::span(answer.multipliers).subspan(2 * count), tensions), answer.outcome};
}

/// Solves Painleve's problem: a rough rail and a smooth one, a rod of 75 degrees between beads of 1 kg that slide,
/// pushed by `push`.
Answer push_rod(double mu, double push) {
  System system;
  add_point({0, 0, 0}, {1, 0, 0}, 1.0, &system);
  add_point({std::tan(pi / 12.0), 1, 0}, {1, 0, 0}, 1.0, &system);
  system.constraints = {Lines{"rough rail", {0}, Vector3{}, Vector3{1, 0, 0}},
                        Lines{"smooth rail", {1}, Vector3{0, 1, 0}, Vector3{1, 0, 0}}, Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"", {0, -g, 0}}, ConstantForce{"push", {1}, Vector3{push, 0, 0}}};
  system.friction = {Coulomb{.name = "", .at = {"rough rail"}, .coefficient = mu}};
  return solve_start(system);
}

/// Solves the jammed rod. Its compression T obeys T c 2 + mu |g + T s| = -f2, which has one solution for mu = 0.4, and
/// two or none for mu = 0.6.
Finding jam_rod() {
  if (push_rod(0.6, 1.0).outcome.status != Status::NotUnique) {
    return {HUGE_VAL, {Status::NotUnique, "two solutions were not found out"}};
  }
  if (push_rod(0.6, 30.0).outcome.status != Status::NoSolution) {
    return {HUGE_VAL, {Status::NoSolution, "that there is no solution was not found out"}};
  }
  const Answer answer = push_rod(0.4, 1.0);
  const double alpha = 5.0 * pi / 12.0, c = std::cos(alpha), s = std::sin(alpha);
  const double compression = -(1.0 + 0.4 * g) / (2.0 * c + 0.4 * s);  // valid if the bead is pushed down, g + T s > 0
  return {relative_error({{answer.multipliers.back()}}, {{compression}}), answer.outcome};
}

}  // namespace

std::vector<KnownProblem> list_known_friction() {
  return {{"rough incline, 2 s", "closed form", "dop853", 12.0, slide_down},
          {"rough incline, uphill: when it stops", "closed form", "dopri5", 11.0, slide_up},
          {"rough ring, 5 s", "closed form", "dop853", 11.0, circle_around},
          {"rope around a cylinder (Euler, Eytelwein)", "closed form", "one instant", 12.0, pull_rope},
          {"rod between rails (Painleve): 1, 2, 0 answers", "closed form", "one instant", 13.0, jam_rod}};
}

}  // namespace tanor::cli
