#include "evaluate/forces.hpp"
#include "evaluate/pair_stiffness.hpp"
#include "kinds/energy_groups.hpp"

namespace tanor {

std::vector<Coupling> Forces::list_couplings() const {
  std::vector<Coupling> result;
  for (const Spring& spring : springs_) result.push_back({spring.i, spring.j});
  return result;
}

std::vector<Forces::CompliantSpring> Forces::list_compliant_springs() const {
  std::vector<CompliantSpring> result;
  for (const Index k : compliant_springs_) {
    const Spring& spring = springs_[k];
    result.push_back({spring.i, spring.j, spring.stiffness, spring.damping});
  }
  return result;
}

void Forces::evaluate_compliant_springs(const Parallel& parallel, const double* r, const double* v, const double* tau,
                                        double* units, double* residuals) const {
  parallel.for_ranges(compliant_springs_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Spring& spring = springs_[compliant_springs_[k]];
      const Vec3 a = load(r, spring.j) - load(r, spring.i), b = load(v, spring.j) - load(v, spring.i);
      const double length = norm(a);
      const Vec3 unit = length > 0.0 ? (1.0 / length) * a : Vec3{};
      store(units, k, unit);
      residuals[k] = tau[k] + spring.stiffness * (length - spring.rest_length) + spring.damping * dot(unit, b);
    }
  });
}

void Forces::add_compliant_forces(const Parallel& parallel, const double* units, const double* tau, const double* scale,
                                  double* y) const {
  if (compliant_springs_.empty()) return;
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = load(y, i);
      for (const Index end_of_spring : spring_ends_[i]) {
        const bool is_last = end_of_spring >= 0;
        const Index k = springs_[is_last ? end_of_spring : ~end_of_spring].compliant;
        if (k >= 0) sum = sum + (is_last ? scale[i] : -scale[i]) * tau[k] * load(units, k);
      }
      store(y, i, sum);
    }
  });
}

void Forces::evaluate_derivatives(const Parallel& parallel, double t, const double* r, const double* v,
                                  const double* tau, const Derivatives& to) {
  // F = -T u on j with a = r_j - r_i = L u, b = v_j - v_i, T = k (L - rest) + c u.b:
  //   dF/dr_j = -u (k u + c (b - (u.b)u)/L)' - (T/L)(I - u u'),   dF/dv_j = -c u u'
  // of compliant ones, T = -tau being an unknown, the second term alone.
  parallel.for_ranges(springs_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const Spring& spring = springs_[n];
      Block3 by_position, by_velocity;
      const Vec3 a = load(r, spring.j) - load(r, spring.i), b = load(v, spring.j) - load(v, spring.i);
      const double length = norm(a);
      if (length > 0.0) {
        const Vec3 unit = (1.0 / length) * a;
        const double along = dot(unit, b), c = spring.damping;
        double tension = spring.stiffness * (length - spring.rest_length) + c * along;
        if (tau != nullptr && spring.compliant >= 0) {
          tension = -tau[spring.compliant];
        } else {
          by_position.add_product(-1.0, unit, spring.stiffness * unit + (c / length) * (b - along * unit));
          by_velocity.add_product(-c, unit, unit);
        }
        by_position.add_product(tension / length, unit, unit);
        by_position.add_identity(-tension / length);
      } else if (spring.rest_length == 0.0) {
        by_position.add_identity(-spring.stiffness);
      }
      to.coupling_positions[n] = by_position;
      to.coupling_velocities[n] = by_velocity;
    }
  });
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      to.point_positions[i] = {};
      // -c1 I - c2 (|v| I + v v'/|v|)
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
  evaluate_formula_derivatives(parallel, t, r, v, to);
  add_potential_derivatives(parallel, t, r, to);
}

bool has_stiffness(const System& system, const PairForces& pairs) {
  return !make_pair_energies(system, pairs).points.empty();
}

}  // namespace tanor
