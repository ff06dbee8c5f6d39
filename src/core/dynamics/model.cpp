#include "dynamics/model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/instruction_sets.hpp"
#include "base/text.hpp"
#include "system/enum_check.hpp"
#include "system/loops.hpp"
#include "system/value_checks.hpp"

namespace tanor::detail {

namespace {

std::vector<double> masses_in_order(const System& system, const Numbering& numbering) {
  std::vector<double> result(numbering.num_points(), 0.0);
  for (std::size_t i = 0; i < numbering.num_moving; ++i) {
    result[i] = system.masses[static_cast<std::size_t>(numbering.user_point[i])];
  }
  return result;
}

std::size_t count_constrained(std::span<const Incidence> incidences, const Numbering& numbering) {
  std::size_t result = 0;
  for (const Incidence& incidence : incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    if (point < numbering.num_moving) result = std::max(result, point + 1);
  }
  return result;
}

std::vector<double> inverses(std::vector<double> masses) {
  for (double& mass : masses) mass = mass > 0.0 ? 1.0 / mass : 0.0;
  return masses;
}

System validated(System system, double t) {
  validate(system, t);
  if (system.velocities.empty()) system.velocities.assign(system.positions.size(), 0.0);
  return system;
}

/// Returns the shortest of the lengths that violations are measured by, m, at most `scene_size`.
double find_smallest_length(const Constraints& constraints, double scene_size) {
  std::vector<double> lengths(constraints.num_rows() + 1, scene_size);
  constraints.write_lengths(lengths.data());
  return *std::ranges::min_element(lengths);
}

void check_solver_options(const SolverOptions& options) {
  check_enum(options.form, Form::Both, "/solver/form");
  check_enum(options.linear_solver, LinearSolver::Cholmod, "/solver/linear_solver");
  check_enum(options.ordering, Ordering::Points, "/solver/ordering");
  check_enum(options.friction, FrictionMethod::Enumeration, "/solver/friction");
  const ContactOptions& contact = options.contact;
  for (const auto& [number, key] :
       {std::pair(contact.max_at_one_instant, "max_at_one_instant"), std::pair(contact.max_events, "max_events")})
    check_number(number, ValueRange::positive, std::string("/solver/contact/") + key, key);
}

}  // namespace

double find_mass_ratio(std::span<const Incidence> incidences, std::span<const double> inverse_mass) {
  double smallest = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (const Incidence& incidence : incidences) {
    const double inverse = inverse_mass[static_cast<std::size_t>(incidence.point)];
    if (inverse == 0.0) continue;
    smallest = std::min(smallest, inverse);
    largest = std::max(largest, inverse);
  }
  return largest > 0.0 ? largest / smallest : 1.0;
}

NumberedSystem::NumberedSystem(System given, const SolverOptions& options, double t)
    : system(validated(std::move(given), t)),
      parallel((check_solver_options(options), (void)instruction_set(), options.threads)),
      numbering(number(system)),
      is_exact(options.exact),
      max_impacts_at_one_instant(options.contact.max_at_one_instant) {}

Model::Model(NumberedSystem numbered, const Families& families)
    : NumberedSystem(std::move(numbered)),
      mass(masses_in_order(system, numbering)),
      inverse_mass(inverses(mass)),
      incidences(families.constraints.list_incidences()),
      gather(incidences, numbering.num_points()),
      scene_size(detail::scene_size(system)),
      smallest_length(find_smallest_length(families.constraints, scene_size)),
      may_lose_rank(closes_loops(system)),
      mass_ratio(find_mass_ratio(incidences, inverse_mass)),
      uniform_free_(families.forces.uniform_acceleration()),
      num_constrained_(count_constrained(incidences, numbering)),
      num_contacts_(families.constraints.tangents().size()),
      depends_on_time_(families.constraints.depends_on_time() || families.coordinates.depends_on_time()) {
  for (const Support& support : system.supports) {
    PrescribedPoints prescribed{support.displacement, {}, {}};
    for (const Index point : support.points) {
      prescribed.points.push_back(numbering.inner_point[static_cast<std::size_t>(point)]);
      prescribed.position.push_back(load(system.positions.data(), point));
    }
    (support.displacement.is_constant() ? fixed_supports_ : moving_supports_).push_back(std::move(prescribed));
  }
}

void Model::prescribe(const std::vector<PrescribedPoints>& supports, double t, const PrescribedMotion& to) const {
  for (const PrescribedPoints& support : supports) {
    const MovingVec3 d = make_moving(support.displacement(t));
    for (std::size_t k = 0; k < support.points.size(); ++k) {
      const auto point = static_cast<std::size_t>(support.points[k]);
      if (to.r != nullptr) store(to.r, point, support.position[k] + d.value);
      if (to.v != nullptr) store(to.v, point, d.first);
      store(to.accelerations, point - num_moving(), d.second);
    }
  }
}

void Model::prescribe_all(double t, const PrescribedMotion& to) const {
  prescribe(fixed_supports_, t, to);
  prescribe(moving_supports_, t, to);
}

double Model::largest_norm(const double* x) const {
  return parallel.max_over_ranges(num_points(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) worst = larger(worst, dot(load(x, i), load(x, i)));
    return std::sqrt(worst);
  });
}

double Model::largest_move(const double* x, const double* y) const {
  return parallel.max_over_ranges(num_points(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 d = load(x, i) - load(y, i);
      worst = larger(worst, dot(d, d));
    }
    return std::sqrt(worst);
  });
}

double Model::power(const double* a, const double* v) const {
  return parallel.sum(num_moving(), [&](std::size_t i) { return mass[i] * dot(load(a, i), load(v, i)); });
}

Outcome Model::not_finite(double t) const {
  return {Status::NotFinite, "state or forces are not finite at t = " + text(t)};
}

}  // namespace tanor::detail
