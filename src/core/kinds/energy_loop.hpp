#pragma once

#include <cstddef>
#include <memory>

#include <tanor/kinds.hpp>

#include "kinds/energy_kernels.hpp"

namespace tanor::detail {

/// Members [first, last) of a family, `first` a multiple of eight. Arrays of points and numbers stand column by column,
/// filled up with their last member to `stride`, a multiple of eight.
struct EnergyRange {
  std::size_t first, last, stride;
  const double* r;        ///< [3n] m
  const Index* points;    ///< [p][stride], inner
  const char* in_a_row;   ///< [p][stride/8] not 0 if eight points follow one another
  const double* numbers;  ///< [number][stride]
  double* forces;         ///< [p][size][3] -dU/dr, N; null: not wanted
  double* energies;       ///< [size] U, J; null: not wanted
  std::size_t size;       ///< members of the family
};

/// A hand-written loop for a built-in energy of many members.
struct EnergyLoop {
  std::shared_ptr<const void> law{};
  std::size_t num_numbers = 0;
  void (*run)(const void* law, const EnergyRange& range) = nullptr;

  explicit operator bool() const { return run != nullptr; }
};

EnergyLoop make_energy_loop(const Bonds& bonds);
EnergyLoop make_energy_loop(const Bendings& bendings);
EnergyLoop make_energy_loop(const Torsions& torsions);

}  // namespace tanor::detail
