#pragma once

#include <utility>

#include <tanor/tanor.hpp>

#include "unseen.hpp"

/// \file A point and a block that a force moves for a short time.
namespace tanor::unseen_scenes {

using Shape = Unseen::Shape;

inline System make_free_point() {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  return system;
}

inline ScalarFunction formula_of(const Unseen& g) {
  return ScalarFunction::formula(g.text());
}

inline VectorFunction along_x(ScalarFunction g) {
  return {std::move(g), 0.0, 0.0};
}

/// 1 kg on a rail along x under g = 10.
inline System make_block(double mu, VectorFunction belt) {
  System system = make_free_point();
  system.constraints = {Lines{.name = "rail", .points = {0}, .origin = Vector3{}, .direction = Vector3{1.0, 0.0, 0.0}}};
  system.forces = {Gravity{.acceleration = {0.0, 0.0, -10.0}}};
  system.friction = {Coulomb{.at = {"rail"}, .coefficient = mu, .velocity = std::move(belt)}};
  return system;
}

}  // namespace tanor::unseen_scenes
