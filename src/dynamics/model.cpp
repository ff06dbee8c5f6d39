#include "dynamics/model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "base/eight.hpp"
#include "base/instruction_sets.hpp"
#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "schur/redundancy.hpp"
#include "system/enum_check.hpp"
#include "system/members.hpp"

namespace tanor {

namespace {

std::vector<double> masses_in_order(const System& system, const Numbering& numbering) {
  std::vector<double> result(numbering.num_points(), 0.0);
  for (std::size_t i = 0; i < numbering.num_moving; ++i) {
    result[i] = system.masses[static_cast<std::size_t>(numbering.user_point[i])];
  }
  return result;
}

/// Rods that join what is joined already, or any constraint that is no distance.
bool closes_loops(const System& system, const Numbering& numbering) {
  // Points of one tree have one root; all supports and centers are one place.
  std::vector<Index> parent(numbering.num_moving + 1);
  std::iota(parent.begin(), parent.end(), 0);
  const auto find_root = [&](Index i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      Index& up = parent[static_cast<std::size_t>(i)];
      i = up = parent[static_cast<std::size_t>(up)];
    }
    return i;
  };
  const auto ground = static_cast<Index>(numbering.num_moving);
  const auto place = [&](Index point) {
    return std::min(numbering.inner_point[static_cast<std::size_t>(point)], ground);
  };
  const auto joins_what_is_joined = [&](Index i, Index j) {
    const Index a = find_root(i), b = find_root(j);
    if (a == b) return i != j;  // between supports alone: idle
    parent[static_cast<std::size_t>(a)] = b;
    return false;
  };
  const auto closes = [&]<class Group>(const Group& group) {
    if constexpr (requires { KindOf<Group>::is_distance; }) {
      for (std::size_t k = 0; k < num_members(group); ++k) {
        const std::span<const Index> points = member_points(group, k);
        if (joins_what_is_joined(place(points[0]), points.size() == 2 ? place(points[1]) : ground)) return true;
      }
      return false;
    }
    return true;
  };
  for (const Constraint& constraint : system.constraints) {
    if (std::visit(closes, constraint)) return true;
  }
  return false;
}

std::size_t count_constrained(std::span<const Incidence> incidences, const Numbering& numbering) {
  std::size_t result = 0;
  for (const Incidence& incidence : incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    if (point < numbering.num_moving) result = std::max(result, point + 1);
  }
  return result;
}

/// Lists what looks for narrow places of constraints that are given by formulas.
Model::Formulas list_passages(const System& system, const Numbering& numbering) {
  Model::Formulas result;
  for (const Constraint& constraint : system.constraints) {
    const auto* const group = std::get_if<UserConstraints>(&constraint);
    if (group == nullptr) continue;
    std::vector<Index> points;
    for (const auto& tuple : group->tuples)
      for (const Index point : tuple) points.push_back(numbering.inner_point[static_cast<std::size_t>(point)]);
    if (auto passages = make_constraint_passages(group->kernel, points)) result.push_back(std::move(passages));
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

/// x² + y² + z² of 8 points.
[[gnu::always_inline]] inline Eight add_triples(const Eight& a, const Eight& b, const Eight& c) {
  const Eight x =
      __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 3, 6, 9, 12, 15, 0, 0), c, 0, 1, 2, 3, 4, 5, 10, 13);
  const Eight y =
      __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 4, 7, 10, 13, 0, 0, 0), c, 0, 1, 2, 3, 4, 8, 11, 14);
  const Eight z =
      __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 5, 8, 11, 14, 0, 0, 0), c, 0, 1, 2, 3, 4, 9, 12, 15);
  return x + y + z;
}

template <class Mask>
[[gnu::always_inline]] inline bool are_all(Mask mask) {
  mask &= __builtin_shufflevector(mask, mask, 4, 5, 6, 7, 0, 1, 2, 3);
  mask &= __builtin_shufflevector(mask, mask, 2, 3, 0, 1, 6, 7, 4, 5);
  return (mask[0] & mask[1]) != 0;
}

/// Largest |error_i|/(atol + rtol |.|) of the points [begin, end), where |.| is the larger one by components: at least
/// 8 of them, the last ones twice where they fill no lane.
TANOR_EACH_INSTRUCTION_SET
double largest_ratio(const double* error, const double* from, const double* to, std::size_t begin, std::size_t end,
                     const double* own_atol, double same_atol, double rtol) {
  constexpr std::size_t width = 8;
  // Of squares. (atol + rtol |.|)^2 lies above atol^2 + rtol^2 |.|^2: most points need no root and no quotient.
  Eight worst{};
  auto is_unordered = worst != worst;
  for (std::size_t next = begin; next < end; next += width) {
    const std::size_t first = 3 * std::min(next, end - width);
    Eight square[3], size[3];
    for (std::size_t part = 0; part < 3; ++part) {
      const std::size_t at = first + width * part;
      const Eight e = eight_at(error + at), a = eight_at(from + at), b = eight_at(to + at);
      square[part] = e * e;
      size[part] = a * a > b * b ? a * a : b * b;
    }
    const Eight atol = own_atol != nullptr ? eight_at(own_atol + first / 3) : Eight{} + same_atol;
    const Eight squares = add_triples(square[0], square[1], square[2]);
    const Eight sizes = add_triples(size[0], size[1], size[2]);
    if (are_all(squares <= worst * (atol * atol + rtol * rtol * sizes))) continue;
    std::array<double, width> roots;
    std::memcpy(roots.data(), &sizes, sizeof(sizes));
    for (double& x : roots) x = std::sqrt(x);
    const Eight allowed = atol + rtol * eight_at(roots.data()), ratio = squares / (allowed * allowed);
    is_unordered |= ratio != ratio;
    worst = ratio > worst ? ratio : worst;
  }
  double result = 0.0;
  for (std::size_t k = 0; k < width; ++k)
    result = larger(result, is_unordered[k] != 0 ? std::numeric_limits<double>::quiet_NaN() : worst[k]);
  return std::sqrt(result);
}

double largest_ratio_of_few(const double* error, const double* from, const double* to, std::size_t count,
                            const double* own_atol, double same_atol, double rtol) {
  double worst = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 a = load(from, i), b = load(to, i);
    const double size =
        std::max(a.x * a.x, b.x * b.x) + std::max(a.y * a.y, b.y * b.y) + std::max(a.z * a.z, b.z * b.z);
    const double atol = own_atol != nullptr ? own_atol[i] : same_atol;
    worst = larger(worst, norm(load(error, i)) / (atol + rtol * std::sqrt(size)));
  }
  return worst;
}

void check_solver_options(const SolverOptions& options) {
  check_enum(options.form, Form::Both, "/solver/form");
  check_enum(options.linear_solver, LinearSolver::ClosedForm, "/solver/linear_solver");
  check_enum(options.ordering, Ordering::Natural, "/solver/ordering");
  check_enum(options.friction, FrictionMethod::Enumeration, "/solver/friction");
}

}  // namespace

void describe_factor(const GramSolver::Summary& summary, PlanSummary* plan) {
  plan->parts = summary.parts;
  plan->pattern_nonzeros = summary.pattern_nonzeros;
  plan->factor_nonzeros = static_cast<std::size_t>(summary.factor_nonzeros);
  plan->factor_flops = summary.flops;
  plan->orderings = summary.orderings;
  plan->factorizations = summary.factorizations;
}

Model::Model(System given, const SolverOptions& options, double t)
    : system(validated(std::move(given), t)),
      parallel((check_solver_options(options), options.threads)),
      numbering(number(system)),
      constraints(system, numbering, t),
      forces(system, numbering),
      coordinates(system, numbering, t),
      mass(masses_in_order(system, numbering)),
      inverse_mass(inverses(mass)),
      incidences(constraints.list_incidences()),
      gather(incidences, numbering.num_points()),
      joints(incidences, forces.list_couplings(), numbering.num_moving),
      f(3 * numbering.num_points(), 0.0),
      support_accelerations(3 * (numbering.num_points() - numbering.num_moving), 0.0),
      scene_size(tanor::scene_size(system)),
      smallest_length(constraints.smallest_length(scene_size)),
      scales(find_neighbourhoods(system, t), numbering, incidences, scene_size),
      may_lose_rank(closes_loops(system, numbering)),
      constraint_passages(list_passages(this->system, numbering)),
      coordinate_passages(coordinates.list_passages()),
      mass_ratio(find_mass_ratio(incidences, inverse_mass)),
      drives(system, numbering, inverse_mass, scene_size, t),
      rank(numbering.first_idle_row()),
      uniform_free_(forces.uniform_acceleration()),
      num_constrained_(count_constrained(incidences, numbering)),
      time_(t),
      rows_(constraints.num_rows()) {
  for (const Support& support : system.supports) {
    PrescribedPoints prescribed{support.displacement, {}, {}};
    for (const Index point : support.points) {
      prescribed.points.push_back(numbering.inner_point[static_cast<std::size_t>(point)]);
      prescribed.position.push_back(load(system.positions.data(), point));
    }
    (support.displacement.is_constant() ? fixed_supports_ : moving_supports_).push_back(std::move(prescribed));
  }
  // m g, for good: nobody evaluates it where w0 is known
  if (uniform_free_) forces.evaluate(parallel, t, system.positions.data(), system.velocities.data(), f.data());
}

void Model::set_time(double t) {
  if (t == time_) return;
  time_ = std::numeric_limits<double>::quiet_NaN();  // should a table end before t: no time at all
  constraints.set_time(t);
  coordinates.set_time(t);
  time_ = t;
}

void Model::prescribe(const std::vector<PrescribedPoints>& supports, double t, double* r, double* v) {
  for (const PrescribedPoints& support : supports) {
    const MovingVec3 d = make_moving(support.displacement(t));
    for (std::size_t k = 0; k < support.points.size(); ++k) {
      const auto point = static_cast<std::size_t>(support.points[k]);
      store(r, point, support.position[k] + d.value);
      store(v, point, d.first);
      store(support_accelerations.data(), point - num_moving(), d.second);
    }
  }
}

void Model::prescribe_all(double t, double* r, double* v) {
  prescribe(fixed_supports_, t, r, v);
  prescribe(moving_supports_, t, r, v);
}

double Model::find_passage(const Formulas& formulas, PointPath* path) {
  double part = forces.find_passage(parallel, path);
  for (const auto& formula : formulas) part = std::min(part, formula->find(parallel, path));
  return part;
}

double Model::evaluate_free(double t, const double* r, const double* v, double* w0, Forces::Which which) {
  forces.evaluate(parallel, t, r, v, f.data(), which);
  return accelerate(f.data(), w0);
}

double Model::accelerate(const double* given, double* w0) const {
  std::copy(support_accelerations.begin(), support_accelerations.end(), w0 + 3 * num_moving());
  return parallel.max_over_ranges(num_moving(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 a = inverse_mass[i] * load(given, i);
      store(w0, i, a);
      worst = larger(worst, dot(a, a));
    }
    return std::sqrt(worst);
  });
}

double Model::write_unconstrained(double* w0) const {
  std::copy(support_accelerations.begin(), support_accelerations.end(), w0 + 3 * num_moving());
  if (!uniform_free_) return 0.0;
  for (std::size_t i = num_constrained_; i < num_moving(); ++i) store(w0, i, *uniform_free_);
  return norm(*uniform_free_);
}

void Model::write_uniform(double* w0) const {
  (void)write_unconstrained(w0);
  parallel.for_ranges(num_constrained_, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(w0, i, *uniform_free_);
  });
}

GramSolver::Quality Model::factorize(GramSolver* solver, const double* blocks) {
  {
    const Stopwatch watch(&times.assemble);
    solver->assemble(parallel, blocks);
  }
  const Stopwatch watch(&times.factor);
  ++counters.factorizations;
  return solver->factorize(parallel);
}

void Model::measure_velocity_scale(double t, const double* r, const double* v) {
  std::vector<double> w0(3 * num_points()), zero(3 * num_points(), 0.0);
  const double acceleration = evaluate_free(t, r, v, w0.data());
  const double prescribed = num_rows() > 0 ? constraints.evaluate_rates(parallel, r, zero.data(), rows_.data()) : 0.0;
  velocity_scale = std::max({largest_norm(v), prescribed, std::sqrt(acceleration * scene_size)});
  if (!(velocity_scale > 0.0)) velocity_scale = 1.0;
  measure_local_speeds(r, v, w0.data());
}

void Model::exchange_memory(Memory& memory) {
  std::vector<double> speeds = scales.speeds();
  memory.exchange(velocity_scale, speeds);
  if (memory.reads()) scales.set_speeds(speeds);
}

/// Each neighbourhood's own; `w0`: M^-1 f, prescribed accelerations at supports.
void Model::measure_local_speeds(const double* r, const double* v, const double* w0) {
  const std::vector<double> zero(3 * num_points(), 0.0);
  std::vector<double> speeds = largest_norms(v), position(num_rows()), prescribed(num_rows());
  const std::vector<double> accelerations = largest_norms(w0);
  for (std::size_t k = 0; k < speeds.size(); ++k)
    speeds[k] = std::max(speeds[k], std::sqrt(accelerations[k] * scales.length(k)));
  constraints.measure(r, zero.data(), position.data(), prescribed.data());
  for (std::size_t a = 0; a < num_rows(); ++a) {
    double& own = speeds[scales.of_row(a)];
    own = std::max(own, std::abs(prescribed[a]));
  }
  for (const Incidence& incidence : incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    double& own = speeds[scales.of_row(static_cast<std::size_t>(incidence.row))];
    if (point >= num_moving()) own = std::max(own, norm(load(v, point)));
  }
  const Tangents& tangents = constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    double& own = speeds[scales.of_point(static_cast<std::size_t>(tangents[c].point))];
    own = std::max(own, norm(tangents.own_velocity(c).value));
  }
  speeds.back() = velocity_scale;
  scales.set_speeds(speeds);
}

Energy Model::energy(const double* r, const double* v) const {
  return {parallel.sum(num_moving(), [&](std::size_t i) { return 0.5 * mass[i] * dot(load(v, i), load(v, i)); }),
          forces.potential(parallel, r)};
}

Power Model::power(const double* reaction_accelerations, const double* r, const double* v) const {
  Power result;
  if (is_rheonomic()) {
    // eta'v on the moving points, eta = M (M^-1 eta); and what supports do through springs
    result.supports = parallel.sum(num_moving(), [&](std::size_t i) {
      return mass[i] * dot(load(reaction_accelerations, i), load(v, i));
    }) + forces.elastic_power_of_supports(parallel, r, v);
  }
  if (forces.has_work()) result.forces = forces.power(parallel, r, v);
  return result;
}

double Model::position_violation(double t, const double* r) {
  set_time(t);
  return constraints.evaluate_values(parallel, r, rows_.data());
}

std::vector<double> Model::rank_tolerances(const double* r) {
  // On the way to xi = 0 and back K may differ by so much from the one there, for each unit of violation.
  constexpr double spread = 1e2, largest = 1e-6;  // what S cannot see lies below
  const std::vector<double> at_rest(3 * num_points(), 0.0);
  std::vector<double> result(num_rows());
  constraints.measure(r, at_rest.data(), result.data(), rows_.data());
  for (std::size_t a = 0; a < num_rows(); ++a) {
    const bool is_contact = numbering.is_contact_row(a);
    result[a] = is_contact ? 0.0 : std::min(largest, spread * result[a]);
  }
  return result;
}

double Model::velocity_violation(double t, const double* r, const double* v) {
  set_time(t);
  const double largest = constraints.evaluate_rates(parallel, r, v, rows_.data());
  if (scales.are_one()) return largest / scales.speed(0);
  std::vector<double> position(num_rows()), rates(num_rows());
  constraints.measure(r, v, position.data(), rates.data());
  double worst = 0.0;
  for (std::size_t a = 0; a < num_rows(); ++a)
    worst = larger(worst, std::abs(rates[a]) / scales.speed(scales.of_row(a)));
  return worst;
}

ErrorRatios Model::error_ratios(const StepErrors& errors, double atol, double rtol) const {
  constexpr std::size_t few = 8;
  if (joints.allows_rounding() && !errors.are_of_projections) return joints.error_ratios(errors, atol, rtol, scales);
  const auto largest = [&](const double* error, const double* from, const double* to, std::span<const double> all) {
    const double* const own = atol > 0.0 ? nullptr : all.data();
    if (num_points() < few) return largest_ratio_of_few(error, from, to, num_points(), own, atol, rtol);
    return parallel.max_over_ranges(num_points(), [&](std::size_t begin, std::size_t end) {
      return largest_ratio(error, from, to, begin, end, own, atol, rtol);
    });
  };
  return {largest(errors.x, errors.x_from, errors.x_to, scales.position_tolerances()),
          largest(errors.v, errors.v_from, errors.v_to, scales.velocity_tolerances())};
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

void Model::largest_norms(const double* x, std::vector<double>* result) const {
  result->assign(scales.size(), 0.0);
  for (std::size_t i = 0; i < num_moving(); ++i) {
    double& worst = (*result)[scales.of_point(i)];
    worst = larger(worst, norm(load(x, i)));
  }
}

std::vector<double> Model::largest_norms(const double* x) const {
  std::vector<double> result;
  largest_norms(x, &result);
  return result;
}

double Model::largest_move(const double* x, const double* y, const std::vector<double>& scale) const {
  double worst = 0.0;
  for (std::size_t i = 0; i < num_moving(); ++i)
    worst = larger(worst, norm(load(x, i) - load(y, i)) / scale[scales.of_point(i)]);
  return worst;
}

std::string Model::name_row(std::size_t inner_row) const {
  const auto row = static_cast<std::size_t>(numbering.user_row[inner_row]);
  if (row < numbering.num_user_rows) return equation_name(system, row);
  const Tangents& tangents = constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Tangents::Place& place = tangents[c];
    const auto first = static_cast<std::size_t>(place.first_row);
    if (place.first_row >= 0 && inner_row - first < static_cast<std::size_t>(place.num_tangents()))
      return name_contact(c);
  }
  return "a contact";
}

void Model::clear_contacts(double* blocks) const {
  constraints.tangents().list_incidences([&](const Incidence& i) { store(blocks, i.block, Vec3{}); });
}

std::vector<double> Model::without_contacts(const std::vector<double>& blocks) const {
  std::vector<double> result = blocks;
  clear_contacts(result.data());
  return result;
}

std::string Model::name_contact(std::size_t contact) const {
  const Tangents::Place& place = constraints.tangents()[contact];
  const std::string guide = name_row(static_cast<std::size_t>(place.guide_row[0]));  // "wire[4].0"
  return friction_name(system, static_cast<std::size_t>(place.friction)) + " at " +
         guide.substr(0, guide.find(']') + 1) + ", point " +
         std::to_string(numbering.user_point[static_cast<std::size_t>(place.point)]);
}

Outcome Model::check_contacts(double t) const {
  const Tangents& tangents = constraints.tangents();
  const std::size_t c = tangents.find_undirected();
  if (c == tangents.size()) return {};
  return {Status::Singular, "friction at t = " + text(t) + ": " + name_contact(c) +
                                (tangents[c].num_guides == 2
                                     ? ": its two surfaces are parallel there, and where it may slide is not defined; "
                                       "a list in \"at\" names the two surfaces that cross in a wire"
                                     : ": its surface has no normal there")};
}

Outcome Model::not_finite(double t) const {
  return {Status::NotFinite, "state or forces are not finite at t = " + text(t)};
}

}  // namespace tanor
