#include "evaluate/spring_forces.hpp"

namespace tanor::detail {

SpringForces::SpringForces(const Numbering& numbering, std::vector<Spring> springs)
    : num_moving_(numbering.num_moving), springs_(std::move(springs)) {
  std::vector<std::pair<Index, Index>> ends;
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const Spring& spring = springs_[k];
    const auto number = static_cast<Index>(k);
    compliant_number_.push_back(spring.is_compliant() ? static_cast<Index>(compliant_.size()) : -1);
    if (spring.is_compliant()) compliant_.push_back(number);
    ends.push_back({spring.i, ~number});
    ends.push_back({spring.j, number});
    has_damping_ = has_damping_ || spring.damping > 0.0;
  }
  on_points_ = {numbering.num_points(), springs_.size(), ends};
}

/// Returns the force on point j, -(k (L - rest) + c dL/dt) u, with u from i to j.
Vec3 SpringForces::force_of(const Spring& spring, const double* r, const double* v, Part part) {
  const Vec3 a = load(r, spring.j) - load(r, spring.i);
  const double length = norm(a);
  // If the points coincide, the direction is undefined and the force is 0, which is exact for a rest length of 0.
  const Vec3 unit = length > 0.0 ? (1.0 / length) * a : Vec3{};
  double tension = 0.0;
  if (part != Part::Viscous) tension += spring.stiffness * (length - spring.rest_length);
  if (part != Part::Elastic && spring.damping > 0.0)
    tension += spring.damping * dot(unit, load(v, spring.j) - load(v, spring.i));
  return -tension * unit;
}

void SpringForces::evaluate(const Parallel& parallel, const double* r, const double* v, bool with_compliant) {
  parallel.for_ranges(springs_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const bool counts = with_compliant || compliant_number_[k] < 0;
      store(on_points_.slot(k), 0, counts ? force_of(springs_[k], r, v, Part::Both) : Vec3{});
    }
  });
}

double SpringForces::energy(const Parallel& parallel, const double* r) const {
  // A spring has k (L - rest)^2/2.
  return parallel.sum(springs_.size(), [&](std::size_t k) {
    const Spring& spring = springs_[k];
    const double stretch = norm(load(r, spring.j) - load(r, spring.i)) - spring.rest_length;
    return 0.5 * spring.stiffness * stretch * stretch;
  });
}

double SpringForces::power(const Parallel& parallel, const double* r, const double* v, Part part,
                           bool on_moving_points) const {
  return parallel.sum(springs_.size(), [&](std::size_t k) {
    const Spring& spring = springs_[k];
    const bool has_j = moves(spring.j) == on_moving_points, has_i = moves(spring.i) == on_moving_points;
    if (!has_i && !has_j) return 0.0;
    const Vec3 force = force_of(spring, r, v, part);
    return (has_j ? dot(force, load(v, spring.j)) : 0.0) - (has_i ? dot(force, load(v, spring.i)) : 0.0);
  });
}

// ---- implicit methods ----

std::vector<Coupling> SpringForces::list_couplings() const {
  std::vector<Coupling> result;
  for (const Spring& spring : springs_) result.push_back({spring.i, spring.j});
  return result;
}

std::vector<Spring> SpringForces::list_compliant() const {
  std::vector<Spring> result;
  for (const Index k : compliant_) result.push_back(springs_[k]);
  return result;
}

void SpringForces::evaluate_compliant(const Parallel& parallel, const double* r, const double* v, const double* tau,
                                      double* units, double* residuals) const {
  parallel.for_ranges(compliant_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const Spring& spring = springs_[compliant_[k]];
      const Vec3 a = load(r, spring.j) - load(r, spring.i), b = load(v, spring.j) - load(v, spring.i);
      const double length = norm(a);
      const Vec3 unit = length > 0.0 ? (1.0 / length) * a : Vec3{};
      store(units, k, unit);
      residuals[k] = tau[k] + spring.stiffness * (length - spring.rest_length) + spring.damping * dot(unit, b);
    }
  });
}

void SpringForces::add_compliant_forces(const Parallel& parallel, const double* units, const double* tau,
                                        const double* scale, double* y) const {
  if (compliant_.empty()) return;
  parallel.for_ranges(num_moving_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = load(y, i);
      for (const Index end_of_spring : on_points_.slots_of(i)) {
        const bool is_last = end_of_spring >= 0;
        const Index k = compliant_number_[is_last ? end_of_spring : ~end_of_spring];
        if (k >= 0) sum = sum + (is_last ? scale[i] : -scale[i]) * tau[k] * load(units, k);
      }
      store(y, i, sum);
    }
  });
}

/// Evaluates the derivatives of F = -T u on j with a = r_j - r_i = L u, b = v_j - v_i, T = k (L - rest) + c u.b:
///
///   dF/dr_j = -u (k u + c (b - (u.b)u)/L)' - (T/L)(I - u u'),   dF/dv_j = -c u u'
///
/// Compliant springs have the term in T/L alone, because T = -tau is an unknown.
void SpringForces::evaluate_derivatives(const Parallel& parallel, const double* r, const double* v, const double* tau,
                                        Block3* by_position, Block3* by_velocity) const {
  parallel.for_ranges(springs_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const Spring& spring = springs_[n];
      Block3 in_position, in_velocity;
      const Vec3 a = load(r, spring.j) - load(r, spring.i), b = load(v, spring.j) - load(v, spring.i);
      const double length = norm(a);
      if (length > 0.0) {
        const Vec3 unit = (1.0 / length) * a;
        const double along = dot(unit, b), c = spring.damping;
        double tension = spring.stiffness * (length - spring.rest_length) + c * along;
        if (tau != nullptr && compliant_number_[n] >= 0) {
          tension = -tau[compliant_number_[n]];
        } else {
          in_position.add_product(-1.0, unit, spring.stiffness * unit + (c / length) * (b - along * unit));
          in_velocity.add_product(-c, unit, unit);
        }
        in_position.add_product(tension / length, unit, unit);
        in_position.add_identity(-tension / length);
      } else if (spring.rest_length == 0.0) {
        in_position.add_identity(-spring.stiffness);
      }
      by_position[n] = in_position;
      by_velocity[n] = in_velocity;
    }
  });
}

}  // namespace tanor::detail
