#include "evaluate/forces.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "evaluate/pair_stiffness.hpp"
#include "kinds/force_kernel.hpp"
#include "system/members.hpp"
#include "system/pair_rules.hpp"

namespace tanor::detail {

/// Reads the forces of a system, entry by entry, into lists for each sort.
class Forces::Reader {
 public:
  Reader(Forces* forces, const System& system, const Numbering& numbering)
      : forces_(*forces), system_(system), numbering_(numbering) {}

  void read() {
    for (const Force& force : system_.forces) {
      name_ = force_name(system_, number_++);
      std::visit([this](const auto& entry) { add(entry); }, force);
    }
    forces_.given_ = {numbering_, given_};
    forces_.drags_ = {numbering_.num_points(), drags_};
    forces_.springs_ = {numbering_, std::move(springs_)};
    forces_.formulas_ = {numbering_, std::move(formulas_)};
    forces_.energies_ = {numbering_, std::move(energies_), std::move(energies_of_pairs_)};
    forces_.angle_features_.finish();
  }

 private:
  void add(const Gravity& gravity) { forces_.gravity_ = forces_.gravity_ + make_vec3(gravity.acceleration); }
  void add(const ConstantForce& given) { given_.push_back(given); }
  void add(const Springs& group) {
    for (std::size_t k = 0; k < group.pairs.size(); ++k)
      add_spring(group.pairs[k], group.stiffness, group.damping, rest_length_of(group, k));
  }
  void add(const Drag& drag) {
    for (const Index point : drag.points)
      drags_.push_back({numbering_.inner_point[point], {drag.linear, drag.quadratic}});
  }
  void add(const FormulaForce& formula) {
    FormulaGroup group(formula, numbering_);
    if (group.points.empty()) return;
    // A support does not move, whatever acts on it, so a single one is not watched.
    const std::vector<Index> points = group.points_per_member() == 1 ? list_moving(group.points) : group.points;
    watch(make_force_features(group.kernel, points, forces_.mass_));
    formulas_.push_back(std::move(group));
  }
  void add(const PairForces& pairs) {
    forces_.pairs_.emplace_back(system_, pairs, numbering_);
    forces_.pairs_.back().name = name_;
    auto of_supports = std::make_unique<PairField>(system_, pairs, numbering_, PairField::Which::OfSupports);
    forces_.pairs_of_supports_.push_back(of_supports->empty() ? nullptr : std::move(of_supports));
    if (EnergyGroup smooth = make_pair_energies(system_, pairs); !smooth.points.empty())
      energies_of_pairs_.push_back(std::move(smooth));
  }
  void add(const Bonds& bonds) {
    if (bonds.law != BondLaw::Harmonic) return add_energies(make_energy_group(system_, bonds));
    // A harmonic bond is a spring without damping.
    for (std::size_t k = 0; k < bonds.pairs.size(); ++k) {
      const auto numbers = law_numbers_of(system_, bonds, k);
      add_spring(bonds.pairs[k], numbers[0], 0.0, numbers[1]);
    }
  }
  void add(const Potential& group) { add_narrow_energies(make_energy_group(system_, group)); }
  void add(const Bendings& group) {
    if (group.law == BendingLaw::Harmonic) {
      const auto ends =
          KindOf<Bendings>::is_straight(group) ? AngleFeatures::Ends::AtZero : AngleFeatures::Ends::AtZeroAndStraight;
      for (const auto& [i, corner, j] : group.triples) watch_angle({i, corner, j}, ends);
    }
    add_energies(make_energy_group(system_, group));
  }
  void add(const Torsions& group) {
    for (const auto& [i, j, k, l] : group.quadruples) {
      watch_angle({i, j, k}, AngleFeatures::Ends::AtZeroAndStraight);
      watch_angle({j, k, l}, AngleFeatures::Ends::AtZeroAndStraight);
    }
    // The force of a harmonic torsion jumps at its rest angle +- pi.
    EnergyGroup energies = make_energy_group(system_, group);
    group.law == TorsionLaw::Harmonic ? add_narrow_energies(std::move(energies), Course::Jumps)
                                      : add_energies(std::move(energies));
  }
  template <HasEnergy Group>
  void add(const Group& group) {
    add_energies(make_energy_group(system_, group));
  }
  /// Adds a kind that has no loop of its own.
  template <class Group>
  void add(const Group& group) {
    add(FormulaForce{.name = group.name, .points = group.points, .kernel = kernel_of_definition(group)});
  }

  /// Adds a spring between `ends`, which are the user's points.
  void add_spring(const std::array<Index, 2>& ends, double stiffness, double damping, double rest_length) {
    springs_.push_back(
        {numbering_.inner_point[ends[0]], numbering_.inner_point[ends[1]], stiffness, damping, rest_length});
  }
  double rest_length_of(const Springs& group, std::size_t k) const {
    const double* const r = system_.positions.data();
    const auto measure = [&] { return norm(load(r, group.pairs[k][1]) - load(r, group.pairs[k][0])); };
    return number_of(group.rest_length, k, measure)(0.0).value();
  }
  void add_energies(EnergyGroup group) {
    group.name = name_;
    energies_.push_back(std::move(group));
  }
  /// Adds energies that may change within a small part of a step, for which steps then look.
  void add_narrow_energies(EnergyGroup group, Course course = Course::Continuous) {
    std::vector<Index> points;
    for (const Index point : group.points) points.push_back(numbering_.inner_point[point]);
    watch(make_energy_features(group.kernel, points, group.constants, forces_.mass_, course));
    add_energies(std::move(group));
  }
  void watch_angle(std::array<Index, 3> triple, AngleFeatures::Ends ends) {
    for (Index& point : triple) point = numbering_.inner_point[point];
    forces_.angle_features_.append(triple, ends);
  }
  void watch(std::unique_ptr<FormulaFeatures> features) {
    if (features == nullptr) return;
    features->name = name_;
    forces_.formula_features_.push_back(std::move(features));
  }
  std::vector<Index> list_moving(std::span<const Index> points) const {
    std::vector<Index> moving;
    std::copy_if(points.begin(), points.end(), std::back_inserter(moving),
                 [this](Index point) { return static_cast<std::size_t>(point) < numbering_.num_moving; });
    return moving;
  }

  Forces& forces_;
  const System& system_;
  const Numbering& numbering_;
  std::size_t number_ = 0;
  std::string name_;  // the entry as messages call it
  std::vector<ConstantForce> given_;
  std::vector<std::pair<Index, DragNumbers>> drags_;
  std::vector<Spring> springs_;
  std::vector<FormulaGroup> formulas_;
  std::vector<EnergyGroup> energies_, energies_of_pairs_;
};

Forces::Forces(const System& system, const Numbering& numbering)
    : num_points_(numbering.num_points()), num_moving_(numbering.num_moving), mass_(numbering.num_moving) {
  for (std::size_t i = 0; i < num_moving_; ++i) mass_[i] = system.masses[numbering.user_point[i]];
  for (const Support& support : system.supports) {
    if (support.name != rigid_points_name) continue;
    for (const Index point : support.points)
      rigid_.emplace_back(static_cast<std::size_t>(numbering.inner_point[point]), system.masses[point]);
  }
  Reader(this, system, numbering).read();
}

void Forces::evaluate(const Parallel& parallel, double t, const double* r, const double* v, double* f, Which which) {
  given_.set_time(t);
  springs_.evaluate(parallel, r, v, which == Which::All);
  formulas_.evaluate(parallel, t, r, v);
  energies_.evaluate(parallel, t, r);
  parallel.for_ranges(num_points_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = i < num_moving_ ? mass_[i] * gravity_ : Vec3{};
      const auto add = [&](const Vec3& force, bool = false) { sum = sum + force; };
      springs_.on_points().for_each_on(i, add);
      given_.for_each_force_on(i, add);
      // Drag is -c1 v - c2 |v| v.
      for (const DragNumbers& drag : drags_[i]) {
        const Vec3 b = load(v, i);
        sum = sum - drag.over_speed(norm(b)) * b;
      }
      formulas_.on_points().for_each_on(i, add);
      energies_.on_points().for_each_on(i, add);
      store(f, i, sum);
    }
  });
  for (PairField& pairs : pairs_) pairs.add_forces(parallel, r, f);
  for (const auto& pairs : pairs_of_supports_)
    if (pairs != nullptr) pairs->add_forces(parallel, r, f);
  for (const auto& pairs : pairs_beyond_) pairs->add_forces(r, f);
}

double Forces::largest_single(const Parallel& parallel, const double* r) {
  double largest = 0.0;
  const auto look = [&](const Vec3& force, bool = false) { largest = larger(largest, norm(force)); };
  for (std::size_t i = 0; i < num_moving_; ++i) {
    look(mass_[i] * gravity_);
    springs_.on_points().for_each_on(i, look);
    given_.for_each_force_on(i, look);
    formulas_.on_points().for_each_on(i, look);
    energies_.on_points().for_each_on(i, look);
  }
  // Pairs of supports act on no moving point.
  for (PairField& pairs : pairs_) {
    std::vector<double> of_pairs(3 * num_points_, 0.0);
    pairs.add_forces(parallel, r, of_pairs.data());
    for (std::size_t i = 0; i < num_moving_; ++i) look(load(of_pairs.data(), i));
  }
  return largest;
}

void Forces::evaluate_powers(const Parallel& parallel, double t, const double* r, const double* v) {
  given_.set_time(t);
  formulas_.evaluate(parallel, t, r, v);
  if (energies_.depends_on_time()) energies_.evaluate(parallel, t, r);
}

bool Forces::may_jump() const {
  return std::ranges::any_of(pairs_, [](const PairField& pairs) { return pairs.may_jump(); }) ||
         std::ranges::any_of(formula_features_, [](const auto& formula) { return formula->may_jump(); });
}

double Forces::find_unseen(const Parallel& parallel, PointPath* path) {
  constexpr double path_error = 1e-5, path_error_at_jumps = 1e-7;
  if (has_pairs()) path->refine(path->follows_tolerance && may_jump() ? path_error_at_jumps : path_error);
  double part = 1.0;
  for (PairField& pairs : pairs_)
    if (pairs.may_jump() && path->follows_tolerance) pairs.note_jumps(parallel, path, mass_);
  for (PairField& pairs : pairs_) part = std::min(part, pairs.find_unseen(parallel, *path, mass_));
  for (const auto& pairs : pairs_beyond_) part = std::min(part, pairs->find_unseen(*path, mass_));
  for (const auto& formula : formula_features_) part = std::min(part, formula->find(parallel, path));
  if (path->follows_tolerance && !angle_features_.empty()) part = std::min(part, angle_features_.find(parallel, path));
  return part;
}

double Forces::potential(const Parallel& parallel, double t, const double* r) {
  // The energy of points is -(m g + constant forces).r.
  double of_points = 0.0;
  if (dot(gravity_, gravity_) > 0.0)
    of_points -= parallel.sum(num_moving_, [&](std::size_t i) { return mass_[i] * dot(gravity_, load(r, i)); });
  const auto work_of_given = [&](std::size_t i) {
    Vec3 force{};
    given_.for_each_force_on(i, [&](const Vec3& each, bool is_constant) {
      if (is_constant) force = force + each;
    });
    return dot(force, load(r, i));
  };
  if (!given_.empty()) of_points -= parallel.sum(num_moving_, work_of_given);
  // These points may come free, and their energy does not change by that.
  for (const auto& [i, mass] : rigid_) of_points -= mass * dot(gravity_, load(r, i)) + work_of_given(i);
  const double of_springs = springs_.energy(parallel, r);
  double of_pairs = 0.0;
  for (PairField& pairs : pairs_) of_pairs += pairs.potential(parallel, r);
  for (const auto& pairs : pairs_beyond_) of_pairs += pairs->potential(r);
  const double of_tuples = energies_.energy(parallel, t, r);
  return of_points + of_springs + of_pairs + of_tuples;
}

double Forces::power(const Parallel& parallel, const double* r, const double* v) const {
  double result = 0.0;
  if (!drags_.empty() || given_.depend_on_time() || !formulas_.empty()) {
    result += parallel.sum(num_moving_, [&](std::size_t i) {
      const Vec3 b = load(v, i);
      double power = 0.0;
      for (const DragNumbers& drag : drags_[i]) power -= drag.over_speed(norm(b)) * dot(b, b);
      given_.for_each_force_on(i, [&](const Vec3& force, bool is_constant) {
        if (!is_constant) power += dot(force, b);
      });
      formulas_.on_points().for_each_on(i, [&](const Vec3& force) { power += dot(force, b); });
      return power;
    });
  }
  if (springs_.has_damping()) result += springs_.power_of_damping(parallel, r, v);
  return result;
}

double Forces::elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v) {
  double of_pairs = 0.0;
  for (PairField& pairs : pairs_) of_pairs += pairs.power_of_supports(parallel, r, v);
  const double of_tuples = energies_.power_of_supports(parallel, v);
  return of_pairs + of_tuples + springs_.elastic_power_of_supports(parallel, r, v);
}

// ---- derivatives ----

std::vector<Influence> Forces::list_influences() const {
  std::vector<Influence> result;
  energies_.append_influences(&result);
  formulas_.append_influences(&result);
  return result;
}

void Forces::evaluate_derivatives(const Parallel& parallel, double t, const double* r, const double* v,
                                  const double* tau, const ForceDerivatives& to) {
  springs_.evaluate_derivatives(parallel, r, v, tau, to.coupling_positions, to.coupling_velocities);
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      to.point_positions[i] = {};
      // The derivative of drag is -c1 I - c2 (|v| I + v v'/|v|).
      Block3 by_velocity;
      for (const auto& [linear, quadratic] : drags_[i]) {
        const Vec3 b = load(v, i);
        const double speed = norm(b);
        by_velocity.add_identity(-linear - quadratic * speed);
        if (speed > 0.0) by_velocity.add_product(-quadratic / speed, b, b);
      }
      to.point_velocities[i] = by_velocity;
    }
  });
  formulas_.add_derivatives(parallel, t, r, v, energies_.num_influences(), to);
  energies_.add_derivatives(parallel, t, r, to);
}

void Forces::for_each_pair_stiffness(const Parallel& parallel, const double* r,
                                     const PairField::VisitStiffness& visit) {
  for (PairField& pairs : pairs_) {
    if (pairs.gives_stiffness()) pairs.for_each_stiffness(parallel, r, visit);
  }
}

bool has_own_derivatives(const System& system, const PairForces& pairs) {
  return !make_pair_energies(system, pairs).points.empty();
}

bool has_stiffness(const System& system, const PairForces& pairs) {
  return std::isfinite(cutoff_of(pairs)) || num_points(system, pairs) <= most_points_of_dense_stiffness;
}

double bytes_of_dense_stiffness(std::size_t num_points) {
  // These are W, its triangle as blocks and as numbers in two orders with their places, and the factor beside the
  // front.
  constexpr double matrices = 5.0;
  const double size = 3.0 * static_cast<double>(num_points);
  return matrices * sizeof(double) * size * size;
}

std::size_t num_points(const System& system, const PairForces& pairs) {
  return pairs.points.empty() ? system.num_points() : pairs.points.size();
}

}  // namespace tanor::detail
