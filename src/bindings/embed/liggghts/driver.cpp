#include <mpi.h>
//
#include <fix.h>
#include <input.h>
#include <lammps.h>
#include <modify.h>

#include "embed/fix/fix_tanor_rods.hpp"

namespace {

using namespace LAMMPS_NS;

/// LIGGGHTS keeps its list of fixes private. An explicit instantiation may name what is private.
template <auto member>
struct Opened {
  friend auto& fix_map_of(Modify* modify) { return *(modify->*member); }
};
auto& fix_map_of(Modify* modify);
template struct Opened<&Modify::fix_map>;

}  // namespace

/// Runs liggghts with tanor/rods.
int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  auto* const liggghts = new LAMMPS(argc, argv, MPI_COMM_WORLD);
  fix_map_of(liggghts->modify)["tanor/rods"] = [](LAMMPS* host, int num_words, char** words) -> Fix* {
    return new FixTanorRods(host, num_words, words);
  };
  liggghts->input->file();
  delete liggghts;
  MPI_Finalize();
}
