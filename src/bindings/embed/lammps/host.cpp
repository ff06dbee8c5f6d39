/// \file The parts of fix tanor/rods that are special to LAMMPS.

#include <error.h>
#include <update.h>

#include <string>

#include "embed/fix/fix_tanor_rods.hpp"

namespace LAMMPS_NS {

void FixTanorRods::set_host_flags() {
  dof_flag = 1;
  virial_global_flag = virial_peratom_flag = thermo_virial = 1;
}

std::string FixTanorRods::find_unsupported() const {
  const bool has_levels =
      update->whichflag == 1 && std::string(update->integrate_style).find("respa") != std::string::npos;
  return has_levels ? "run_style respa is not supported" : "";
}

void FixTanorRods::end_run(const std::string& trouble) {
  error->all(FLERR, "fix tanor/rods: " + trouble);
}

void FixTanorRods::warn(const std::string& text) {
  error->warning(FLERR, text);
}

}  // namespace LAMMPS_NS
