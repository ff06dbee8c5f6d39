#include <input.h>
#include <lammps.h>
#include <mpi.h>

#include "embed/lammps/register.hpp"

/// Runs lmp with tanor/rods, for those who have no Python there.
int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  auto* const lammps = new LAMMPS_NS::LAMMPS(argc, argv, MPI_COMM_WORLD);
  tanor_lammps_register(lammps);
  lammps->input->file();
  delete lammps;
  MPI_Finalize();
}
