#pragma once

#include <vector>

#include "evaluate/pair_field.hpp"

/// \file The forces and the potential of the pairs of a system, in the user's order.
namespace tanor {
using namespace detail;

/// The forces on all points, in the user's order, and the potential.
struct PairResult {
  std::vector<double> f;
  double potential = 0.0;
  bool operator==(const PairResult&) const = default;
};

/// Evaluates a system's only group of pair forces at places in the user's order. It reuses its state between calls.
class PairEvaluator {
 public:
  explicit PairEvaluator(const System& system, int threads = 1)
      : numbering_(number(system)),
        field_(system, std::get<PairForces>(system.forces[0]), numbering_),
        of_supports_(system, std::get<PairForces>(system.forces[0]), numbering_, PairField::Which::OfSupports),
        parallel_(threads) {}

  PairResult operator()(const std::vector<double>& places) {
    std::vector<double> r(places.size()), f(places.size(), 0.0);
    numbering_.gather_points(places, r);
    field_.add_forces(parallel_, r.data(), f.data());
    if (!of_supports_.empty()) of_supports_.add_forces(parallel_, r.data(), f.data());
    PairResult result{std::vector<double>(places.size()), field_.potential(parallel_, r.data())};
    numbering_.scatter_points(f, result.f);
    return result;
  }

 private:
  Numbering numbering_;
  PairField field_, of_supports_;
  Parallel parallel_;
};

/// Returns two unit masses at this distance along y, which feel these pair forces.
inline System make_two_points(const PairForces& pairs, double distance) {
  System system;
  system.positions = {1.0, 2.0, 3.0, 1.0, 2.0 + distance, 3.0};
  system.masses = {1.0, 1.0};
  system.forces = {pairs};
  return system;
}

}  // namespace tanor
