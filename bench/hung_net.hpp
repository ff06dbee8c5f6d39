#pragma once

#include <tanor/system.hpp>

/// A net of side x side points that two neighbouring corners hold, 0.1 kg each on rods of 0.1 m: flat at the start.
inline tanor::System make_hung_net(int side) {
  tanor::System system;
  tanor::Rods rods{.name = "rods"};
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      system.positions.insert(system.positions.end(), {0.1 * column, 0.1 * row, 0.0});
      system.masses.push_back(0.1);
      const tanor::Index point = row * side + column;
      if (column > 0) rods.pairs.push_back({point - 1, point});
      if (row > 0) rods.pairs.push_back({point - side, point});
    }
  }
  system.supports = {tanor::Support{"", {0, side - 1}}};
  system.constraints = {rods};
  system.forces = {tanor::Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}
