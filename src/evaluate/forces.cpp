#include "evaluate/forces.hpp"

#include <algorithm>
#include <iterator>

#include "evaluate/point_sums.hpp"
#include "kinds/force_kernel.hpp"

namespace tanor {

namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;  // clang 14 wants to be told

}  // namespace

Forces::Forces(const System& system, const Numbering& numbering)
    : num_points_(numbering.num_points()), num_moving_(numbering.num_moving), mass_(numbering.num_moving) {
  for (std::size_t i = 0; i < num_moving_; ++i) mass_[i] = system.masses[numbering.user_point[i]];
  const auto initial = [&](Index user_point) { return load(system.positions.data(), user_point); };
  std::vector<std::pair<Index, Index>> given_forces, spring_ends, formula_forces, potential_forces;
  std::vector<std::pair<Index, DragNumbers>> drags;

  for (std::size_t g = 0; g < system.forces.size(); ++g) {
    const auto add_energies = [&](EnergyGroup group) {
      group.name = force_name(system, g);
      add_potential(std::move(group), numbering, &potential_forces);
    };
    // Energies that may change within a small part of a step: steps look for that.
    const auto add_narrow_energies = [&](EnergyGroup group) {
      std::vector<Index> points;
      for (const Index point : group.points) points.push_back(numbering.inner_point[point]);
      if (auto passages = make_energy_passages(group.kernel, points, group.constants, mass_))
        formula_passages_.push_back(std::move(passages));
      add_energies(std::move(group));
    };
    std::visit(
        Overloaded{[&](const Gravity& gravity) { gravity_ = gravity_ + make_vec3(gravity.acceleration); },
                   [&](const ConstantForce& given) {
                     const auto slot = static_cast<Index>(given_.add(given.force));
                     given_is_constant_.push_back(given.force.is_constant());
                     forces_depend_on_time_ = forces_depend_on_time_ || !given.force.is_constant();
                     for (const Index point : given.points)
                       given_forces.push_back({numbering.inner_point[point], slot});
                   },
                   [&](const Springs& group) {
                     has_damping_ = has_damping_ || group.damping > 0.0;
                     const auto& rest = group.rest_length;
                     for (std::size_t k = 0; k < group.pairs.size(); ++k) {
                       const auto [i, j] = group.pairs[k];
                       double rest_length = 0.0;
                       if (rest.is_initial()) {
                         rest_length = norm(initial(j) - initial(i));
                       } else if (!rest.constants.empty()) {
                         rest_length = rest.constants[rest.constants.size() == 1 ? 0 : k];
                       } else {
                         rest_length = rest.functions[rest.functions.size() == 1 ? 0 : k](0.0).value();
                       }
                       add_spring(numbering, {i, j, group.stiffness, group.damping, rest_length, -1}, &spring_ends);
                     }
                   },
                   [&](const Drag& drag) {
                     for (const Index point : drag.points) {
                       drags.push_back({numbering.inner_point[point], {drag.linear, drag.quadratic}});
                     }
                   },
                   [&](const FormulaForce& formula) { add_formula(formula, numbering, &formula_forces); },
                   [&](const PairForces& pairs) {
                     pairs_.emplace_back(system, pairs, numbering);
                     PairField of_supports(system, pairs, numbering, PairField::Which::OfSupports);
                     if (!of_supports.empty()) pairs_of_supports_.push_back(std::move(of_supports));
                     if (EnergyGroup smooth = make_pair_energies(system, pairs); !smooth.points.empty())
                       pair_energies_.emplace_back(std::move(smooth), numbering);
                   },
                   [&](const Bonds& bonds) {
                     if (bonds.law != BondLaw::Harmonic) return add_energies(make_energy_group(system, bonds));
                     // The harmonic bond is a spring without damping.
                     for (std::size_t k = 0; k < bonds.pairs.size(); ++k) {
                       const auto numbers = law_numbers_of(system, bonds, k);
                       const auto [i, j] = bonds.pairs[k];
                       add_spring(numbering, {i, j, numbers[0], 0.0, numbers[1], -1}, &spring_ends);
                     }
                   },
                   [&](const Potential& group) { add_narrow_energies(make_energy_group(system, group)); },
                   [&](const Torsions& group) {
                     // The force of a harmonic one jumps at rest +- pi.
                     EnergyGroup energies = make_energy_group(system, group);
                     group.law == TorsionLaw::Harmonic ? add_narrow_energies(std::move(energies))
                                                       : add_energies(std::move(energies));
                   },
                   [&]<HasEnergy Group>(const Group& group) { add_energies(make_energy_group(system, group)); },
                   // A kind that has no loop of its own.
                   [&]<class Group>(const Group& group) {
                     add_formula({.name = group.name, .points = group.points, .kernel = kernel_of_definition(group)},
                                 numbering, &formula_forces);
                   }},
        system.forces[g]);
  }

  spring_force_.resize(3 * springs_.size());
  spring_ends_ = {num_points_, spring_ends};
  given_forces_ = {num_points_, given_forces};
  drags_ = {num_points_, drags};
  formula_force_.resize(3 * formula_forces.size());
  formula_forces_ = {num_points_, formula_forces};
  potential_force_.resize(3 * potential_forces.size());
  potential_forces_ = {num_points_, potential_forces};
  list_own_blocks();
}

/// `spring`: with the user's points.
void Forces::add_spring(const Numbering& numbering, const Spring& spring, std::vector<std::pair<Index, Index>>* ends) {
  const Index number = static_cast<Index>(springs_.size());
  const bool gives_way = spring.rest_length > 0.0 && (spring.stiffness > 0.0 || spring.damping > 0.0);
  const Index compliant = gives_way ? static_cast<Index>(compliant_springs_.size()) : -1;
  if (gives_way) compliant_springs_.push_back(number);
  springs_.push_back({numbering.inner_point[spring.i], numbering.inner_point[spring.j], spring.stiffness,
                      spring.damping, spring.rest_length, compliant});
  ends->push_back({springs_.back().i, ~number});
  ends->push_back({springs_.back().j, number});
}

std::vector<Index> Forces::list_moving(std::span<const Index> points) const {
  std::vector<Index> moving;
  std::copy_if(points.begin(), points.end(), std::back_inserter(moving), [this](Index point) { return moves(point); });
  return moving;
}

/// On point j: -(k (L - rest) + c dL/dt) u, u from i to j.
Vec3 Forces::spring_force(const Spring& spring, const double* r, const double* v, bool elastic, bool viscous) const {
  const Vec3 a = load(r, spring.j) - load(r, spring.i);
  const double length = norm(a);
  // Points on top of each other: the direction is undefined, the force 0 (exact for a rest length of 0).
  const Vec3 unit = length > 0.0 ? (1.0 / length) * a : Vec3{};
  double tension = 0.0;
  if (elastic) tension += spring.stiffness * (length - spring.rest_length);
  if (viscous && spring.damping > 0.0) tension += spring.damping * dot(unit, load(v, spring.j) - load(v, spring.i));
  return -tension * unit;
}

void Forces::evaluate(const Parallel& parallel, double t, const double* r, const double* v, double* f, Which which) {
  if (forces_depend_on_time_) given_.set_time(t);
  parallel.for_ranges(springs_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const bool counts = which == Which::All || springs_[k].compliant < 0;
      store(spring_force_.data(), k, counts ? spring_force(springs_[k], r, v, true, true) : Vec3{});
    }
  });
  evaluate_formulas(parallel, t, r, v);
  evaluate_potentials(parallel, t, r);
  parallel.for_ranges(num_points_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = i < num_moving_ ? mass_[i] * gravity_ : Vec3{};
      for (const Index k : spring_ends_[i]) {
        sum = k >= 0 ? sum + load(spring_force_.data(), k) : sum - load(spring_force_.data(), ~k);
      }
      for (const Index slot : given_forces_[i]) sum = sum + given_[slot].value;
      // -c1 v - c2 |v| v
      for (const auto& [linear, quadratic] : drags_[i]) {
        const Vec3 b = load(v, i);
        sum = sum - (linear + quadratic * norm(b)) * b;
      }
      for (const Index slot : formula_forces_[i]) sum = sum + load(formula_force_.data(), slot);
      for (const Index slot : potential_forces_[i]) sum = sum + load(potential_force_.data(), slot);
      store(f, i, sum);
    }
  });
  for (PairField& pairs : pairs_) pairs.add_forces(parallel, r, f);
  for (PairField& pairs : pairs_of_supports_) pairs.add_forces(parallel, r, f);
}

double Forces::largest_single(const Parallel& parallel, const double* r) {
  double largest = 0.0;
  const auto look = [&](const Vec3& force) { largest = larger(largest, norm(force)); };
  for (std::size_t i = 0; i < num_moving_; ++i) {
    look(mass_[i] * gravity_);
    for (const Index k : spring_ends_[i]) look(load(spring_force_.data(), k >= 0 ? k : ~k));
    for (const Index slot : given_forces_[i]) look(given_[slot].value);
    for (const Index slot : formula_forces_[i]) look(load(formula_force_.data(), slot));
    for (const Index slot : potential_forces_[i]) look(load(potential_force_.data(), slot));
  }
  for (std::vector<PairField>* fields : {&pairs_, &pairs_of_supports_}) {
    for (PairField& pairs : *fields) {
      std::vector<double> of_pairs(3 * num_points_, 0.0);
      pairs.add_forces(parallel, r, of_pairs.data());
      for (std::size_t i = 0; i < num_moving_; ++i) look(load(of_pairs.data(), i));
    }
  }
  return largest;
}

void Forces::evaluate_powers(const Parallel& parallel, double t, const double* r, const double* v) {
  if (forces_depend_on_time_) given_.set_time(t);
  evaluate_formulas(parallel, t, r, v);
  if (potentials_depend_on_time_) evaluate_potentials(parallel, t, r);
}

double Forces::find_passage(const Parallel& parallel, PointPath* path) {
  constexpr double path_error = 1e-5;
  if (has_pairs()) path->refine(path_error);
  double part = 1.0;
  for (PairField& pairs : pairs_) part = std::min(part, pairs.find_passage(parallel, *path, mass_));
  for (const auto& formula : formula_passages_) part = std::min(part, formula->find(parallel, path));
  return part;
}

double Forces::potential(const Parallel& parallel, double t, const double* r) {
  // -(m g + constant forces).r
  double of_points = 0.0;
  if (dot(gravity_, gravity_) > 0.0) of_points -= dot(gravity_, sum_moments(parallel, num_moving_, mass_.data(), r));
  if (!given_forces_.empty()) {
    of_points -= parallel.sum(num_moving_, [&](std::size_t i) {
      Vec3 force{};
      for (const Index slot : given_forces_[i]) {
        if (given_is_constant_[slot]) force = force + given_[slot].value;
      }
      return dot(force, load(r, i));
    });
  }
  // k (L - rest)^2/2
  const double of_springs = parallel.sum(springs_.size(), [&](std::size_t k) {
    const Spring& spring = springs_[k];
    const double stretch = norm(load(r, spring.j) - load(r, spring.i)) - spring.rest_length;
    return 0.5 * spring.stiffness * stretch * stretch;
  });
  double of_pairs = 0.0;
  for (PairField& pairs : pairs_) of_pairs += pairs.potential(parallel, r);
  std::size_t first = 0;
  for (const PotentialFamily& family : potentials_) {
    family.evaluate_energies(parallel, t, r, energies_.data() + first);
    first += family.size();
  }
  const double of_tuples = parallel.sum(energies_.size(), [&](std::size_t k) { return energies_[k]; });
  return of_points + of_springs + of_pairs + of_tuples;
}

double Forces::power(const Parallel& parallel, const double* r, const double* v) const {
  double result = 0.0;
  if (!drags_.empty() || forces_depend_on_time_ || !formulas_.empty()) {
    result += parallel.sum(num_moving_, [&](std::size_t i) {
      const Vec3 b = load(v, i);
      double power = 0.0;
      for (const auto& [linear, quadratic] : drags_[i]) power -= (linear + quadratic * norm(b)) * dot(b, b);
      for (const Index slot : given_forces_[i]) {
        if (!given_is_constant_[slot]) power += dot(given_[slot].value, b);
      }
      for (const Index slot : formula_forces_[i]) power += dot(load(formula_force_.data(), slot), b);
      return power;
    });
  }
  if (has_damping_) {
    result += parallel.sum(springs_.size(), [&](std::size_t k) {
      const Spring& spring = springs_[k];
      const Vec3 force = spring_force(spring, r, v, false, true);
      return (moves(spring.j) ? dot(force, load(v, spring.j)) : 0.0) -
             (moves(spring.i) ? dot(force, load(v, spring.i)) : 0.0);
    });
  }
  return result;
}

double Forces::elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v) {
  double of_pairs = 0.0;
  for (PairField& pairs : pairs_) of_pairs += pairs.power_of_supports(parallel, r, v);
  // The support does the work -(force on it).velocity on the elastic energy.
  const double of_tuples = parallel.sum(potential_points_.size(), [&](std::size_t slot) {
    const Index point = potential_points_[slot];
    return moves(point) ? 0.0 : -dot(load(potential_force_.data(), slot), load(v, point));
  });
  return of_pairs + of_tuples + parallel.sum(springs_.size(), [&](std::size_t k) {
    const Spring& spring = springs_[k];
    if (moves(spring.i) && moves(spring.j)) return 0.0;
    const Vec3 force = spring_force(spring, r, v, true, false);
    return (moves(spring.j) ? 0.0 : -dot(force, load(v, spring.j))) +
           (moves(spring.i) ? 0.0 : dot(force, load(v, spring.i)));
  });
}

}  // namespace tanor
