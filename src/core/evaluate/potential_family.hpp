#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/block3.hpp"
#include "base/parallel.hpp"
#include "evaluate/series_program.hpp"
#include "kinds/energy_groups.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Tuples of p points with one energy U(r_1 … r_p, t), in the inner order.
///
/// Forces and energies of built-in laws are written by hand. Otherwise, and for all stiffness, eight tuples run side by
/// side if U is known as an expression: forwards for U, backwards for its gradient, and both once more with a step
/// along each coordinate for the columns of the Hessian. Without an expression the kernel is called. Each tuple writes
/// what is its own, so any number of threads gives the same bits. Where U is not finite, neither is its gradient.
class PotentialFamily {
 public:
  PotentialFamily(EnergyGroup group, const Numbering& numbering);

  std::size_t size() const { return size_; }
  std::size_t points_per_member() const { return p_; }
  Index point(std::size_t k, std::size_t i) const { return points_[i * stride_ + k]; }
  bool depends_on_time() const { return group_.kernel.depends_on_time; }

  /// Writes -dU/dr [p][member][3], N, and the explicit dU/dt [member], W, if U depends on time.
  void evaluate_forces(const Parallel& parallel, double t, const double* r, double* forces, double* rates) const;
  /// Writes U [member], J.
  void evaluate_energies(const Parallel& parallel, double t, const double* r, double* energies) const;
  /// Writes -d2U/dr_i dr_j' [member][p][p], N/m.
  void evaluate_stiffness(const Parallel& parallel, double t, const double* r, Block3* blocks) const;

  /// Names the first tuple whose energy or force is not finite, and why. Returns an empty string if there is none.
  std::string find_undefined(const Parallel& parallel, double t, const double* r) const;

 private:
  /// Input and output of tuples that run side by side. Output that is not wanted is null.
  struct Chunk {
    std::size_t first, count;
    double t;
    const double* r;
    double *energies, *gradients, *hessians, *rates;  // begin at the chunk's first member; gradients [member][3p]
  };
  void run(const Chunk& chunk) const;
  void run_program(const Chunk& chunk) const;
  void run_kernel(const Chunk& chunk) const;
  SeriesLane* load_lanes(const Chunk& chunk, int order) const;
  template <class Body>
  void for_chunks(const Parallel& parallel, const Body& body) const;
  void run_by_hand(const Parallel& parallel, const double* r, double* forces, double* energies) const;

  EnergyGroup group_;      // its arrays are member by member, with the user's points
  SeriesProgram program_;  // empty if the kernel is a black box
  std::size_t p_, num_constants_, size_, stride_;
  std::vector<Index> points_;      // [p][stride]
  std::vector<char> in_a_row_;     // [p][stride/8]
  std::vector<double> constants_;  // [constant][stride]
  std::vector<double> prepared_;   // [number][stride]
};

}  // namespace tanor::detail
