#pragma once

#include <fix.h>

#include <string>
#include <vector>

#include "embed/ranks/distributed_rods.hpp"
#include "embed/ranks/tension_table.hpp"

namespace LAMMPS_NS {

/// The fix of src/embed/lammps, for LIGGGHTS, which does not minimise.
///
/// fix ID group tanor/rods bond 1 2 … [length initial|VALUE] [tolerance VALUE] [store no|yes|STEPS]
///
/// Bonds of these types between atoms of the group keep their lengths. Scalar: the largest violation. Vector: mean
/// iterations a step, milliseconds of this fix a step, of them in the solver (of the slowest rank), number of bonds.
/// Local: both tags, type and tension of each bond.
class FixTanorRods : public Fix {
 public:
  FixTanorRods(LAMMPS* lammps, int num_words, char** words);

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override { pre_neighbor(); }
  void setup(int) override { measure(0.0); }

  void pre_neighbor() override;
  void post_integrate() override;
  void post_force(int) override;
  void final_integrate() override;

  int dof(int group) override;
  double compute_scalar() override;
  double compute_vector(int which) override;
  void write_restart(FILE* file) override;
  void restart(char* saved) override;

 private:
  tanor::embed::Atoms atoms() const;
  std::vector<bool> members(int group_bit) const;
  void plan();
  void measure(double half_step);
  void publish();
  void refuse(const std::string& trouble);

  tanor::embed::RodOptions options_;
  tanor::embed::DistributedRods rods_;
  tanor::embed::TensionTable table_;
};

}  // namespace LAMMPS_NS
