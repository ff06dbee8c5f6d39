#pragma once

#include <span>

#include "base/point_path.hpp"

namespace tanor::detail {

/// Pair forces between points of this process and those of others. All functions are collective.
class PairsBeyond {
 public:
  virtual ~PairsBeyond() = default;

  /// Adds what others' points do to those of this process to f, N [3n].
  virtual void add_forces(const double* r, double* f) = 0;
  /// Returns half of the energy of these pairs, J; the other process counts the other half.
  virtual double potential(const double* r) = 0;
  /// Finds what a step passes unseen as PairField does. `masses` are [moving point], kg.
  virtual double find_unseen(const PointPath& path, std::span<const double> masses) = 0;
};

}  // namespace tanor::detail
