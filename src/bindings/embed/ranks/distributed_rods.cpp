#include "embed/ranks/distributed_rods.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <string_view>
#include <utility>

namespace tanor::embed {
namespace {

/// Atoms that violate the constraints by no more than this stay where they are, bit by bit.
constexpr double on_constraints = 1e-12;
/// A larger relative violation after a step, beyond the tolerance, ends the run.
constexpr double off_constraints = 1e-10;

PeriodicCell cell_of(const Box& box) {
  return {.edges = {{box.edges[0], box.edges[1], box.edges[2]}}, .repeats = box.repeats};
}

std::string name(const Bond& bond) {
  return "the bond of type " + std::to_string(bond.type) + " between atoms " + std::to_string(bond.a) + " and " +
         std::to_string(bond.b);
}

double norm(const std::array<double, 3>& d) {
  return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/// Returns the bonds of all ranks, each once, by tags.
std::vector<Bond> unite(const std::vector<Bond>& found, MPI_Comm world) {
  constexpr int width = 3;
  std::vector<int> mine;
  for (const Bond& bond : found) mine.insert(mine.end(), {bond.a, bond.b, bond.type});
  int num_ranks = 1, size = static_cast<int>(mine.size());
  MPI_Comm_size(world, &num_ranks);
  std::vector<int> counts(num_ranks), starts(num_ranks + 1, 0);
  MPI_Allgather(&size, 1, MPI_INT, counts.data(), 1, MPI_INT, world);
  for (int p = 0; p < num_ranks; ++p) starts[p + 1] = starts[p] + counts[p];
  std::vector<int> all(starts[num_ranks]);
  MPI_Allgatherv(mine.data(), size, MPI_INT, all.data(), counts.data(), starts.data(), MPI_INT, world);
  std::vector<Bond> bonds;
  for (std::size_t k = 0; k < all.size(); k += width)
    bonds.push_back({std::min(all[k], all[k + 1]), std::max(all[k], all[k + 1]), all[k + 2], 0.0});
  std::sort(bonds.begin(), bonds.end());
  const auto end = std::unique(bonds.begin(), bonds.end(), [](const Bond& a, const Bond& b) { return a.joins_as(b); });
  bonds.erase(end, bonds.end());
  return bonds;
}

/// Returns a number for the bonds of all ranks, whichever rank has them in whatever order. Other bonds have another
/// number.
std::uint64_t mark(const std::vector<Bond>& found, MPI_Comm world) {
  const auto scramble = [](std::uint64_t x) {  // finalizer of MurmurHash3
    x = (x ^ (x >> 33)) * 0xff51afd7ed558ccdULL;
    x = (x ^ (x >> 33)) * 0xc4ceb9fe1a85ec53ULL;
    return x ^ (x >> 33);
  };
  const auto bits = [](int x) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)); };
  std::uint64_t mine = 0, all = 0;
  for (const Bond& bond : found)
    mine += scramble(scramble(bits(std::min(bond.a, bond.b)) << 32 | bits(std::max(bond.a, bond.b))) + bits(bond.type));
  MPI_Allreduce(&mine, &all, 1, MPI_UINT64_T, MPI_SUM, world);
  return all;
}

}  // namespace

DistributedRods::DistributedRods(MPI_Comm world, RodOptions options) : options_(std::move(options)), islands_(world) {}

// ---- before a run ----

std::string DistributedRods::plan(const Atoms& atoms, const std::vector<Bond>& found,
                                  const std::vector<bool>& is_member, int threads, bool unit_masses) {
  forget_plan();
  has_unit_masses_ = unit_masses;
  mark_ = mark(found, islands_.world());
  if (std::string trouble = take_bonds(atoms, found, is_member); !trouble.empty()) return trouble;
  if (std::string trouble = list(atoms); !trouble.empty()) return trouble;
  const std::size_t n = islands_.num_points();
  for (std::vector<double>* const array : {&at_.r, &at_.old, &at_.move, &at_.v, &at_.f}) array->assign(3 * n, 0.0);
  at_.masses.assign(n, 1.0);
  tensions_.assign(own_bonds_.size(), 0.0);
  virial_ = {};
  if (!unit_masses)
    islands_.to_owners<1>([](int) {}, [&](int i, double* mass) { *mass = atoms.mass(i); },
                          [&](int point, const double* mass) { at_.masses[point] = *mass; });
  gather_positions(atoms);
  box_ = atoms.box;
  if (std::string trouble = find_lengths(); !trouble.empty()) return trouble;
  std::string trouble = call([&] { return make_constrainer(threads); });
  is_planned_ = trouble.empty();
  return trouble;
}

void DistributedRods::forget_plan() {
  constrainer_.reset();
  is_planned_ = false;
}

bool DistributedRods::differ_from(const std::vector<Bond>& found) const {
  return mark(found, islands_.world()) != mark_;
}

std::string DistributedRods::find_missing_type() const {
  for (const int type : options_.types)
    if (std::none_of(bonds_.begin(), bonds_.end(), [&](const Bond& bond) { return bond.type == type; }))
      return "no bond of type " + std::to_string(type) + " joins two atoms of the group";
  return {};
}

std::string DistributedRods::list(const Atoms& atoms) {
  const CpuClock clock(&times_.all);
  return islands_.list(atoms.tags());
}

std::string DistributedRods::take_bonds(const Atoms& atoms, const std::vector<Bond>& found,
                                        const std::vector<bool>& is_member) {
  std::vector<Bond> united = unite(found, islands_.world());
  int highest = 0;
  for (const Bond& bond : united) highest = std::max(highest, bond.b);

  // [tag] twice the rank that has the atom, plus one if it is a member of the group; -1 if no rank has it.
  std::vector<int> mine(highest + 1, -1), home(highest + 1, -1);
  for (int i = 0; i < atoms.count; ++i)
    if (atoms.tag[i] <= highest) mine[atoms.tag[i]] = 2 * islands_.rank() + (is_member[i] ? 1 : 0);
  MPI_Allreduce(mine.data(), home.data(), highest + 1, MPI_INT, MPI_MAX, islands_.world());
  for (const Bond& bond : united)
    for (const int tag : {bond.a, bond.b})
      if (home[tag] < 0) return "atom " + std::to_string(tag) + " was lost: " + name(bond) + " holds it";
  std::erase_if(united, [&](const Bond& bond) { return home[bond.a] % 2 == 0 || home[bond.b] % 2 == 0; });
  for (int& rank : home) rank = rank < 0 ? -1 : rank / 2;

  auto known = bonds_.begin();
  for (Bond& bond : united) {
    while (known != bonds_.end() && *known < bond) ++known;
    if (known != bonds_.end() && known->joins_as(bond)) bond.length = known->length;
    if (options_.length > 0.0) bond.length = options_.length;
  }
  bonds_ = std::move(united);
  islands_.assign(bonds_, home);
  own_bonds_.clear();
  for (const Bond& bond : bonds_)
    if (islands_.point(bond.a) >= 0) own_bonds_.push_back(bond);
  return {};
}

std::string DistributedRods::find_lengths() {
  std::string trouble;
  joins_nearest_images_ = false;
  for (Bond& bond : own_bonds_) {
    bool is_other_image = false;
    const double distance = norm(nearest(bond, &is_other_image));
    joins_nearest_images_ = joins_nearest_images_ || is_other_image;
    if (!(distance > 0.0) && trouble.empty())
      trouble = name(bond) + (distance == 0.0 ? " has length 0: they are at one place" : " has no finite length");
    if (bond.length == 0.0) bond.length = distance;
  }
  std::vector<double> mine(bonds_.size(), 0.0), all(bonds_.size());
  auto own = own_bonds_.begin();
  for (std::size_t k = 0; k < bonds_.size() && own != own_bonds_.end(); ++k)
    if (own->joins_as(bonds_[k])) mine[k] = (own++)->length;
  MPI_Allreduce(mine.data(), all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM, islands_.world());
  for (std::size_t k = 0; k < all.size(); ++k) bonds_[k].length = all[k];
  return islands_.agree(trouble);
}

/// Returns r_b - r_a to the nearest image of b.
std::array<double, 3> DistributedRods::nearest(const Bond& bond, bool* is_other_image) const {
  const double* const a = &at_.r[3 * islands_.point(bond.a)];
  const double* const b = &at_.r[3 * islands_.point(bond.b)];
  std::array<double, 3> d{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  for (int k = 2; k >= 0; --k) {  // the edges have no parts behind the diagonal
    const std::array<double, 3>& edge = box_.edges[k];
    const double times = box_.repeats[k] ? std::round(d[k] / edge[k]) : 0.0;
    *is_other_image = *is_other_image || times != 0.0;
    for (int axis = 0; axis <= k; ++axis) d[axis] -= times * edge[axis];
  }
  return d;
}

std::string DistributedRods::make_constrainer(int threads) {
  Rods rods{.name = "bonds", .pairs = {}, .length = {}, .offsets = {}};
  std::vector<double> lengths;
  for (const Bond& bond : own_bonds_) {
    rods.pairs.push_back({islands_.point(bond.a), islands_.point(bond.b)});
    lengths.push_back(bond.length);
  }
  rods.length = std::move(lengths);
  const SolverOptions options{.threads = threads};
  if (joins_nearest_images_)
    constrainer_.emplace(at_.masses, std::vector<Constraint>{std::move(rods)}, at_.r,
                         Periodicity{.cell = cell_of(box_)}, options);
  else
    constrainer_.emplace(at_.masses, std::vector<Constraint>{std::move(rods)}, at_.r, options);
  // A tree of rods has no redundant rods.
  is_redundant_.assign(own_bonds_.size(), false);
  if (own_bonds_.size() + islands_.num_islands() > islands_.num_points())
    for (const RowDependence& dependence : constrainer_->rank(at_.r).dependences) is_redundant_[dependence.row] = true;
  return {};
}

std::string DistributedRods::start(const Atoms& atoms) {
  if (std::string trouble = project_positions(atoms); !trouble.empty() || has_unit_masses_) return trouble;
  return constrain_velocities(atoms, 0.0);
}

std::size_t DistributedRods::count_constraints(const std::vector<bool>& is_member) {
  std::vector<bool> counts(islands_.num_points(), false);
  islands_.to_owners<1>([](int) {}, [&](int i, double* member) { *member = is_member[i] ? 1.0 : 0.0; },
                        [&](int point, const double* member) { counts[point] = *member == 1.0; });
  long mine = 0, all = 0;
  for (std::size_t k = 0; k < own_bonds_.size(); ++k) {
    const Bond& bond = own_bonds_[k];
    if (!is_redundant_[k] && counts[islands_.point(bond.a)] && counts[islands_.point(bond.b)]) ++mine;
  }
  MPI_Allreduce(&mine, &all, 1, MPI_LONG, MPI_SUM, islands_.world());
  return static_cast<std::size_t>(all);
}

// ---- in a step ----

std::string DistributedRods::constrain_positions(const Atoms& atoms, double h) {
  const CpuClock clock(&times_.all);
  gather_positions(atoms);
  // at_.move, which is 0, returns the change of velocities alone, without the rounding of positions. The move is h
  // times that.
  const std::string trouble = call([&] {
    set_box(atoms.box);
    ConstraintReport report = constrainer_->constrain_positions({.step = h,
                                                                 .old_positions = at_.old,
                                                                 .positions = at_.r,
                                                                 .velocities = at_.move,
                                                                 .measures = false,
                                                                 .tolerance = options_.tolerance});
    ++times_.steps;
    times_.iterations += report.iterations;
    if (report.outcome.ok() && !(report.violation <= std::max(options_.tolerance, off_constraints))) {
      report = constrainer_->violation(at_.r);
      report.outcome.what = "is off its length by " + std::to_string(report.violation) + " of it";
      report.outcome.status = Status::NotConverged;
    }
    return report.outcome.ok() ? std::string() : describe(report);
  });
  return finish_positions(atoms, h, 1.0, trouble);
}

std::string DistributedRods::constrain_velocities(const Atoms& atoms, double h) {
  const CpuClock clock(&times_.all);
  // If there is only one rank, it has all points, and their velocities are read and written in place.
  const int* const atom_of_point = islands_.atom_of_point();
  const PointArray velocities =
      atom_of_point != nullptr ? PointArray(atoms.v, 3 * sizeof(double), atom_of_point) : PointArray(at_.v);
  if (atom_of_point == nullptr)
    islands_.to_owners<3>([&](int i) { Atoms::fetch(atoms.v, i); },
                          [&](int i, double* v) { std::copy_n(&atoms.v[3 * i], 3, v); },
                          [&](int point, const double* v) { std::copy_n(v, 3, &at_.v[3 * point]); });
  std::string trouble = call([&] {
    const ConstraintReport report = constrainer_->constrain_velocities(
        {.step = h, .positions = at_.old, .velocities = velocities, .measures = false});
    return report.outcome.ok() ? std::string() : describe(report);
  });
  if (trouble.empty() && atom_of_point == nullptr)
    islands_.from_owners<3>([&](int i) { Atoms::fetch(atoms.v, i); },
                            [&](int point, double* v) { std::copy_n(&at_.v[3 * point], 3, v); },
                            [&](int i, const double* v) { std::copy_n(v, 3, &atoms.v[3 * i]); });
  return trouble;
}

std::string DistributedRods::measure(const Atoms& atoms, double half_step, double force_unit, bool with_stress) {
  const CpuClock clock(&times_.all);
  islands_.to_owners<6>(
      [&](int i) {
        Atoms::fetch(atoms.v, i);
        Atoms::fetch(atoms.f, i);
      },
      [&](int i, double* vf) {
        std::copy_n(&atoms.v[3 * i], 3, vf);
        std::copy_n(&atoms.f[3 * i], 3, vf + 3);
      },
      [&](int point, const double* vf) {
        for (int k = 0; k < 3; ++k) {
          at_.f[3 * point + k] = force_unit * vf[3 + k];
          at_.v[3 * point + k] = vf[k] + half_step * at_.f[3 * point + k] / at_.masses[point];
        }
      });
  const std::string trouble = call([&] {
    if (half_step == 0.0) return std::string();
    const ConstraintReport report =
        constrainer_->constrain_velocities({.positions = at_.old, .velocities = at_.v, .measures = false});
    return report.outcome.ok() ? std::string() : describe(report);
  });
  return trouble.empty() ? solve(atoms, force_unit, with_stress, {}) : trouble;
}

std::string DistributedRods::project_positions(const Atoms& atoms) {
  gather_positions(atoms);
  at_.move = at_.r;
  const std::string trouble = call([&] {
    set_box(atoms.box);
    if (constrainer_->violation(at_.r).violation <= on_constraints) return std::string();
    const ConstraintReport report = constrainer_->project_positions(at_.r);
    return report.outcome.ok() ? std::string() : describe(report);
  });
  for (std::size_t k = 0; k < at_.r.size(); ++k) at_.move[k] = at_.r[k] - at_.move[k];
  return finish_positions(atoms, 1.0, 0.0, trouble);
}

std::string DistributedRods::project_forces(const Atoms& atoms, bool with_stress) {
  islands_.to_owners<3>([&](int i) { Atoms::fetch(atoms.f, i); },
                        [&](int i, double* f) { std::copy_n(&atoms.f[3 * i], 3, f); },
                        [&](int point, const double* f) { std::copy_n(f, 3, &at_.f[3 * point]); });
  std::fill(at_.v.begin(), at_.v.end(), 0.0);
  std::vector<double>& projected = at_.r;
  std::string trouble = solve(atoms, 1.0, with_stress, projected);
  if (trouble.empty())
    islands_.from_owners<3>([&](int i) { Atoms::fetch(atoms.f, i); },
                            [&](int point, double* f) { std::copy_n(&projected[3 * point], 3, f); },
                            [&](int i, const double* f) { std::copy_n(f, 3, &atoms.f[3 * i]); });
  return trouble;
}

// ---- what is known ----

double DistributedRods::violation(const Atoms& atoms) {
  gather_positions(atoms);
  const double mine = constrainer_ ? constrainer_->violation(at_.r).violation : 0.0;
  double largest = 0.0;
  MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE, MPI_MAX, islands_.world());
  return largest;
}

std::vector<double> DistributedRods::save_lengths() const {
  std::vector<double> saved{static_cast<double>(bonds_.size())};
  for (const Bond& bond : bonds_)
    saved.insert(saved.end(), {static_cast<double>(bond.a), static_cast<double>(bond.b), bond.length});
  return saved;
}

void DistributedRods::restore_lengths(const double* saved) {
  bonds_.resize(static_cast<std::size_t>(*saved++));
  for (Bond& bond : bonds_) {
    bond = {static_cast<int>(saved[0]), static_cast<int>(saved[1]), 0, saved[2]};
    saved += 3;
  }
}

// ---- parts ----

/// Sets at_.r to the positions of the atoms.
void DistributedRods::gather_positions(const Atoms& atoms) {
  islands_.to_owners<3>([&](int i) { atoms.fetch_position(i); }, [&](int i, double* r) { atoms.unwrap(i, r); },
                        [&](int point, const double* r) { std::copy_n(r, 3, &at_.r[3 * point]); });
}

/// Adds at_.move times `h` to positions and at_.move times `rate` to velocities, and clears at_.move. Atoms are moved,
/// not set, since the host has wrapped them its own way.
std::string DistributedRods::finish_positions(const Atoms& atoms, double h, double rate, const std::string& trouble) {
  if (!trouble.empty()) {
    std::fill(at_.move.begin(), at_.move.end(), 0.0);
    return trouble;
  }
  islands_.from_owners<3>(
      [&](int i) {
        Atoms::fetch(atoms.x, i);
        Atoms::fetch(atoms.v, i);
      },
      [&](int point, double* move) {
        for (int k = 0; k < 3; ++k) move[k] = std::exchange(at_.move[3 * point + k], 0.0);
      },
      [&](int i, const double* move) {
        for (int k = 0; k < 3; ++k) {
          atoms.x[3 * i + k] += h * move[k];
          atoms.v[3 * i + k] += rate * move[k];
        }
      });
  std::swap(at_.r, at_.old);
  return {};
}

/// Computes tensions, virial and stress of the state (at_.old, at_.v, at_.f). `accelerations` [3 points] may be absent.
std::string DistributedRods::solve(const Atoms& atoms, double force_unit, bool with_stress,
                                   std::span<double> accelerations) {
  if (with_stress) at_.stress.resize(9 * islands_.num_points());
  std::string trouble = call([&] {
    HostState state{.positions = at_.old, .velocities = at_.v, .forces = at_.f, .wanted = {.multipliers = tensions_}};
    if (!accelerations.empty()) state.accelerations = accelerations;
    if (with_stress) state.wanted.stress = at_.stress;
    const ConstraintReport report = constrainer_->solve(state);
    if (!report.outcome.ok()) return describe(report);
    for (double& tension : tensions_) tension = -tension / force_unit;
    for (std::size_t k = 0; k < virial_.size(); ++k) virial_[k] = report.virial[k] / force_unit;
    return std::string();
  });
  if (!trouble.empty() || !with_stress) return trouble;
  constexpr std::array<int, 6> places{0, 4, 8, 1, 2, 5};  // places of xx yy zz xy xz yz in nine numbers
  islands_.from_owners<6>([](int) {},
                          [&](int point, double* stress) {
                            for (std::size_t k = 0; k < places.size(); ++k)
                              stress[k] = at_.stress[9 * point + places[k]] / force_unit;
                          },
                          [&](int i, const double* stress) {
                            for (std::size_t k = 0; k < places.size(); ++k) atoms.stress[6 * i + k] += stress[k];
                          });
  return {};
}

void DistributedRods::set_box(const Box& box) {
  box_ = box;
  if (joins_nearest_images_) constrainer_->set_cell(cell_of(box));
}

/// Makes what was thrown, and what the call returns, known to all ranks. A rank without islands has no Constrainer.
template <class Call>
std::string DistributedRods::call(const Call& call) {
  std::string trouble;
  try {
    const CpuClock clock(&times_.solver);
    if (islands_.num_points() > 0) trouble = call();
  } catch (const std::exception& thrown) {
    trouble = thrown.what();
  }
  return islands_.agree(trouble);
}

/// Returns the outcome's sentence with the atoms of each "bonds[17]", which is our own name.
std::string DistributedRods::describe(const ConstraintReport& report) const {
  constexpr std::string_view ours = "bonds[";
  const std::string& said = report.outcome.what;
  if (said.find(ours) == std::string::npos && report.worst_row < own_bonds_.size())
    return name(own_bonds_[report.worst_row]) + ": " + said;
  std::string result;
  std::size_t end = 0;
  for (std::size_t k = said.find(ours); k != std::string::npos; k = said.find(ours, end)) {
    const std::size_t row = std::stoul(said.substr(k + ours.size()));
    result += said.substr(end, k - end) + name(own_bonds_.at(row));
    end = said.find(']', k) + 1;
  }
  return result + said.substr(end);
}

}  // namespace tanor::embed
