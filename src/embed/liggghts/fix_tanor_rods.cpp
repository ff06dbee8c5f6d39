#include "embed/liggghts/fix_tanor_rods.hpp"

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <error.h>
#include <force.h>
#include <group.h>
#include <modify.h>
#include <update.h>

#include <algorithm>
#include <stdexcept>

namespace LAMMPS_NS {
namespace {

static_assert(sizeof(tagint) == sizeof(int) && sizeof(imageint) == sizeof(int) && IMGBITS == 10,
              "LIGGGHTS with 64-bit tags (LAMMPS_BIGBIG) is not supported");

tanor::embed::RodOptions read(Error* error, Fix* fix, int num_words, char** words, int num_bond_types) {
  try {
    return tanor::embed::read_rod_options({words + 3, static_cast<std::size_t>(num_words - 3)}, num_bond_types);
  } catch (const std::invalid_argument& wrong) {
    error->fix_error(FLERR, fix, wrong.what());
    throw;  // it has ended the process
  }
}

}  // namespace

FixTanorRods::FixTanorRods(LAMMPS* lammps, int num_words, char** words)
    : Fix(lammps, num_words, words),
      options_(read(error, this, num_words, words, atom->nbondtypes)),
      rods_(world, options_) {
  if (!atom->tag_enable) refuse("atoms need IDs");
  if (atom->molecular != 1) refuse("atoms need an atom_style with bonds");
  scalar_flag = vector_flag = 1;
  size_vector = 4;
  global_freq = 1;
  extscalar = extvector = 0;
  virial_flag = 1;
  restart_global = 1;
  if (options_.store_every > 0) {
    local_flag = 1;
    local_freq = options_.store_every;
    size_local_rows = 0;
    size_local_cols = tanor::embed::TensionTable::num_columns;
  }
}

int FixTanorRods::setmask() {
  using namespace FixConst;
  return PRE_EXCHANGE | PRE_NEIGHBOR | POST_INTEGRATE | POST_FORCE | FINAL_INTEGRATE;
}

void FixTanorRods::init() {
  const auto mine = std::find(modify->fix, modify->fix + modify->nfix, this) - modify->fix;
  for (auto k = mine + 1; k < modify->nfix; ++k) {
    const std::string other = std::string("fix ") + modify->fix[k]->id + " (" + modify->fix[k]->style + ")";
    if (modify->fix[k]->time_integrate) refuse("it must be defined after " + other + ", which integrates");
    if ((modify->fmask[k] & FixConst::POST_FORCE) && comm->me == 0)
      error->warning(FLERR, ("fix tanor/rods does not see the forces of " + other +
                             " in pressure and tensions: define it after that")
                                .c_str());
  }
  rods_.forget_plan();  // bonds, groups and masses may have changed
}

/// Forces are evaluated after this: they belong to positions on the constraints.
void FixTanorRods::setup_pre_exchange() {
  plan();
  refuse(rods_.start(atoms()));
}

void FixTanorRods::plan() {
  std::vector<tanor::embed::Bond> found;
  for (int i = 0; i < atom->nlocal; ++i)
    for (int k = 0; k < atom->num_bond[i]; ++k)
      if (std::find(options_.types.begin(), options_.types.end(), atom->bond_type[i][k]) != options_.types.end())
        found.push_back({atom->tag[i], atom->bond_atom[i][k], atom->bond_type[i][k], 0.0});
  refuse(rods_.plan(atoms(), std::move(found), members(groupbit), comm->nthreads, false));
  publish();
}

void FixTanorRods::pre_neighbor() {
  refuse(rods_.list(atoms()));
}

// ---- a step ----

void FixTanorRods::post_integrate() {
  refuse(rods_.constrain_positions(atoms(), update->dt));
}

void FixTanorRods::post_force(int) {
  const bool stores = options_.store_every > 0 && update->ntimestep % options_.store_every == 0;
  if (stores || update->vflag_global == update->ntimestep) measure(0.5 * update->dt);
}

void FixTanorRods::final_integrate() {
  refuse(rods_.constrain_velocities(atoms(), update->dt));
}

void FixTanorRods::measure(double half_step) {
  refuse(rods_.measure(atoms(), half_step, force->ftm2v));
  publish();
}

// ---- what the host asks ----

int FixTanorRods::dof(int group_number) {
  if (!rods_.is_planned()) plan();
  return static_cast<int>(rods_.count_constraints(atoms(), members(group->bitmask[group_number])));
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

/// Virial and tensions where the host looks for them.
void FixTanorRods::publish() {
  std::copy(rods_.virial().begin(), rods_.virial().end(), virial);
  if (options_.store_every == 0) return;
  table_.fill(rods_.own_bonds(), rods_.tensions());
  array_local = table_.rows();
  size_local_rows = table_.num_rows();
}

void FixTanorRods::refuse(const std::string& trouble) {
  if (!trouble.empty()) error->fix_error(FLERR, this, trouble.c_str());
}

}  // namespace LAMMPS_NS
