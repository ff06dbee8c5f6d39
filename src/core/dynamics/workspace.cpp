#include "dynamics/workspace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"
#include "base/stopwatch.hpp"
#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor::detail {

namespace {

/// Lists the formulas of constraints in which a step may pass a narrow feature unseen.
Workspace::Formulas list_features(const System& system, const Numbering& numbering) {
  Workspace::Formulas result;
  const Index first_outside = find_first_outside(system);
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    const auto* const group = std::get_if<UserConstraints>(&system.constraints[k]);
    if (group == nullptr) continue;
    std::vector<Index> points;
    for (const auto& tuple : group->tuples)
      for (const Index point : tuple)
        if (point < first_outside) points.push_back(numbering.inner_point[static_cast<std::size_t>(point)]);
    auto features = make_constraint_features(group->kernel, points);
    if (features == nullptr) continue;
    features->name = constraint_name(system, k);
    result.push_back(std::move(features));
  }
  return result;
}

/// Lists the points that springs or energies join.
std::vector<Coupling> list_joints(const Forces& forces) {
  std::vector<Coupling> result = forces.list_couplings();
  for (const auto& [on, of] : forces.list_influences()) result.push_back({on, of});
  return result;
}

/// Returns x² + y² + z² of 8 points.
[[gnu::always_inline]] inline Pack<> add_triples(const Pack<>& a, const Pack<>& b, const Pack<>& c) {
  const Pack<> x =
      __builtin_shufflevector(__builtin_shufflevector(a, b, 0, 3, 6, 9, 12, 15, 0, 0), c, 0, 1, 2, 3, 4, 5, 10, 13);
  const Pack<> y =
      __builtin_shufflevector(__builtin_shufflevector(a, b, 1, 4, 7, 10, 13, 0, 0, 0), c, 0, 1, 2, 3, 4, 8, 11, 14);
  const Pack<> z =
      __builtin_shufflevector(__builtin_shufflevector(a, b, 2, 5, 8, 11, 14, 0, 0, 0), c, 0, 1, 2, 3, 4, 9, 12, 15);
  return x + y + z;
}

template <class Mask>
[[gnu::always_inline]] inline bool are_all(const Mask& given) {
  Mask mask = given & __builtin_shufflevector(given, given, 4, 5, 6, 7, 0, 1, 2, 3);
  mask &= __builtin_shufflevector(mask, mask, 2, 3, 0, 1, 6, 7, 4, 5);
  return (mask[0] & mask[1]) != 0;
}

/// Returns the largest |error_i|/(atol + rtol |.|) of the points [begin, end), where |.| is the larger one by
/// components. There must be at least 8 points; the last pack may repeat some.
double largest_ratio(const double* error, const double* from, const double* to, std::size_t begin, std::size_t end,
                     const double* own_atol, double same_atol, double rtol) {
  return dispatch([=] {
    constexpr std::size_t width = num_lanes;
    // The largest square. Since (atol + rtol |.|)^2 >= atol^2 + rtol^2 |.|^2, most points need no root and no quotient.
    Pack<> worst{};
    auto is_unordered = worst != worst;
    for (std::size_t next = begin; next < end; next += width) {
      const std::size_t first = 3 * std::min(next, end - width);
      Pack<> square[3], size[3];
      for (std::size_t part = 0; part < 3; ++part) {
        const std::size_t at = first + width * part;
        const Pack<> e = pack_at(error + at), a = pack_at(from + at), b = pack_at(to + at);
        square[part] = e * e;
        size[part] = a * a > b * b ? a * a : b * b;
      }
      const Pack<> own = pack_at(own_atol + first / 3), same = Pack<>{} + same_atol, least = Scales::rounding * own;
      const Pack<> atol = same_atol > 0.0 ? (same > least ? same : least) : own;
      const Pack<> squares = add_triples(square[0], square[1], square[2]);
      const Pack<> sizes = add_triples(size[0], size[1], size[2]);
      if (are_all(squares <= worst * (atol * atol + rtol * rtol * sizes))) continue;
      std::array<double, width> roots;
      std::memcpy(roots.data(), &sizes, sizeof(sizes));
      for (double& x : roots) x = std::sqrt(x);
      const Pack<> allowed = atol + rtol * pack_at(roots.data()), ratio = squares / (allowed * allowed);
      is_unordered |= ratio != ratio;
      worst = ratio > worst ? ratio : worst;
    }
    double result = 0.0;
    for (std::size_t k = 0; k < width; ++k)
      result = larger(result, is_unordered[k] != 0 ? std::numeric_limits<double>::quiet_NaN() : worst[k]);
    return std::sqrt(result);
  });
}

double largest_ratio_of_few(const double* error, const double* from, const double* to, std::size_t count,
                            const double* own_atol, double same_atol, double rtol) {
  double worst = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 a = load(from, i), b = load(to, i);
    const double size =
        std::max(a.x * a.x, b.x * b.x) + std::max(a.y * a.y, b.y * b.y) + std::max(a.z * a.z, b.z * b.z);
    const double atol = Scales::choose(same_atol, own_atol[i]);
    worst = larger(worst, norm(load(error, i)) / (atol + rtol * std::sqrt(size)));
  }
  return worst;
}

}  // namespace

void describe_factor(const FactorSummary& factor, PlanSummary* plan) {
  plan->parts = factor.parts;
  plan->pattern_nonzeros = factor.pattern_nonzeros;
  plan->factor_nonzeros = factor.factor_nonzeros;
  plan->factor_flops = factor.flops;
  plan->orderings = factor.orderings;
  plan->factorizations = factor.factorizations;
}

Workspace::Workspace(System given, const SolverOptions& options, double t, const MakeTeam& make_team)
    : Workspace(NumberedSystem(std::move(given), options, t), t) {
  if (make_team) team_ = make_team(*this);
  has_rows_ = team_->any(model_.num_rows() > 0);
  is_rheonomic_ = team_->any(model_.is_rheonomic());
}

Workspace::Workspace(NumberedSystem numbered, double t)
    : Families(numbered, t),
      model_(std::move(numbered), *this),
      joints(model_.incidences, list_joints(forces), model_.num_moving()),
      drives(model_.system, model_.numbering, model_.inverse_mass, model_.scene_size, t),
      scales(find_neighbourhoods(model_.system, t), model_.numbering, model_.incidences, model_.scene_size),
      f(3 * model_.num_points(), 0.0),
      constraint_features(list_features(model_.system, model_.numbering)),
      coordinate_features(coordinates.list_features()),
      rank(model_.numbering.first_idle_row()),
      time_(t),
      supports_at_(std::numeric_limits<double>::quiet_NaN()),
      support_accelerations_(3 * (model_.num_points() - model_.num_moving()), 0.0),
      rows_(model_.num_rows()) {
  // f = m g is constant, and is not evaluated again where w0 is known.
  const System& system = model_.system;
  if (model_.uniform_free() != nullptr)
    forces.evaluate(model_.parallel, t, system.positions.data(), system.velocities.data(), f.data());
}

void Workspace::set_time(double t) {
  if (t == time_) return;
  time_ = std::numeric_limits<double>::quiet_NaN();  // remains NaN if a table ends before t
  constraints.set_time(t);
  coordinates.set_time(t);
  time_ = t;
}

void Workspace::prescribe(double t, double* r, double* v) {
  supports_at_ = std::numeric_limits<double>::quiet_NaN();  // remains NaN if a table ends before t
  model_.prescribe(t, {r, v, support_accelerations_.data()});
  supports_at_ = t;
}

void Workspace::prescribe_all(double t, double* r, double* v) {
  supports_at_ = std::numeric_limits<double>::quiet_NaN();
  model_.prescribe_all(t, {r, v, support_accelerations_.data()});
  supports_at_ = t;
}

/// Finds them anew unless the last call was at t, so that nobody reads those of another instant.
void Workspace::write_support_accelerations(double t, double* w0) {
  if (t != supports_at_) prescribe(t, nullptr, nullptr);
  std::copy(support_accelerations_.begin(), support_accelerations_.end(), w0 + 3 * model_.num_moving());
}

double Workspace::evaluate_free(double t, const double* r, const double* v, double* w0, Forces::Which which) {
  forces.evaluate(model_.parallel, t, r, v, f.data(), which);
  write_support_accelerations(t, w0);
  const double largest = model_.parallel.max_over_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 a = model_.inverse_mass[i] * load(f.data(), i);
      store(w0, i, a);
      worst = larger(worst, dot(a, a));
    }
    return std::sqrt(worst);
  });
  team_->fetch_guests(w0);
  return largest;
}

double Workspace::write_unconstrained(double t, double* w0) {
  write_support_accelerations(t, w0);
  if (model_.uniform_free() == nullptr) return 0.0;
  for (std::size_t i = model_.num_constrained(); i < model_.num_moving(); ++i) store(w0, i, *model_.uniform_free());
  return norm(*model_.uniform_free());
}

void Workspace::write_uniform(double t, double* w0) {
  (void)write_unconstrained(t, w0);
  model_.parallel.for_ranges(model_.num_constrained(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(w0, i, *model_.uniform_free());
  });
  team_->fetch_guests(w0);
}

GramSolver::Quality Workspace::factorize(GramSolver* solver, const double* blocks) {
  {
    const Stopwatch watch(&times.assemble);
    solver->assemble(model_.parallel, blocks);
  }
  const Stopwatch watch(&times.factor);
  ++counters.factorizations;
  return solver->factorize(model_.parallel);
}

std::string Workspace::find_collision(const Kinematics& points, double within) const {
  std::size_t next = 0;
  for (std::size_t k = 0; k < model_.system.forces.size(); ++k) {
    if (!std::holds_alternative<PairForces>(model_.system.forces[k])) continue;
    const std::optional<PairField::Collision> found = forces.pairs()[next++].find_collision(points.x, points.v, within);
    if (!found) continue;
    const auto user = [&](Index point) { return text(model_.numbering.user_point[static_cast<std::size_t>(point)]); };
    return force_name(model_.system, k) + ": points " + user(found->i) + " and " + user(found->j) + ", which are " +
           with_unit(text(found->distance), model_.system.units.length) + " apart, fall onto each other";
  }
  return {};
}

void Workspace::measure_velocity_scale(double t, const double* r, const double* v) {
  std::vector<double> w0(3 * model_.num_points()), zero(3 * model_.num_points(), 0.0);
  const double acceleration = evaluate_free(t, r, v, w0.data());
  const double prescribed =
      model_.num_rows() > 0 ? constraints.evaluate_rates(model_.parallel, r, zero.data(), rows_.data()) : 0.0;
  velocity_scale =
      team_->largest(std::max({model_.largest_norm(v), prescribed, std::sqrt(acceleration * model_.scene_size)}));
  if (!(velocity_scale > 0.0)) velocity_scale = 1.0;
  measure_local_speeds(r, v, w0.data());
}

void Workspace::exchange_memory(Memory& memory) {
  memory.exchange(velocity_scale);
  scales.exchange_memory(memory);
}

/// Measures the speed scale of each neighbourhood. `w0` is M^-1 f, with prescribed accelerations at supports.
void Workspace::measure_local_speeds(const double* r, const double* v, const double* w0) {
  const std::vector<double> zero(3 * model_.num_points(), 0.0);
  std::vector<double> speeds = largest_norms(v), position(model_.num_rows()), prescribed(model_.num_rows());
  const std::vector<double> accelerations = largest_norms(w0);
  for (std::size_t k = 0; k < speeds.size(); ++k)
    speeds[k] = std::max(speeds[k], std::sqrt(accelerations[k] * scales.length(k)));
  constraints.measure(r, zero.data(), position.data(), prescribed.data());
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    double& own = speeds[scales.of_row(a)];
    own = std::max(own, std::abs(prescribed[a]));
  }
  for (const Incidence& incidence : model_.incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    double& own = speeds[scales.of_row(static_cast<std::size_t>(incidence.row))];
    if (point >= model_.num_moving()) own = std::max(own, norm(load(v, point)));
  }
  const Tangents& tangents = constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    double& own = speeds[scales.of_point(static_cast<std::size_t>(tangents[c].point))];
    own = std::max(own, norm(tangents.own_velocity(c).value));
  }
  team_->find_largest(speeds);
  speeds.back() = velocity_scale;
  scales.set_speeds(speeds);
  scales.set_least(team_->smallest(scales.least_speed()), team_->smallest(scales.least_acceleration()));
}

Energy Workspace::energy(double t, const double* r, const double* v) {
  const auto twice_kinetic = [&](std::size_t i) { return model_.mass[i] * dot(load(v, i), load(v, i)); };
  return {0.5 * model_.parallel.sum(model_.num_moving(), twice_kinetic), potential(t, r)};
}

double Workspace::potential(double t, const double* r) {
  return forces.potential(model_.parallel, t, r) - team_->potential_elsewhere(t, r);
}

/// Forces on guests do no work of supports.
Power Workspace::power(double of_constraints, const Kinematics& at) {
  Power result;
  if (is_rheonomic_) {
    const double* const v_supports = team_->without_guests(at.v, &own_v_);
    result.supports = of_constraints + forces.elastic_power_of_supports(model_.parallel, at.x, v_supports);
  }
  if (forces.has_work()) {
    result.forces = forces.power(model_.parallel, at.x, at.v);
    result.potentials = forces.energies().explicit_rate(model_.parallel);
  }
  result.potentials -= team_->rate_elsewhere(at);
  return result;
}

/// Returns eta'v, with eta = M (M^-1 eta).
double Workspace::power_of_reactions(const double* accelerations, const double* v) const {
  return is_rheonomic_ ? model_.power(accelerations, v) : 0.0;
}

Outcome Workspace::not_finite(double t, const double* r) const {
  const std::string energy = forces.energies().find_undefined(model_.parallel, t, r);
  if (energy.empty()) return model_.not_finite(t);
  return {Status::NotFinite, energy + " at t = " + text(t)};
}

double Workspace::position_violation(double t, const double* r) {
  set_time(t);
  return constraints.evaluate_values(model_.parallel, r, rows_.data());
}

std::vector<double> Workspace::rank_tolerances(const double* r) {
  // The tolerance for each unit of violation, since K differs from that on xi = 0.
  constexpr double spread = 1e2, largest = 1e-6;  // dependences that S cannot show lie below
  const std::vector<double> at_rest(3 * model_.num_points(), 0.0);
  std::vector<double> result(model_.num_rows());
  constraints.measure(r, at_rest.data(), result.data(), rows_.data());
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    const bool is_contact = model_.numbering.is_contact_row(a);
    result[a] = is_contact ? 0.0 : std::min(largest, spread * result[a]);
  }
  return result;
}

double Workspace::velocity_violation(double t, const double* r, const double* v) {
  set_time(t);
  const double largest = constraints.evaluate_rates(model_.parallel, r, v, rows_.data());
  if (scales.are_one()) return largest / scales.speed(0);
  std::vector<double> position(model_.num_rows()), rates(model_.num_rows());
  constraints.measure(r, v, position.data(), rates.data());
  double worst = 0.0;
  for (std::size_t a = 0; a < model_.num_rows(); ++a)
    worst = larger(worst, std::abs(rates[a]) / scales.speed(scales.of_row(a)));
  return worst;
}

ErrorRatios Workspace::error_ratios(const StepErrors& errors, double atol, double rtol) const {
  constexpr std::size_t few = 8;
  if (joints.allows_rounding() && !errors.are_of_projections) return joints.error_ratios(errors, atol, rtol, scales);
  const auto largest = [&](const double* error, const double* from, const double* to, std::span<const double> all) {
    const double* const own = all.data();
    if (model_.num_points() < few) return largest_ratio_of_few(error, from, to, model_.num_points(), own, atol, rtol);
    return model_.parallel.max_over_ranges(model_.num_points(), [&](std::size_t begin, std::size_t end) {
      return largest_ratio(error, from, to, begin, end, own, atol, rtol);
    });
  };
  return {largest(errors.x, errors.x_from, errors.x_to, scales.position_tolerances()),
          largest(errors.v, errors.v_from, errors.v_to, scales.velocity_tolerances())};
}

void Workspace::largest_norms(const double* x, std::vector<double>* result) const {
  result->assign(scales.size(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    double& worst = (*result)[scales.of_point(i)];
    worst = larger(worst, dot(load(x, i), load(x, i)));
  }
  for (double& worst : *result) worst = std::sqrt(worst);
}

std::vector<double> Workspace::largest_norms(const double* x) const {
  std::vector<double> result;
  largest_norms(x, &result);
  return result;
}

double Workspace::largest_move(const double* x, const double* y, const std::vector<double>& scale) const {
  double worst = 0.0;
  for (std::size_t i = 0; i < model_.num_moving(); ++i)
    worst = larger(worst, norm(load(x, i) - load(y, i)) / scale[scales.of_point(i)]);
  return worst;
}

std::string Workspace::name_row(std::size_t inner_row) const {
  const auto row = static_cast<std::size_t>(model_.numbering.user_row[inner_row]);
  if (row < model_.numbering.num_user_rows) return equation_name(model_.system, row);
  const Tangents& tangents = constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Tangents::Place& place = tangents[c];
    const auto first = static_cast<std::size_t>(place.first_row);
    if (place.first_row >= 0 && inner_row - first < static_cast<std::size_t>(place.num_tangents()))
      return name_contact(c);
  }
  return "a contact";
}

void Workspace::clear_contacts(double* blocks) const {
  constraints.tangents().list_incidences([&](const Incidence& i) { store(blocks, i.block, Vec3{}); });
}

std::vector<double> Workspace::without_contacts(const std::vector<double>& blocks) const {
  std::vector<double> result = blocks;
  clear_contacts(result.data());
  return result;
}

std::string Workspace::name_contact(std::size_t contact) const {
  const Tangents::Place& place = constraints.tangents()[contact];
  const std::string guide = name_row(static_cast<std::size_t>(place.guide_row[0]));  // "wire[4].0"
  return friction_name(model_.system, static_cast<std::size_t>(place.friction)) + " at " +
         guide.substr(0, guide.find(']') + 1) + ", point " +
         std::to_string(model_.numbering.user_point[static_cast<std::size_t>(place.point)]);
}

Outcome Workspace::check_contacts(double t) const {
  const Tangents& tangents = constraints.tangents();
  const std::size_t c = tangents.find_undirected();
  if (c == tangents.size()) return {};
  return {Status::Singular, "friction at t = " + text(t) + ": " + name_contact(c) +
                                (tangents[c].num_guides == 2
                                     ? ": its two surfaces are parallel there, and where it may slide is not defined; "
                                       "a list in \"at\" names the two surfaces that cross in a wire"
                                     : ": its surface has no normal there")};
}

}  // namespace tanor::detail
