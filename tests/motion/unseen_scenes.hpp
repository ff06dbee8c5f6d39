#pragma once

#include <utility>
#include <variant>

#include <tanor/tanor.hpp>

#include "rough_scenes.hpp"
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

/// Makes a block on a belt.
inline System make_block(double mu, VectorFunction belt) {
  System system = scenes::make_block_on_rail(mu);
  std::get<Coulomb>(system.friction[0]).velocity = std::move(belt);
  return system;
}

}  // namespace tanor::unseen_scenes
