#include "evaluate/forces.hpp"

#include <numeric>

namespace tanor {

namespace {

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};

}  // namespace

Forces::Forces(const System& system, const Numbering& numbering)
    : num_points_(numbering.num_points()), num_moving_(numbering.num_moving), mass_(numbering.num_moving) {
  for (std::size_t i = 0; i < num_moving_; ++i) mass_[i] = system.masses[numbering.user_point[i]];
  const auto initial = [&](Index user_point) { return load(system.positions.data(), user_point); };

  for (const Force& force : system.forces) {
    std::visit(
        Overloaded{
            [&](const Gravity& gravity) { gravity_ = gravity_ + make_vec3(gravity.acceleration); },
            [&](const ConstantForce& given) {
              const auto slot = static_cast<Index>(given_.add(given.force));
              given_is_constant_.push_back(given.force.is_constant());
              forces_depend_on_time_ = forces_depend_on_time_ || !given.force.is_constant();
              for (const Index point : given.points) given_forces_.push_back({numbering.inner_point[point], slot});
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
                springs_.push_back({numbering.inner_point[i], numbering.inner_point[j], group.stiffness, group.damping,
                                    rest_length});
              }
            },
            [&](const Drag& drag) {
              for (const Index point : drag.points) {
                drags_.push_back({numbering.inner_point[point], drag.linear, drag.quadratic});
              }
            }},
        force);
  }

  spring_force_.resize(3 * springs_.size());
  springs_start_.assign(num_points_ + 1, 0);
  for (const Spring& spring : springs_) {
    ++springs_start_[spring.i + 1];
    ++springs_start_[spring.j + 1];
  }
  std::partial_sum(springs_start_.begin(), springs_start_.end(), springs_start_.begin());
  springs_of_point_.resize(2 * springs_.size());
  std::vector<Index> next(springs_start_.begin(), springs_start_.end() - 1);
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    springs_of_point_[next[springs_[k].i]++] = ~static_cast<Index>(k);
    springs_of_point_[next[springs_[k].j]++] = static_cast<Index>(k);
  }
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

void Forces::evaluate(const Parallel& parallel, double t, const double* r, const double* v, double* f) {
  if (forces_depend_on_time_) given_.set_time(t);
  parallel.for_ranges(springs_.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      store(spring_force_.data(), k, spring_force(springs_[k], r, v, true, true));
    }
  });
  parallel.for_ranges(num_points_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = i < num_moving_ ? mass_[i] * gravity_ : Vec3{};
      for (Index s = springs_start_[i]; s < springs_start_[i + 1]; ++s) {
        const Index k = springs_of_point_[s];
        sum = k >= 0 ? sum + load(spring_force_.data(), k) : sum - load(spring_force_.data(), ~k);
      }
      store(f, i, sum);
    }
  });
  for (const auto& [point, slot] : given_forces_) store(f, point, load(f, point) + given_[slot].value);
  // -c1 v - c2 |v| v
  for (const auto& [point, linear, quadratic] : drags_) {
    const Vec3 b = load(v, point);
    store(f, point, load(f, point) - (linear + quadratic * norm(b)) * b);
  }
}

double Forces::potential(const double* r) const {
  double energy = -sum_in_order(num_moving_, [&](std::size_t i) { return mass_[i] * dot(gravity_, load(r, i)); });
  energy -= sum_in_order(given_forces_.size(), [&](std::size_t k) {
    const auto& [point, slot] = given_forces_[k];
    const bool counts = given_is_constant_[slot] && static_cast<std::size_t>(point) < num_moving_;
    return counts ? dot(given_[slot].value, load(r, point)) : 0.0;
  });
  energy += sum_in_order(springs_.size(), [&](std::size_t k) {
    const Spring& spring = springs_[k];
    const double stretch = norm(load(r, spring.j) - load(r, spring.i)) - spring.rest_length;
    return 0.5 * spring.stiffness * stretch * stretch;
  });
  return energy;
}

double Forces::power(const double* r, const double* v) const {
  const auto moves = [&](Index point) { return static_cast<std::size_t>(point) < num_moving_; };
  double result = sum_in_order(drags_.size(), [&](std::size_t k) {
    const auto& [point, linear, quadratic] = drags_[k];
    const Vec3 b = load(v, point);
    return moves(point) ? -(linear + quadratic * norm(b)) * dot(b, b) : 0.0;
  });
  result += sum_in_order(given_forces_.size(), [&](std::size_t k) {
    const auto& [point, slot] = given_forces_[k];
    return moves(point) && !given_is_constant_[slot] ? dot(given_[slot].value, load(v, point)) : 0.0;
  });
  if (has_damping_) {
    result += sum_in_order(springs_.size(), [&](std::size_t k) {
      const Spring& spring = springs_[k];
      const Vec3 force = spring_force(spring, r, v, false, true);
      return (moves(spring.j) ? dot(force, load(v, spring.j)) : 0.0) -
             (moves(spring.i) ? dot(force, load(v, spring.i)) : 0.0);
    });
  }
  return result;
}

double Forces::spring_power_of_supports(const double* r, const double* v) const {
  const auto is_support = [&](Index point) { return static_cast<std::size_t>(point) >= num_moving_; };
  // The support does the work -(force on it).velocity on the elastic energy.
  return sum_in_order(springs_.size(), [&](std::size_t k) {
    const Spring& spring = springs_[k];
    if (!is_support(spring.i) && !is_support(spring.j)) return 0.0;
    const Vec3 force = spring_force(spring, r, v, true, false);
    return (is_support(spring.j) ? -dot(force, load(v, spring.j)) : 0.0) +
           (is_support(spring.i) ? dot(force, load(v, spring.i)) : 0.0);
  });
}

}  // namespace tanor
