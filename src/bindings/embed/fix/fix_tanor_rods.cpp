#include "embed/fix/fix_tanor_rods.hpp"

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <force.h>
#include <group.h>
#include <modify.h>
#include <update.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace LAMMPS_NS {

static_assert(sizeof(tagint) == sizeof(int) && sizeof(imageint) == sizeof(int) && IMGBITS == 10,
              "hosts with 64-bit tags (LAMMPS_BIGBIG) are not supported");

FixTanorRods::FixTanorRods(LAMMPS* lammps, int num_words, char** words)
    : Fix(lammps, num_words, words), options_(read_options(num_words, words)), rods_(world, options_) {
  if (!atom->tag_enable) refuse("atoms need IDs");
  if (atom->molecular != 1) refuse("atoms need an atom_style with bonds");
  scalar_flag = vector_flag = 1;
  size_vector = 4;
  global_freq = 1;
  extscalar = extvector = 0;
  restart_global = 1;
  set_host_flags();
  if (options_.store_every > 0) {
    local_flag = 1;
    local_freq = options_.store_every;
    size_local_rows = 0;
    size_local_cols = tanor::embed::TensionTable::num_columns;
  }
}

tanor::embed::RodOptions FixTanorRods::read_options(int num_words, char** words) {
  try {
    return tanor::embed::read_rod_options({words + 3, static_cast<std::size_t>(num_words - 3)}, atom->nbondtypes);
  } catch (const std::invalid_argument& wrong) {
    end_run(wrong.what());
  }
}

int FixTanorRods::setmask() {
  using namespace FixConst;
  return PRE_EXCHANGE | PRE_NEIGHBOR | POST_INTEGRATE | POST_FORCE | FINAL_INTEGRATE | MIN_PRE_EXCHANGE |
         MIN_PRE_NEIGHBOR | MIN_PRE_FORCE | MIN_POST_FORCE;
}

void FixTanorRods::init() {
  refuse(find_unsupported());
  const auto mine = std::find(modify->fix, modify->fix + modify->nfix, this) - modify->fix;
  for (auto k = mine + 1; k < modify->nfix; ++k) {
    const std::string other = std::string("fix ") + modify->fix[k]->id + " (" + modify->fix[k]->style + ")";
    if (modify->fix[k]->time_integrate) refuse("it must be defined after " + other + ", which integrates");
    if ((modify->fmask[k] & FixConst::POST_FORCE) && comm->me == 0)
      warn("fix tanor/rods does not see the forces of " + other + " in pressure and tensions: define it after that");
  }
  rods_.forget_plan();  // bonds, groups and masses may have changed
}

/// Moves the atoms onto the constraints before forces are evaluated, since these belong to such positions.
void FixTanorRods::setup_pre_exchange() {
  plan(find_bonds());
  refuse(rods_.find_missing_type());
  refuse(rods_.start(atoms()));
  rods_.reset_times();
}

// ---- whenever atoms go to other ranks ----

/// Takes bonds that were made or broken since, as by fix bond/create. Those who make them ask for new neighbour lists
/// in the same step.
void FixTanorRods::pre_exchange() {
  std::vector<tanor::embed::Bond> found;
  {
    const tanor::embed::CpuClock clock = rods_.clock();  // a plan and a start have clocks of their own
    found = find_bonds();
    if (!rods_.differ_from(found)) return;
  }
  plan(std::move(found));
  refuse(rods_.start(atoms()));
}

void FixTanorRods::pre_neighbor() {
  refuse(rods_.list(atoms()));
}

std::vector<tanor::embed::Bond> FixTanorRods::find_bonds() const {
  std::vector<tanor::embed::Bond> found;
  for (int i = 0; i < atom->nlocal; ++i)
    for (int k = 0; k < atom->num_bond[i]; ++k)
      if (std::find(options_.types.begin(), options_.types.end(), atom->bond_type[i][k]) != options_.types.end())
        found.push_back({atom->tag[i], atom->bond_atom[i][k], atom->bond_type[i][k], 0.0});
  return found;
}

void FixTanorRods::plan(std::vector<tanor::embed::Bond> found) {
  refuse(rods_.plan(atoms(), std::move(found), members(groupbit), comm->nthreads, update->whichflag == 2));
  publish();
}

// ---- a step ----

void FixTanorRods::post_integrate() {
  refuse(rods_.constrain_positions(atoms(), update->dt));
}

void FixTanorRods::post_force(int vflag) {
  const bool stores = options_.store_every > 0 && update->ntimestep % options_.store_every == 0;
  if (stores || vflag != 0) measure(0.5 * update->dt, vflag);
}

void FixTanorRods::final_integrate() {
  refuse(rods_.constrain_velocities(atoms(), update->dt));
}

void FixTanorRods::measure(double half_step, int vflag) {
  v_setup(vflag);
  refuse(rods_.measure(atoms(), half_step, force->ftm2v, vflag_atom != 0));
  publish();
}

// ---- a step of a minimisation ----

void FixTanorRods::min_pre_force(int) {
  refuse(rods_.project_positions(atoms()));
  comm->forward_comm();
}

void FixTanorRods::min_post_force(int vflag) {
  v_setup(vflag);
  refuse(rods_.project_forces(atoms(), vflag_atom != 0));
  publish();
}

// ---- what the host asks ----

int FixTanorRods::dof(int group_number) {
  if (!rods_.is_planned()) plan(find_bonds());
  return static_cast<int>(rods_.count_constraints(members(group->bitmask[group_number])));
}

double FixTanorRods::compute_scalar() {
  if (!rods_.is_planned()) return 0.0;
  return rods_.violation(atoms());
}

double FixTanorRods::compute_vector(int which) {
  const auto& times = rods_.times();
  const double steps = static_cast<double>(std::max(1L, times.steps));
  const double mine[] = {static_cast<double>(times.iterations) / steps, 1e3 * times.all / steps,
                         1e3 * times.solver / steps, static_cast<double>(rods_.num_bonds())};
  double largest = 0.0;
  MPI_Allreduce(&mine[which], &largest, 1, MPI_DOUBLE, MPI_MAX, world);
  return largest;
}

void FixTanorRods::write_restart(FILE* file) {
  if (comm->me != 0) return;
  const std::vector<double> saved = rods_.save_lengths();
  const int size = static_cast<int>(saved.size() * sizeof(double));
  fwrite(&size, sizeof(int), 1, file);
  fwrite(saved.data(), sizeof(double), saved.size(), file);
}

void FixTanorRods::restart(char* saved) {
  rods_.restore_lengths(reinterpret_cast<const double*>(saved));
}

// ---- parts ----

tanor::embed::Atoms FixTanorRods::atoms() const {
  const double* const h = domain->h;  // xx yy zz yz xz xy
  return {.count = atom->nlocal,
          .tag = atom->tag,
          .image = atom->image,
          .x = atom->x[0],
          .v = atom->v[0],
          .f = atom->f[0],
          .stress = vatom != nullptr ? vatom[0] : nullptr,
          .masses = atom->rmass,
          .type_masses = atom->mass,
          .type = atom->type,
          .box = {.edges = {{{h[0], 0.0, 0.0}, {h[5], h[1], 0.0}, {h[4], h[3], h[2]}}},
                  .repeats = {domain->xperiodic != 0, domain->yperiodic != 0, domain->zperiodic != 0}}};
}

std::vector<bool> FixTanorRods::members(int group_bit) const {
  std::vector<bool> result(atom->nlocal);
  for (int i = 0; i < atom->nlocal; ++i) result[i] = (atom->mask[i] & group_bit) != 0;
  return result;
}

/// Puts virial and tensions where the host looks for them.
void FixTanorRods::publish() {
  std::copy(rods_.virial().begin(), rods_.virial().end(), virial);
  if (options_.store_every == 0) return;
  table_.fill(rods_.own_bonds(), rods_.tensions());
  array_local = table_.rows();
  size_local_rows = table_.num_rows();
}

void FixTanorRods::refuse(const std::string& trouble) {
  if (!trouble.empty()) end_run(trouble);
}

}  // namespace LAMMPS_NS
