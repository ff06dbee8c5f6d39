#pragma once

#include <fix.h>

#include <string>
#include <vector>

#include "embed/ranks/distributed_rods.hpp"
#include "embed/ranks/tension_table.hpp"

namespace LAMMPS_NS {

/// Implements fix ID group tanor/rods bond 1 2 … [length initial|VALUE] [tolerance VALUE] [store no|yes|STEPS].
///
/// Bonds of these types between atoms of the group keep their lengths. The scalar is the largest violation. The vector
/// has mean iterations a step, milliseconds of this fix a step, those of them in the solver (of the slowest rank), and
/// the number of bonds. Local data are both tags, type and tension of each bond.
///
/// LAMMPS and LIGGGHTS, which was made of it, ask for the same class, which is compiled with the headers of each.
class FixTanorRods : public Fix {
 public:
  FixTanorRods(LAMMPS* lammps, int num_words, char** words);

  int setmask() override;
  void init() override;
  void setup_pre_exchange() override;
  void setup_pre_neighbor() override { pre_neighbor(); }
  void setup(int vflag) override { measure(0.0, vflag); }
  void min_setup(int vflag) override { min_post_force(vflag); }

  void pre_exchange() override;
  void pre_neighbor() override;
  void post_integrate() override;
  void post_force(int vflag) override;
  void final_integrate() override;

  void min_pre_neighbor() override { pre_neighbor(); }
  void min_pre_force(int) override;
  void min_post_force(int vflag) override;

  int dof(int group) override;
  double compute_scalar() override;
  double compute_vector(int which) override;
  void write_restart(FILE* file) override;
  void restart(char* saved) override;

 private:
  // ---- what each host does its own way: src/bindings/embed/<host>/host.cpp ----

  /// Sets the flags of Fix that only this host has.
  void set_host_flags();
  /// Returns what this host may be told to do that the fix does not support, or an empty text.
  std::string find_unsupported() const;
  [[noreturn]] void end_run(const std::string& trouble);
  void warn(const std::string& text);

  // ---- the same for all ----

  tanor::embed::RodOptions read_options(int num_words, char** words);
  tanor::embed::Atoms atoms() const;
  std::vector<bool> members(int group_bit) const;
  std::vector<tanor::embed::Bond> find_bonds() const;
  void plan(std::vector<tanor::embed::Bond> found);
  void measure(double half_step, int vflag);
  void publish();
  void refuse(const std::string& trouble);

  tanor::embed::RodOptions options_;
  tanor::embed::DistributedRods rods_;
  tanor::embed::TensionTable table_;
};

}  // namespace LAMMPS_NS
