#pragma once

#include <span>
#include <vector>

#include "base/block3.hpp"
#include "base/parallel.hpp"
#include "evaluate/series_program.hpp"
#include "kinds/energy_groups.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// Tuples of p points with one energy U(r_1 … r_p, t), in the inner order.
///
/// Where U is known as an expression, eight tuples run side by side: forwards for U, backwards for its gradient, and
/// both once more with a step along each coordinate for the columns of the Hessian. Otherwise the kernel is called.
/// Each tuple writes what is its own, so any number of threads gives the same bits.
class PotentialFamily {
 public:
  PotentialFamily(const EnergyGroup& group, const Numbering& numbering);

  std::size_t size() const { return points_.size() / p_; }
  std::size_t points_per_member() const { return p_; }
  Index point(std::size_t k, std::size_t i) const { return points_[k * p_ + i]; }
  bool depends_on_time() const { return kernel_.depends_on_time; }

  /// -dU/dr [member][p][3], N, and the explicit dU/dt [member], W, where U depends on time.
  void evaluate_forces(const Parallel& parallel, double t, const double* r, double* forces, double* rates) const;
  /// U [member], J.
  void evaluate_energies(const Parallel& parallel, double t, const double* r, double* energies) const;
  /// -d2U/dr_i dr_j' [member][p][p], N/m.
  void evaluate_stiffness(const Parallel& parallel, double t, const double* r, Block3* blocks) const;

 private:
  /// Of tuples that run side by side; what is not wanted is null.
  struct Chunk {
    std::size_t first, count;
    double t;
    const double* r;
    double *energies, *gradients, *hessians, *rates;  // from the chunk's first member on
  };
  void run(const Chunk& chunk) const;
  void run_program(const Chunk& chunk) const;
  void run_kernel(const Chunk& chunk) const;
  SeriesLane* load_lanes(const Chunk& chunk, int order) const;

  PotentialKernel kernel_;
  SeriesProgram program_;  // empty where the kernel is a black box
  std::size_t p_, num_constants_;
  std::vector<Index> points_;      // [member][p]
  std::vector<double> constants_;  // [member][constant]
};

}  // namespace tanor
