#include "dynamics/tangent_form.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor {

namespace {

constexpr double good_enough = 1e-12;  // error of w, of the largest acceleration

}  // namespace

TangentForm::TangentForm(Model& model, const SolverOptions& options)
    : TangentForm(model, options, model.coordinates.list_products(model.mass)) {}

TangentForm::TangentForm(Model& model, const SolverOptions& options, const std::vector<Product>& products)
    : model_(model),
      num_products_(products.size()),
      has_closed_form_(model.coordinates.has_closed_form()),
      solver_(products, {model.coordinates.island_start(), model.coordinates.num_coordinates()}, options.ordering),
      blocks_(3 * model.coordinates.num_blocks()),
      right_side_(size()),
      rates_(size()),
      last_q_(size()),
      last_q_dot_(size()),
      last_q_ddot_(size()),
      q_(size(), 0.0) {
  for (std::vector<double>* array : {&r_, &v_, &psi_, &w_, &w0_, &points_, &error_rates_, &r_from_, &v_from_}) {
    array->resize(3 * model.num_points(), 0.0);
  }
  std::vector<double> no_rates(size());
  model_.coordinates.write_start(q_.data(), no_rates.data());
}

double TangentForm::predicted_flops() const {
  const GramSolver::Summary& summary = solver_.summary();
  constexpr double flops_a_product = 6.0, flops_a_point = 60.0;
  return summary.flops + 4.0 * summary.factor_nonzeros + flops_a_product * static_cast<double>(num_products_) +
         flops_a_point * static_cast<double>(model_.num_moving());
}

void TangentForm::describe(PlanSummary* plan) const {
  describe_factor(solver_.summary(), plan);
  plan->left_out.push_back("projections: r(q, t) stays on the constraints by itself");
  plan->left_out.push_back("multipliers in steps: computed where they are asked for");
  if (!model_.coordinates.depends_on_time()) plan->left_out.push_back("r_t terms: no coordinates depend on time");
  if (!model_.coordinates.has_charts()) plan->left_out.push_back("recentring: coordinates without charts");
}

// ---- one instant ----

void TangentForm::evaluate(double t, const double* q, const double* q_dot, bool with_blocks) const {
  is_complete_ = is_complete_ || with_blocks;
  model_.set_time(t);
  model_.prescribe_all(t, r_.data(), v_.data());
  std::copy(model_.support_accelerations.begin(), model_.support_accelerations.end(),
            psi_.begin() + static_cast<std::ptrdiff_t>(3 * model_.num_moving()));
  model_.coordinates.evaluate(model_.parallel, q, q_dot, r_.data(), v_.data(), psi_.data(),
                              with_blocks ? blocks_.data() : nullptr);
}

Outcome TangentForm::factorize(double t) {
  const GramSolver::Quality quality = model_.factorize(&solver_, blocks_.data());
  last_.reciprocal_condition = quality.reciprocal_condition;
  if (quality.positive_definite && quality.reciprocal_condition > GramSolver::singular_below) return {};
  return {Status::Singular, "H = A'MA is singular at t = " + text(t) + ": coordinate " +
                                model_.coordinates.name_coordinate(model_.system, quality.weakest_row) +
                                " moves no point, or others move the points the same way"};
}

/// Where every member moves a point of its own. False: where H looks singular, or A'M (w - w0) may not come out.
bool TangentForm::accelerate(double t, const double* q, const double* q_dot, double* q_ddot) {
  const Vec3* const uniform = model_.uniform_free();
  const Stopwatch watch(&model_.times.solve);
  if (uniform == nullptr) {
    evaluate(t, q, q_dot, false);
    (void)model_.evaluate_free(t, r_.data(), v_.data(), w0_.data());
  } else {
    model_.set_time(t);
    model_.prescribe_all(t, r_.data(), v_.data());
  }
  std::copy(model_.support_accelerations.begin(), model_.support_accelerations.end(),
            w_.begin() + static_cast<std::ptrdiff_t>(3 * model_.num_moving()));
  const double condition =
      model_.coordinates.accelerate(model_.parallel, q, q_dot, w0_.data(), uniform, q_ddot, w_.data());
  last_.reciprocal_condition = 1.0 / condition;
  last_.residual = std::numeric_limits<double>::epsilon() * condition;
  last_.refinements = 0;
  if (!(last_.residual <= good_enough)) return false;
  ++model_.counters.factorizations;
  ++model_.counters.solves;
  is_complete_ = false;
  return true;
}

/// r, v, psi, w0, A, the factor of H and q_ddot of the last accelerations.
void TangentForm::complete() const {
  if (is_complete_) return;
  const Stopwatch watch(&model_.times.evaluate);
  const double now = model_.time();
  evaluate(t_, last_q_.data(), last_q_dot_.data(), true);
  (void)model_.evaluate_free(t_, r_.data(), v_.data(), w0_.data());
  solver_.assemble(model_.parallel, blocks_.data());
  (void)solver_.factorize(model_.parallel);
  (void)model_.coordinates.accelerate(model_.parallel, last_q_.data(), last_q_dot_.data(), w0_.data(), nullptr,
                                      last_q_ddot_.data(), points_.data());
  if (now != t_) model_.set_time(now);
}

void TangentForm::remember(double t, const double* q, const double* q_dot) {
  t_ = t;
  std::copy(q, q + size(), last_q_.begin());
  std::copy(q_dot, q_dot + size(), last_q_dot_.begin());
}

Outcome TangentForm::accelerations(const Kinematics& at, const Request& request, double* q_ddot) {
  const auto [t, q, q_dot] = at;
  ++model_.counters.evaluations;
  const bool has_closed_form = !request.exact && friction_ == nullptr && has_closed_form_;
  if (has_closed_form && accelerate(t, q, q_dot, q_ddot)) {
    remember(t, q, q_dot);
    return last_.outcome = {};
  }
  double scale = 0.0;
  {
    const Stopwatch watch(&model_.times.evaluate);
    evaluate(t, q, q_dot, true);
    scale = larger(model_.evaluate_free(t, r_.data(), v_.data(), w0_.data()), model_.largest_norm(psi_.data()));
  }
  last_.residual = 0.0;
  last_.refinements = 0;
  if (!std::isfinite(scale)) return last_.outcome = model_.not_finite(t);
  if (Outcome outcome = add_friction(t, request); !outcome.ok()) return last_.outcome = outcome;
  if (Outcome outcome = factorize(t); !outcome.ok()) return last_.outcome = outcome;

  const Stopwatch watch(&model_.times.solve);
  // rho = A'(M w - f) from w = psi on; q_ddot -= H^-1 rho, w follows; again with what is left of it (refinement in w).
  // A well conditioned H needs no second look: its error stays below `good_enough`.
  constexpr double eps = std::numeric_limits<double>::epsilon();
  const double enough = request.exact ? 4.0 * eps : good_enough;
  const double expected = eps / last_.reciprocal_condition;
  constexpr int most_passes = 5;
  std::fill(q_ddot, q_ddot + size(), 0.0);
  std::copy(psi_.begin(), psi_.end(), w_.begin());
  double correction = scale;
  for (int pass = 0; pass < most_passes; ++pass) {
    const double before = correction;
    correction = correct(q_ddot);
    last_.refinements = pass;
    last_.residual = pass == 0 ? expected : relative_correction(correction, scale);
    if (last_.residual <= enough || (pass > 1 && !(correction < 0.5 * before))) break;
  }
  remember(t, q, q_dot);
  std::copy(q_ddot, q_ddot + size(), last_q_ddot_.begin());
  return last_.outcome = std::isfinite(correction) ? Outcome{} : model_.not_finite(t);
}

/// The last correction of w over the accelerations of its neighbourhood, the worst one; `correction`, `scale`: of all.
double TangentForm::relative_correction(double correction, double scale) const {
  if (!(scale > 0.0)) return 0.0;
  if (model_.scales.are_one()) return correction / scale;
  const std::vector<double> changes = model_.largest_norms(points_.data()), free = model_.largest_norms(w0_.data()),
                            psi = model_.largest_norms(psi_.data());
  double worst = 0.0;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const double own = std::max(free[k], psi[k]);
    if (changes[k] > 0.0) worst = larger(worst, own > 0.0 ? changes[k] / own : 1.0);
  }
  return worst;
}

// ---- friction, from the normal form ----

/// w0 += M^-1 tau
Outcome TangentForm::add_friction(double t, const Request& request) {
  if (friction_ == nullptr) return {};
  friction_w_.resize(w0_.size());
  tau_.resize(w0_.size());
  Request anew = request;
  anew.gradients = Gradients::Evaluate;
  if (anew.judgement == Judgement::Quick) anew.judgement = Judgement::None;
  Outcome outcome = friction_->accelerations({t, r_.data(), v_.data()}, anew, friction_w_.data());
  last_.friction = friction_->last_solve().friction;
  if (!outcome.ok()) return outcome;
  friction_->friction_forces(tau_.data());
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) w0_[i] += model_.inverse_mass[i / 3] * tau_[i];
  return outcome;
}

void TangentForm::evaluate_events(double t, const double*, const double*, double* values) {
  friction_events()->evaluate_events(t, r_.data(), v_.data(), values);
}

Outcome TangentForm::switch_equations(double t, const double* q, double* q_dot, std::span<const std::size_t> which,
                                      const Request& request, double* q_ddot) {
  evaluate(t, q, q_dot, false);
  std::vector<double> v = v_;
  friction_w_.resize(v.size());
  Outcome outcome = friction_events()->switch_equations(t, r_.data(), v.data(), which, request, friction_w_.data());
  if (outcome.ok()) outcome = find_rates(t, v.data(), q, q_dot);
  return outcome.ok() ? accelerations({t, q, q_dot}, request, q_ddot) : outcome;
}

Outcome TangentForm::begin(double t, const double* q, double* q_dot, const Request& request, double* q_ddot) {
  if (friction_ != nullptr) {
    evaluate(t, q, q_dot, false);
    std::vector<double> v = v_;
    friction_w_.resize(v.size());
    Outcome outcome = friction_->begin(t, r_.data(), v.data(), request, friction_w_.data());
    if (!outcome.ok()) return outcome;
  }
  return accelerations({t, q, q_dot}, request, q_ddot);
}

void TangentForm::write_place_along(double h, double* r) {
  complete();
  std::vector<double> q(size()), rates(3 * model_.num_points());
  for (std::size_t j = 0; j < size(); ++j) q[j] = last_q_[j] + h * last_q_dot_[j] + 0.5 * h * h * last_q_ddot_[j];
  model_.set_time(t_ + h);
  model_.prescribe_all(t_ + h, r, rates.data());
  model_.coordinates.evaluate(model_.parallel, q.data(), last_q_dot_.data(), r, nullptr, nullptr, nullptr);
}

/// q_ddot -= H^-1 A'(M w - f), w the same way; returns the largest change of w.
double TangentForm::correct(double* q_ddot) {
  const Parallel& parallel = model_.parallel;
  ++model_.counters.solves;
  parallel.for_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      store(points_.data(), i, model_.mass[i] * (load(w_.data(), i) - load(w0_.data(), i)));
    }
  });
  model_.coordinates.apply_transposed(parallel, blocks_.data(), points_.data(), right_side_.data());
  solver_.solve_negative(parallel, right_side_.data(), right_side_.data());
  for (std::size_t j = 0; j < size(); ++j) q_ddot[j] += right_side_[j];
  model_.coordinates.apply(parallel, blocks_.data(), right_side_.data(), points_.data());
  return parallel.max_over_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    double worst = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 change = load(points_.data(), i);
      store(w_.data(), i, load(w_.data(), i) + change);
      worst = larger(worst, dot(change, change));
    }
    return std::sqrt(worst);
  });
}

ErrorRatios TangentForm::error_ratios(double t, const StepErrors& errors, double atol, double rtol) {
  complete();
  // What the errors of q and q_dot do at the points, with A at the step's end: A dq, A dq_dot.
  const auto& coordinates = model_.coordinates;
  std::vector<double>&moved = points_, &rate = error_rates_, &r_from = r_from_, &v_from = v_from_;
  std::fill(moved.begin(), moved.end(), 0.0);
  coordinates.apply(model_.parallel, blocks_.data(), errors.x, moved.data());
  coordinates.apply(model_.parallel, blocks_.data(), errors.v, rate.data());
  const double t_end = model_.time();
  model_.set_time(t);
  model_.prescribe_all(t, r_from.data(), v_from.data());
  coordinates.evaluate(model_.parallel, errors.x_from, errors.v_from, r_from.data(), v_from.data(), nullptr, nullptr);
  model_.set_time(t_end);
  return model_.error_ratios({moved.data(), rate.data(), r_from.data(), v_from.data(), r_.data(), v_.data()}, atol,
                             rtol);
}

DriveReport TangentForm::look_at_drives(const DrivenStep& step) {
  users_q_.resize(size());
  model_.coordinates.scatter(step.x, users_q_.data());
  const double t_now = model_.time();
  model_.set_time(step.t);
  model_.prescribe_all(step.t, r_from_.data(), v_from_.data());
  model_.coordinates.evaluate(model_.parallel, step.x, step.v, r_from_.data(), v_from_.data(), nullptr, nullptr);
  model_.set_time(t_now);
  return model_.drives.look(step, {r_from_.data(), v_from_.data(), users_q_.data(), model_.scales});
}

Kinematics TangentForm::find_points(const Kinematics& at, double* r, double* v) {
  const double t_before = model_.time();
  model_.set_time(at.t);
  model_.prescribe_all(at.t, r, v);
  model_.coordinates.evaluate(model_.parallel, at.x, at.v, r, v, nullptr, nullptr);
  model_.set_time(t_before);
  return {at.t, r, v};
}

Power TangentForm::power(const double*, const double*) const {
  complete();
  // M^-1 eta = w - w0
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) points_[i] = w_[i] - w0_[i];
  Power result = model_.power(points_.data(), r_.data(), v_.data());
  if (friction_ == nullptr) return result;
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) result.friction += tau_[i] * v_[i];
  return result;
}

Energy TangentForm::energy(double t, const double* q, const double* q_dot) {
  evaluate(t, q, q_dot, false);
  return model_.energy(r_.data(), v_.data());
}

// ---- points and coordinates ----

/// H q_dot = A'M (v - r_t): the nearest rates in the M-norm. r_ are the places.
Outcome TangentForm::find_rates(double t, const double* v, const double* q, double* q_dot) {
  std::fill(q_dot, q_dot + size(), 0.0);
  evaluate(t, q, q_dot, true);
  if (Outcome outcome = factorize(t); !outcome.ok()) return outcome;
  // v_ = r_t; A q_dot of what has been found is added, and the rest found again
  const auto missing = [&](std::size_t i) {
    store(points_.data(), i, model_.mass[i] * (load(v_.data(), i) + load(error_rates_.data(), i) - load(v, i)));
  };
  std::fill(error_rates_.begin(), error_rates_.end(), 0.0);
  for (int pass = 0; pass < 2; ++pass) {
    if (pass > 0) model_.coordinates.apply(model_.parallel, blocks_.data(), q_dot, error_rates_.data());
    model_.parallel.for_ranges(model_.num_moving(), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) missing(i);
    });
    model_.coordinates.apply_transposed(model_.parallel, blocks_.data(), points_.data(), right_side_.data());
    solver_.solve_negative(model_.parallel, right_side_.data(), right_side_.data());
    for (std::size_t j = 0; j < size(); ++j) q_dot[j] += right_side_[j];
  }
  return {};
}

/// q_ of the places r. Charts move: the accelerations before belong to the old ones.
void TangentForm::locate(const double* r) {
  complete();
  model_.coordinates.locate(r, q_.data());
}

Outcome TangentForm::adopt(double t, const double* r, const double* v, double* q, double* q_dot) {
  model_.set_time(t);
  locate(r);
  std::copy(q_.begin(), q_.end(), q);
  if (Outcome outcome = find_rates(t, v, q, q_dot); !outcome.ok()) return outcome;
  constexpr double allowed = 1e-3;  // as at the start
  const double distance = model_.largest_move(r_.data(), r);
  if (distance <= allowed * model_.scene_size) return {};
  return {Status::NotConverged, "the positions at t = " + text(t) +
                                    " are not those of the coordinates: the nearest that were found lie " +
                                    text(distance) + " m away"};
}

ProjectionReport TangentForm::project_positions(double t, double* q, Turn) {
  if (model_.num_rows() == 0) return {};
  evaluate(t, q, rates_.data(), false);
  ProjectionReport report;
  report.violation = model_.position_violation(t, r_.data());
  constexpr double rounding = 1e-9;
  const double far = std::max(1.0, model_.largest_norm(r_.data()) / model_.smallest_length);
  if (!(report.violation <= rounding * far)) {
    report.outcome = {Status::Contradictory, "coordinates and constraints part at t = " + text(t) + ", violation " +
                                                 text(report.violation) + "; both must describe the same motion"};
  }
  return report;
}

ProjectionReport TangentForm::put_positions(double t, double* r) {
  model_.set_time(t);
  locate(r);
  evaluate(t, q_.data(), rates_.data(), false);
  std::copy(r_.begin(), r_.end(), r);
  return {.outcome = {}, .correction = 0.0, .violation = model_.position_violation(t, r), .iterations = 1};
}

ProjectionReport TangentForm::put_velocities(double t, const double* r, double* v) {
  model_.set_time(t);
  locate(r);
  ProjectionReport report;
  report.outcome = find_rates(t, v, q_.data(), rates_.data());
  if (!report.outcome.ok()) return report;
  evaluate(t, q_.data(), rates_.data(), false);
  std::copy(v_.begin(), v_.end(), v);
  report.violation = model_.velocity_violation(t, r, v);
  report.iterations = 1;
  return report;
}

void TangentForm::write_points(double t, const double* q, const double* q_dot, const double*, double* r, double* v,
                               double* w) {
  evaluate(t, q, q_dot, false);
  std::copy(r_.begin(), r_.end(), r);
  std::copy(v_.begin(), v_.end(), v);
  std::copy(w_.begin(), w_.end(), w);
}

void TangentForm::recentre(double t, double* q, double* q_dot, double* q_ddot) {
  if (model_.coordinates.has_charts()) complete();  // in the charts that q belongs to
  if (friction_ != nullptr) friction_->recentre(t, r_.data(), v_.data(), friction_w_.data());
  model_.set_time(t);
  model_.coordinates.recentre(t, q, q_dot, q_ddot);
}

/// Charts, w and w0 as they were found in those before, and what friction keeps.
void TangentForm::exchange_memory(Memory& memory) {
  if (memory.reads()) complete();  // in the charts that the last accelerations belong to
  model_.exchange_memory(memory);
  model_.coordinates.exchange_memory(memory);
  memory.exchange(w_, w0_);
  if (friction_ != nullptr) friction_->exchange_memory(memory);
}

void TangentForm::resume(const Counters& counters, const PhaseTimes& times) {
  model_.counters = counters;
  model_.times = times;
}

void TangentForm::respond(const double* force, double* eta) {
  complete();
  const std::size_t moving = 3 * model_.num_moving();
  std::fill(eta, eta + 3 * model_.num_points(), 0.0);
  std::copy(force, force + moving, eta);
  // eta -= M A H^-1 A'eta, until A'eta = 0 to rounding
  constexpr int passes = 3;
  for (int pass = 0; pass < passes; ++pass) {
    ++model_.counters.solves;
    model_.coordinates.apply_transposed(model_.parallel, blocks_.data(), eta, right_side_.data());
    solver_.solve_negative(model_.parallel, right_side_.data(), right_side_.data());
    model_.coordinates.apply(model_.parallel, blocks_.data(), right_side_.data(), points_.data());
    for (std::size_t i = 0; i < moving; ++i) eta[i] += model_.mass[i / 3] * points_[i];
  }
  model_.coordinates.add_support_reactions(eta);
}

void TangentForm::reactions(double* eta) const {
  complete();
  // eta = M w - f (24); what the coordinates hold at their supports is the opposite of what they do to their points.
  std::fill(eta, eta + 3 * model_.num_points(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    store(eta, i, model_.mass[i] * (load(w_.data(), i) - load(w0_.data(), i)));
  }
  model_.coordinates.add_support_reactions(eta);
}

}  // namespace tanor
