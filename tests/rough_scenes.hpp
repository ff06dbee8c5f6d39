#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <variant>

#include <tanor/system.hpp>

/// Systems with friction that several tests share.
namespace tanor::scenes {

/// Returns a mass of 2 kg that slides downhill with `speed`, m/s, on a rough line inclined by 30 degrees (case 04a).
inline System make_rough_incline(double speed, double mu) {
  const double alpha = std::numbers::pi / 6.0;
  const Vector3 downhill{std::cos(alpha), -std::sin(alpha), 0.0};
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.velocities = {speed * downhill[0], speed * downhill[1], 0.0};
  system.masses = {2.0};
  system.constraints = {Lines{"rail", {0}, Vector3{}, downhill}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  system.friction = {Coulomb{.name = "", .at = {"rail"}, .coefficient = mu}};
  return system;
}

/// Returns a block of 1 kg at rest on a rough rail along x, under g = 10 m/s^2.
inline System make_block_on_rail(double mu) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Lines{"rail", {0}, Vector3{}, Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{"", {0.0, 0.0, -10.0}}};
  system.friction = {Coulomb{.name = "", .at = {"rail"}, .coefficient = mu}};
  return system;
}

/// Painleve's problem (case 10b) has a rod of slope `alpha`, degrees, between a rough rail and a smooth one 1 m above
/// it. Its beads slide with 1 m/s and are pushed along the rails by f1 and f2, N. The rough rail carries the first one.
struct Rails {
  double mu, f2;
  double alpha = 75.0, m1 = 1.0, m2 = 1.0, f1 = 0.0;
};

inline System make_rails(const Rails& rails) {
  const double alpha = rails.alpha * std::numbers::pi / 180.0;
  const Vector3 along{1.0, 0.0, 0.0};
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0 / std::tan(alpha), 1.0, 0.0};
  system.velocities = {1.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.masses = {rails.m1, rails.m2};
  system.constraints = {Lines{"rough", {0}, Vector3{}, along}, Lines{"smooth", {1}, Vector3{0.0, 1.0, 0.0}, along},
                        Rods{"rod", {{0, 1}}, {}, {}}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}, ConstantForce{"", {0}, Vector3{rails.f1, 0.0, 0.0}},
                   ConstantForce{"", {1}, Vector3{rails.f2, 0.0, 0.0}}};
  system.friction = {Coulomb{.name = "rust", .at = {"rough"}, .coefficient = rails.mu}};
  return system;
}

/// Returns the same rails with mu = 0.6, beads at 30 m/s, and a rod whose upper end is D(t) = 0.4 + 0.2 cos t ahead of
/// the lower one, since it is pushed by F + D''. `push` is the formula of F, N.
inline System make_telescope(const std::string& push) {
  const Vector3 along{1.0, 0.0, 0.0};
  System system;
  system.positions = {0.0, 0.0, 0.0, 0.6, 1.0, 0.0};
  system.velocities = {30.0, 0.0, 0.0, 30.0, 0.0, 0.0};
  system.masses = {1.0, 1.0};
  system.constraints = {Lines{"rough", {0}, Vector3{}, along}, Lines{"smooth", {1}, Vector3{0.0, 1.0, 0.0}, along},
                        Rods{"rod", {{0, 1}}, ScalarFunction::formula("sqrt(1 + (0.4 + 0.2*cos(t))^2)"), {}}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}},
                   ConstantForce{"", {1}, VectorFunction{ScalarFunction::formula(push + " - 0.2*cos(t)"), 0.0, 0.0}}};
  system.friction = {Coulomb{.name = "rust", .at = {"rough"}, .coefficient = 0.6}};
  return system;
}

/// Returns a bead of 1.3 kg at the angle theta from the bottom of a rough hoop of 0.7 m, which turns about its vertical
/// diameter. `turn` is the angle of the hoop, a formula, and omega is its rate at the start.
inline System make_rough_hoop(double theta, const std::string& turn, double omega, double mu, double mu_s) {
  constexpr double radius = 0.7;
  System system;
  system.positions = {radius * std::sin(theta), 0.0, -radius * std::cos(theta)};
  system.velocities = {0.0, omega * radius * std::sin(theta), 0.0};
  system.masses = {1.3};
  const VectorFunction normal{ScalarFunction::formula("sin(" + turn + ")"),
                              ScalarFunction::formula("-cos(" + turn + ")"), 0.0};
  system.constraints = {Circles{"hoop", {0}, Vector3{}, normal, radius}};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  system.friction = {Coulomb{.name = "", .at = {"hoop"}, .coefficient = mu, .static_coefficient = mu_s}};
  return system;
}

/// Returns a bead on a rough hoop that turns faster and faster, by its angle.
inline System make_bead_by_its_angle() {
  System system = make_rough_hoop(0.9, "3.8*t + t^2", 3.8, 0.3, 0.35);
  const auto& hoop = std::get<Circles>(system.constraints[0]);
  system.coordinates = {CircleCoordinates{"", hoop.points, hoop.center, hoop.normal, hoop.radius}};
  return system;
}

}  // namespace tanor::scenes
