#pragma once

#include <tanor/system.hpp>

/// A net of side x side points that two neighbouring corners hold, 0.1 kg each on rods of 0.1 m: flat at the start.
/// Unequal: 0.05 to 0.15 kg, from columns that are light below to such that are heavy there, so that no two of them,
/// each of which swings by itself, have a frequency in common.
inline tanor::System make_hung_net(int side, bool has_unequal_masses = false) {
  tanor::System system;
  tanor::Rods rods{.name = "rods"};
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      system.positions.insert(system.positions.end(), {0.1 * column, 0.1 * row, 0.0});
      const tanor::Index point = row * side + column;
      const double x = 2.0 * column / (side - 1) - 1.0, y = 2.0 * row / (side - 1) - 1.0;
      system.masses.push_back(has_unequal_masses ? 0.1 + 0.05 * x * y : 0.1);
      if (column > 0) rods.pairs.push_back({point - 1, point});
      if (row > 0) rods.pairs.push_back({point - side, point});
    }
  }
  system.supports = {tanor::Support{"", {0, side - 1}}};
  system.constraints = {rods};
  system.forces = {tanor::Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}
