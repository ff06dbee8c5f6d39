/// \file What fix tanor/rods does its own way inside LIGGGHTS.

#include <error.h>
#include <update.h>

#include <cstdlib>
#include <string>

#include "embed/fix/fix_tanor_rods.hpp"

namespace LAMMPS_NS {

void FixTanorRods::set_host_flags() {
  virial_flag = 1;
}

/// Contacts of grains have no energy, and the minimiser of 3.8 loses atoms with bonds at its first step without us,
/// too.
std::string FixTanorRods::find_unsupported() const {
  return update->whichflag == 2 ? "minimize is not supported" : "";
}

void FixTanorRods::end_run(const std::string& trouble) {
  error->fix_error(FLERR, this, trouble.c_str());
  std::abort();  // it has ended the process
}

void FixTanorRods::warn(const std::string& text) {
  error->warning(FLERR, text.c_str());
}

}  // namespace LAMMPS_NS
