#include "dynamics/normal_form.hpp"

#include <algorithm>
#include <limits>

#include "base/check.hpp"
#include "base/stopwatch.hpp"
#include "system/text.hpp"

namespace tanor {

namespace {

std::vector<double> masses_in_order(const System& system, const Numbering& numbering) {
  std::vector<double> result(numbering.num_points(), 0.0);
  for (std::size_t i = 0; i < numbering.num_moving; ++i) {
    result[i] = system.masses[static_cast<std::size_t>(numbering.user_point[i])];
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

}  // namespace

NormalForm::NormalForm(System system, SolverOptions options, double t)
    : system_(validated(std::move(system), t)),
      parallel_(options.threads),
      numbering_(number(system_)),
      constraints_(system_, numbering_, t),
      forces_(system_, numbering_),
      mass_(masses_in_order(system_, numbering_)),
      inverse_mass_(inverses(mass_)),
      incidences_(constraints_.list_incidences()),
      gather_(incidences_, numbering_.num_points()),
      solver_(incidences_, inverse_mass_, numbering_, options.ordering, constraints_.squared_gradient_norms()),
      support_accelerations_(3 * (numbering_.num_points() - numbering_.num_moving), 0.0),
      time_(t),
      blocks_(3 * constraints_.num_blocks()),
      f_(3 * numbering_.num_points(), 0.0),
      dw_(3 * numbering_.num_points(), 0.0),
      right_side_(constraints_.num_rows()),
      lambda_(constraints_.num_rows(), 0.0),
      rows_(constraints_.num_rows()),
      step_multipliers_{std::vector<double>(num_rows()), std::vector<double>(num_rows()),
                        std::vector<double>(num_rows())},
      scene_size_(scene_size(system_)) {
  for (const Support& support : system_.supports) {
    PrescribedPoints prescribed{support.displacement, {}, {}};
    for (const Index point : support.points) {
      prescribed.points.push_back(numbering_.inner_point[static_cast<std::size_t>(point)]);
      prescribed.position.push_back(load(system_.positions.data(), point));
    }
    (support.displacement.is_constant() ? fixed_supports_ : moving_supports_).push_back(std::move(prescribed));
  }
  smallest_length_ = constraints_.smallest_length(scene_size_);
  plan_.points = numbering_.num_points();
  plan_.supports = plan_.points - numbering_.num_moving;
  plan_.equations = num_rows();
  plan_.islands = numbering_.num_islands();
  for (std::size_t a = numbering_.first_idle_row(); a < num_rows(); ++a) {
    plan_.idle_equations.push_back(static_cast<std::size_t>(numbering_.user_row[a]));
  }
  const NormalSolver::Summary& summary = solver_.summary();
  plan_.parts = summary.parts;
  plan_.pattern_nonzeros = summary.pattern_nonzeros;
  plan_.factor_nonzeros = static_cast<std::size_t>(summary.factor_nonzeros);
  plan_.factor_flops = summary.flops;
  plan_.ordering = summary.ordering;
  plan_.factorization = summary.factorization;
  plan_what_is_left_out();
}

void NormalForm::plan_what_is_left_out() {
  auto& left_out = plan_.left_out;
  left_out.push_back("friction stage: constraints are ideal");
  left_out.push_back("tangent form: no coordinates are given");
  if (num_rows() == 0)
    left_out.push_back("factorization: no constraints");
  else if (constraints_.gradients_are_constant())
    left_out.push_back("refactorization: K is constant");
  if (constraints_.gradient_norms_are_constant()) left_out.push_back("rescaling of S: its diagonal is constant");
  if (!constraints_.depends_on_time()) left_out.push_back("xi_t terms: no constraint depends on time");
  if (moving_supports_.empty()) left_out.push_back("support motion: every support is fixed");
  if (!has_work()) left_out.push_back("work integral: energy is conserved");
  if (!forces_.has_springs()) left_out.push_back("spring forces: none");
  if (!forces_.has_pairs()) left_out.push_back("pair forces: none");
}

// ---- one instant ----

void NormalForm::set_time(double t) {
  if (t == time_) return;
  time_ = std::numeric_limits<double>::quiet_NaN();  // should a table end before t: no time at all
  constraints_.set_time(t);
  time_ = t;
}

void NormalForm::prescribe(const std::vector<PrescribedPoints>& supports, double t, double* r, double* v) {
  for (const PrescribedPoints& support : supports) {
    const MovingVec3 d = make_moving(support.displacement(t));
    for (std::size_t k = 0; k < support.points.size(); ++k) {
      const auto point = static_cast<std::size_t>(support.points[k]);
      store(r, point, support.position[k] + d.value);
      store(v, point, d.first);
      store(support_accelerations_.data(), point - num_moving(), d.second);
    }
  }
}

void NormalForm::prescribe(double t, double* r, double* v) {
  prescribe(moving_supports_, t, r, v);
}

void NormalForm::prescribe_all(double t, double* r, double* v) {
  prescribe(fixed_supports_, t, r, v);
  prescribe(moving_supports_, t, r, v);
}

/// w0 = M^-1 f on moving points, the prescribed acceleration at supports.
double NormalForm::evaluate_free(double t, const double* r, const double* v, double* w0) {
  forces_.evaluate(parallel_, t, r, v, f_.data());
  std::copy(support_accelerations_.begin(), support_accelerations_.end(), w0 + 3 * num_moving());
  return parallel_.max_over_ranges(num_moving(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 a = inverse_mass_[i] * load(f_.data(), i);
      store(w0, i, a);
      worst = larger(worst, dot(a, a));
    }
    return std::sqrt(worst);
  });
}

Outcome NormalForm::free_accelerations(double t, const double* r, const double* v, double* w) {
  const Stopwatch watch(&times_.evaluate);
  return std::isfinite(evaluate_free(t, r, v, w)) ? Outcome{} : not_finite(t);
}

Outcome NormalForm::factorize(double t) {
  {
    const Stopwatch watch(&times_.assemble);
    solver_.assemble(parallel_, blocks_.data());
  }
  const Stopwatch watch(&times_.factor);
  ++counters_.factorizations;
  const NormalSolver::Quality quality = solver_.factorize(parallel_);
  last_.reciprocal_condition = quality.reciprocal_condition;
  is_factorized_ = quality.positive_definite && quality.reciprocal_condition > NormalSolver::singular_below;
  if (is_factorized_) return {};
  return explain_singular(t, quality.weakest_row);
}

Outcome NormalForm::linearise(double t, const double* r) {
  set_time(t);
  if (num_rows() == 0 || (is_factorized_ && constraints_.gradients_are_constant())) return {};
  {
    const Stopwatch watch(&times_.evaluate);
    constraints_.evaluate_gradients(parallel_, r, blocks_.data());
  }
  return factorize(t);
}

/// rows := -S^-1 rows, points += M^-1 K rows.
void NormalForm::correct(double* rows, double* points) {
  const Stopwatch watch(&times_.solve);
  ++counters_.solves;
  solver_.solve_negative(parallel_, rows, rows);
  gather_.add_scaled(parallel_, blocks_.data(), rows, inverse_mass_.data(), num_moving(), points);
}

Outcome NormalForm::accelerations(double t, const double* r, const double* v, Gradients gradients, double* w) {
  set_time(t);
  ++counters_.evaluations;
  const bool fresh = gradients == Gradients::Evaluate && !(is_factorized_ && constraints_.gradients_are_constant());
  double scale = 0.0;
  {
    const Stopwatch watch(&times_.evaluate);
    scale = evaluate_free(t, r, v, w);
    // b = phi + K'w0
    const double largest_b =
        constraints_.evaluate_right_side(parallel_, r, v, w, right_side_.data(), fresh ? blocks_.data() : nullptr);
    scale = larger(scale, largest_b);
  }
  last_.residual = 0.0;
  last_.refinements = 0;
  if (!std::isfinite(scale)) return last_.outcome = not_finite(t);
  if (num_rows() == 0) return last_.outcome = {};
  if (fresh) {
    if (Outcome outcome = factorize(t); !outcome.ok()) return last_.outcome = outcome;
  }
  if (Outcome outcome = check_idle_rows(t, scale); !outcome.ok()) return last_.outcome = outcome;

  // S lambda = -b, dw = M^-1 K lambda; then refinement in w (theory, section 8):
  // rho = K'dw + b = K'w + phi, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho.
  const double good_enough = exact_ ? 1e-15 : 1e-12;
  constexpr int most_passes = 5;
  {
    const Stopwatch watch(&times_.solve);
    ++counters_.solves;
    solver_.solve_negative(parallel_, right_side_.data(), lambda_.data());
    gather_.write_scaled(parallel_, blocks_.data(), lambda_.data(), inverse_mass_.data(), num_moving(), dw_.data());
  }
  double residual = 0.0;
  for (int pass = 0;; ++pass) {
    const double before = residual;
    residual = constraints_.apply_transposed(parallel_, blocks_.data(), dw_.data(), right_side_.data(), rows_.data()) /
               (scale > 0.0 ? scale : 1.0);
    if (residual <= good_enough || pass == most_passes || (pass > 0 && !(residual < 0.5 * before))) break;
    ++last_.refinements;
    correct(rows_.data(), dw_.data());
    for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
  }
  last_.residual = residual;
  if (!std::isfinite(residual)) return last_.outcome = not_finite(t);

  // w = w0 + M^-1 K lambda (25)
  parallel_.for_ranges(3 * num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) w[i] += dw_[i];
  });
  return last_.outcome = {};
}

/// Rows that join supports alone take no part in S: what is prescribed must satisfy them by itself.
Outcome NormalForm::check_idle_rows(double t, double scale) const {
  constexpr double allowed = 1e-8;
  for (std::size_t a = numbering_.first_idle_row(); a < num_rows(); ++a) {
    // phi + K'w0 with the supports' accelerations in w0
    if (std::abs(right_side_[a]) <= allowed * scale) continue;
    return {Status::Contradictory,
            name_row(a) + " joins supports alone, and their prescribed motion breaks it at t = " + text(t) + " (by " +
                text(right_side_[a]) + " on the acceleration level)"};
  }
  return {};
}

/// Names the row that is farthest from 0 in `rows_` = xi.
Outcome NormalForm::explain_stall(double t, double violation) const {
  const auto worst =
      std::max_element(rows_.begin(), rows_.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  const auto row = static_cast<std::size_t>(worst - rows_.begin());
  const std::string place = name_row(row) + " at t = " + text(t) + ", violation " + text(violation);
  if (row >= numbering_.first_idle_row()) {
    return {Status::Contradictory, "what is prescribed at supports breaks " + place};
  }
  return {Status::NotConverged, "projection onto the constraints stalls; the worst is " + place};
}

/// A gradient that does not exist, or one that depends on others.
Outcome NormalForm::explain_singular(double t, std::size_t weakest_row) const {
  double largest2 = 0.0;  // |gradient|^2 of the weakest row
  for (const Incidence& incidence : incidences_) {
    const Vec3 gradient = load(blocks_.data(), incidence.block);
    const double norm2 = dot(gradient, gradient);
    if (!std::isfinite(norm2)) {
      return {Status::Singular, "the gradient of " + name_row(static_cast<std::size_t>(incidence.row)) +
                                    " does not exist at t = " + text(t) + ": a point lies where it is measured from"};
    }
    if (static_cast<std::size_t>(incidence.row) == weakest_row) largest2 = std::max(largest2, norm2);
  }
  if (std::sqrt(largest2) * scene_size_ < 1e-12) {
    return {Status::Singular, "the gradient of " + name_row(weakest_row) + " vanishes at t = " + text(t)};
  }
  return {Status::Singular, "S = K'M^-1K is singular at t = " + text(t) + ": " + name_row(weakest_row) +
                                " depends on other constraints (redundant or contradictory)"};
}

Outcome NormalForm::not_finite(double t) const {
  return {Status::NotFinite, "state or forces are not finite at t = " + text(t)};
}

std::string NormalForm::name_row(std::size_t inner_row) const {
  return equation_name(system_, static_cast<std::size_t>(numbering_.user_row[inner_row]));
}

// ---- outputs ----

Outcome NormalForm::normal_accelerations(double t, const double* r, const double* v, double* w_normal) {
  set_time(t);
  std::fill(w_normal, w_normal + size(), 0.0);
  if (num_rows() == 0) return {};
  std::vector<double> unit(inverse_mass_);
  for (double& mass : unit) mass = mass > 0.0 ? 1.0 : 0.0;
  // phi, with the supports' accelerations in it
  std::vector<double> blocks(blocks_.size()), given(size(), 0.0), phi(num_rows());
  std::copy(support_accelerations_.begin(), support_accelerations_.end(), given.data() + 3 * num_moving());
  constraints_.evaluate_right_side(parallel_, r, v, given.data(), phi.data(), blocks.data());
  // Gamma has the pattern of S: the same machinery with unit masses.
  NormalSolver gamma(incidences_, unit, numbering_, Ordering::Auto, constraints_.squared_gradient_norms());
  gamma.assemble(parallel_, blocks.data());
  const NormalSolver::Quality quality = gamma.factorize(parallel_);
  if (!quality.positive_definite || quality.reciprocal_condition <= NormalSolver::singular_below) {
    return {Status::Singular, "Gamma = K'K is singular at " + name_row(quality.weakest_row)};
  }
  // w_N = -K Gamma^-1 phi (21), refined once: rho = K'w_N + phi
  std::vector<double> x = phi;
  for (int pass = 0; pass < 2; ++pass) {
    gamma.solve_negative(parallel_, x.data(), x.data());
    gather_.add_scaled(parallel_, blocks.data(), x.data(), unit.data(), num_moving(), w_normal);
    constraints_.apply_transposed(parallel_, blocks.data(), w_normal, phi.data(), x.data());
  }
  return {};
}

void NormalForm::support_forces(double* carried) const {
  reactions(carried);
  std::fill(carried, carried + 3 * num_moving(), 0.0);
  for (std::size_t i = 3 * num_moving(); i < size(); ++i) carried[i] += f_[i];
}

double NormalForm::largest_norm(const double* x) const {
  return parallel_.max_over_ranges(numbering_.num_points(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) worst = larger(worst, dot(load(x, i), load(x, i)));
    return std::sqrt(worst);
  });
}

double NormalForm::largest_move(const double* x, const double* y) const {
  return parallel_.max_over_ranges(numbering_.num_points(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 d = load(x, i) - load(y, i);
      worst = larger(worst, dot(d, d));
    }
    return std::sqrt(worst);
  });
}

Power NormalForm::power(const double* r, const double* v) const {
  Power result;
  if (is_rheonomic()) {
    // eta'v on the moving points, eta = M (w - w0); and what supports do through springs and pairs
    result.supports = parallel_.sum(num_moving(), [&](std::size_t i) {
      return mass_[i] * dot(load(dw_.data(), i), load(v, i));
    }) + forces_.elastic_power_of_supports(parallel_, r, v);
  }
  if (forces_.has_work()) result.forces = forces_.power(parallel_, r, v);
  return result;
}

Energy NormalForm::energy(const double* r, const double* v) const {
  return {parallel_.sum(num_moving(), [&](std::size_t i) { return 0.5 * mass_[i] * dot(load(v, i), load(v, i)); }),
          forces_.potential(parallel_, r)};
}

double NormalForm::position_violation(double t, const double* r) {
  set_time(t);
  return constraints_.evaluate_values(parallel_, r, rows_.data());
}

double NormalForm::velocity_violation(double t, const double* r, const double* v) {
  set_time(t);
  return constraints_.evaluate_rates(parallel_, r, v, rows_.data()) / velocity_scale_;
}

}  // namespace tanor
