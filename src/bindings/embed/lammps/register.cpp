#include "embed/lammps/register.hpp"

#include <lammps.h>
#include <modify.h>

#include "embed/fix/fix_tanor_rods.hpp"

void tanor_lammps_register(void* lammps) {
  using namespace LAMMPS_NS;
  (*static_cast<LAMMPS*>(lammps)->modify->fix_map)["tanor/rods"] =
      [](LAMMPS* host, int num_words, char** words) -> Fix* { return new FixTanorRods(host, num_words, words); };
}
