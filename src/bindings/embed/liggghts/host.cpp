/// \file The parts of fix tanor/rods that are special to LIGGGHTS.

#include <error.h>
#include <update.h>

#include <cstdlib>
#include <string>

#include "embed/fix/fix_tanor_rods.hpp"

namespace LAMMPS_NS {

void FixTanorRods::set_host_flags() {
  virial_flag = 1;
}

/// Refuses minimisation. Contacts of grains have no energy, and the minimiser of 3.8 loses atoms with bonds at its
/// first step even without this fix.
std::string FixTanorRods::find_unsupported() const {
  return update->whichflag == 2 ? "minimize is not supported" : "";
}

void FixTanorRods::end_run(const std::string& trouble) {
  error->fix_error(FLERR, this, trouble.c_str());
  std::abort();  // fix_error has ended the process
}

void FixTanorRods::warn(const std::string& text) {
  error->warning(FLERR, text.c_str());
}

}  // namespace LAMMPS_NS
