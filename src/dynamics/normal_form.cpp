#include "dynamics/normal_form.hpp"

#include <algorithm>
#include <limits>

#include "base/stopwatch.hpp"
#include "base/text.hpp"

namespace tanor {

namespace {

// Far above `GramSolver::singular_below`: the estimate of the condition is from above.
constexpr double first_suspicion = 1e-11;

}  // namespace

NormalForm::NormalForm(Model& model, const SolverOptions& options)
    : model_(model),
      ordering_(options.ordering),
      schur_(make_schur_solver({model.constraints, model.gather, model.incidences, model.numbering, model.inverse_mass},
                               options)),
      redundancy_(model.incidences, model.inverse_mass, model.numbering),
      suspect_below_(first_suspicion),
      blocks_(3 * model.constraints.num_blocks()),
      dw_(size(), 0.0),
      right_side_(num_rows()),
      lambda_(num_rows(), 0.0),
      rows_(num_rows()),
      step_multipliers_{std::vector<double>(num_rows()), std::vector<double>(num_rows()),
                        std::vector<double>(num_rows())} {
  if (schur_ == nullptr) (void)general();
  if (options.reuse) make_reuse();
  PlanSummary plan;
  describe_solver(&plan);
  linearises_cheaply_ = plan.factor_flops <= 2.0 * 4.0 * static_cast<double>(plan.factor_nonzeros);
  if (!model.scales.are_one()) norms_.reserve(num_rows());
  if (!model.has_friction()) return;
  auto& self = static_cast<ConstrainedSystem&>(*this);
  friction_ = std::make_unique<FrictionSolver>(model, options.friction, self);
  contacts_ = std::make_unique<ContactModes>(model, *friction_, self);
  respond_.resize(size());
  solver_->allow_zero_rows(model.numbering.user_row, model.numbering.num_user_rows);
}

/// Made when first needed: where a SchurSolver serves all islands it may never be.
GramSolver& NormalForm::general() {
  if (solver_ == nullptr) {
    solver_ = std::make_unique<GramSolver>(model_.incidences, model_.inverse_mass, model_.numbering, ordering_,
                                           model_.constraints.squared_gradient_norms());
  }
  return *solver_;
}

double NormalForm::predicted_flops() const {
  constexpr double flops_an_entry = 6.0, flops_a_row = 60.0;
  PlanSummary plan;
  describe_solver(&plan);
  return plan.factor_flops + 4.0 * static_cast<double>(plan.factor_nonzeros) +
         flops_an_entry * static_cast<double>(plan.pattern_nonzeros) + flops_a_row * static_cast<double>(num_rows());
}

void NormalForm::describe_solver(PlanSummary* plan) const {
  if (schur_ == nullptr) return describe_factor(solver_->summary(), plan);
  const SchurSolver::Summary& summary = schur_->summary();
  plan->way = plan->factorization = summary.name;
  plan->way_reason = summary.reason;
  plan->ordering = summary.ordering;
  plan->parts = summary.parts;
  plan->pattern_nonzeros = summary.pattern_nonzeros;
  plan->factor_nonzeros = summary.factor_nonzeros;
  plan->factor_flops = summary.flops;
}

void NormalForm::describe(PlanSummary* plan) const {
  describe_solver(plan);
  auto& left_out = plan->left_out;
  if (num_rows() == 0)
    left_out.push_back("factorization: no constraints");
  else if (model_.constraints.gradients_are_constant())
    left_out.push_back("refactorization: K is constant");
  if (plan->factorization == "closed form") left_out.push_back("sparse factorization: closed form, row by row");
  if (model_.constraints.gradient_norms_are_constant()) left_out.push_back("rescaling of S: its diagonal is constant");
  if (!model_.constraints.depends_on_time()) left_out.push_back("xi_t terms: no constraint depends on time");
}

// ---- one instant ----

Outcome NormalForm::free_accelerations(const Kinematics& at, const Request& request, double* w) {
  if (friction_ != nullptr) {
    // M^-1 (f + tau) = w - M^-1 eta: what holds a contact that sticks is a force like the others
    if (Outcome outcome = accelerations(at, request, w); !outcome.ok()) return outcome;
    reactions(respond_.data());
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) w[i] -= model_.inverse_mass[i / 3] * respond_[i];
    return {};
  }
  const Stopwatch watch(&model_.times.evaluate);
  if (has_schur() && model_.uniform_free() != nullptr) {
    model_.write_uniform(w);
    return {};
  }
  return std::isfinite(model_.evaluate_free(at.t, at.x, at.v, w)) ? Outcome{} : model_.not_finite(at.t);
}

GramSolver::Quality NormalForm::factorize_gram() {
  is_of_schur_ = has_old_factor_ = false;
  note_frames();
  const GramSolver::Quality quality = model_.factorize(&general(), blocks_.data());
  last_.reciprocal_condition = quality.reciprocal_condition;
  return quality;
}

Outcome NormalForm::factorize(double t, const double* r, bool may_use_schur) {
  if (may_use_schur && has_schur() && factorize_schur()) return {};
  if (redundancy_.uses_qr()) {
    redundancy_.release_qr();
    general().set_active(redundancy_.rows_for_gram());
  }
  GramSolver::Quality quality = factorize_gram();
  const auto is_fine = [&] { return quality.positive_definite && quality.reciprocal_condition > suspect_below_; };
  // Where a load is known to be shared S is singular, and a larger number is rounding, too.
  constexpr double hidden_by_rounding = 1e-8;
  const bool is_hidden = quality.reciprocal_condition < hidden_by_rounding && contacts_ != nullptr &&
                         contacts_->sharing().has_references();
  if ((!is_fine() || is_hidden) && make_compliant()) quality = factorize_gram();
  is_factorized_ = is_fine();
  if (!is_factorized_) {
    if (Outcome outcome = decide_rank(t, r); !outcome.ok()) return outcome;
  }
  // Rows of contacts came or went: what depended on them may not any more.
  if (model_.constraints.tangents().forget_switches()) (void)decide_rank_again(r);
  return {};
}

Outcome NormalForm::linearise(double t, const double* r) {
  model_.set_time(t);
  if (num_rows() == 0 || (is_factorized_ && model_.constraints.gradients_are_constant())) return {};
  model_.constraints.choose_frames();
  const bool by_schur = has_schur();
  if (by_schur && linearise_schur(r)) return {};
  {
    const Stopwatch watch(&model_.times.evaluate);
    model_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  }
  if (Outcome outcome = model_.check_contacts(t); !outcome.ok()) return outcome;
  return factorize(t, r, !by_schur);
}

void NormalForm::solve_negative(const double* b, double* x) {
  if (is_of_schur_) return schur_->solve_negative(model_.parallel, b, x);
  if (has_old_factor_) (void)factorize_gram();
  if (!redundancy_.uses_qr()) return general().solve_negative(model_.parallel, b, x);
  right_side_of_qr_.assign(b, b + num_rows());
  general().solve_negative(model_.parallel, b, x);
  redundancy_.solve_negative(right_side_of_qr_.data(), x);
}

/// With a factor that is compliant S is solved by its refinement alone.
void NormalForm::solve_negative(double* rows) {
  if (!is_compliant()) return solve_negative(rows, rows);
  const std::vector<double> b(rows, rows + num_rows());
  respond(b.data(), rows, respond_.data());
}

/// rows := -S^-1 rows, points += M^-1 K rows.
void NormalForm::correct(double* rows, double* points) {
  const Stopwatch watch(&model_.times.solve);
  ++model_.counters.solves;
  if (is_of_schur_) return schur_->correct(model_.parallel, blocks_.data(), rows, points);
  if (has_old_factor_ && correct_by_reuse(rows, points)) return;
  solve_negative(rows, rows);
  model_.gather.add_scaled(model_.parallel, blocks_.data(), rows, model_.inverse_mass.data(), model_.num_moving(),
                           points);
}

void NormalForm::take(const Request& request) {
  request_ = request;
  allowed_error_ = reuse_ != nullptr && !request.exact ? request.allowed_error : 0.0;
}

Outcome NormalForm::accelerations(const Kinematics& at, const Request& request, double* w) {
  return accelerations(at, request, {}, w);
}

Outcome NormalForm::accelerations(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                                  double* w) {
  take(request);
  const auto [t, r, v] = at;
  const Gradients gradients = request.gradients;
  model_.set_time(t);
  ++model_.counters.evaluations;
  if (gradients == Gradients::Evaluate) model_.constraints.choose_frames();
  const bool may_use_schur = gradients == Gradients::Evaluate && has_schur();
  if (may_use_schur || (gradients == Gradients::Keep && is_of_schur_)) {
    if (std::optional<Outcome> outcome = solve_schur(t, r, v, gradients, w)) return last_.outcome = *std::move(outcome);
  }
  const bool fresh =
      gradients == Gradients::Evaluate && !(is_factorized_ && model_.constraints.gradients_are_constant());
  double scale = 0.0;
  {
    const Stopwatch watch(&model_.times.evaluate);
    scale = model_.evaluate_free(t, r, v, w);
    // b = phi + K'w0
    const double largest_b = model_.constraints.evaluate_right_side(model_.parallel, r, v, w, right_side_.data(),
                                                                    fresh ? blocks_.data() : nullptr);
    scale = larger(scale, largest_b);
  }
  last_.residual = 0.0;
  last_.refinements = 0;
  w0_ = w;
  knows_accelerations_ = false;
  if (friction_ != nullptr) measure_accelerations(scale);
  if (!std::isfinite(scale)) return last_.outcome = model_.not_finite(t);
  if (num_rows() == 0) return last_.outcome = {};
  if (fresh && may_reuse() && reuse(t)) {
    add_reactions(w);
    return last_.outcome = check_idle_rows(t, scale);
  }
  if (fresh) {
    // What `schur_` has refused is for the sparse factor of all.
    if (Outcome outcome = factorize(t, r, !may_use_schur); !outcome.ok()) return last_.outcome = outcome;
  }
  if (Outcome outcome = check_idle_rows(t, scale); !outcome.ok()) return last_.outcome = outcome;

  const UniquenessCheck check{request.judgement != Judgement::None, request.refuses_several, are_counted};
  if (Outcome outcome = find_friction(t, r, v, check, w); !outcome.ok()) return last_.outcome = outcome;
  double residual = find_multipliers_and_friction(scale, w);
  if (friction_ != nullptr && check.is_wanted) {
    contacts_->add_verdict(&last_.friction);
    // One motion obeys the law, but modes that were chosen wrongly leave friction that no iteration brings to it.
    constexpr double largest_miss = 1e-4;
    if (last_.friction.uniqueness == Uniqueness::Proven && last_.friction.residual > largest_miss) {
      return last_.outcome = {Status::NotConverged, "friction at t = " + text(t) +
                                                        ": what was found misses the law by " +
                                                        text(last_.friction.residual) + " of the largest friction"};
    }
  }
  if (residual > doubtful_above) {
    if (Outcome outcome = reconsider_rank(t, r, scale); !outcome.ok()) return last_.outcome = outcome;
    residual = last_.residual;
  }
  if (!std::isfinite(residual)) return last_.outcome = model_.not_finite(t);

  add_reactions(w);
  if (allowed_error_ > 0.0) reuse_->add(t, lambda_);
  return last_.outcome = {};
}

/// w = w0 + M^-1 K lambda (25)
void NormalForm::add_reactions(double* w) const {
  model_.parallel.for_ranges(3 * model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) w[i] += dw_[i];
  });
}

/// tau at lambda, from the last one on; then it is a part of w0 and b = phi + K'w0.
Outcome NormalForm::find_friction(double t, const double* r, const double* v, const UniquenessCheck& check, double* w) {
  if (friction_ == nullptr) return {};
  contacts_->prepare(r, v);
  // The null space turns with K.
  if (!model_.constraints.gradients_are_constant()) (void)decide_rank_again(r);
  friction_->set_accelerations(accelerations_);
  Outcome outcome = friction_->find({t, r, v, blocks_.data()}, right_side_.data(), check, lambda_.data());
  last_.friction = friction_->report();
  if (outcome.ok()) friction_->add(1.0, w, right_side_.data());
  return outcome;
}

double NormalForm::find_multipliers_and_friction(double scale, double* w) {
  double residual = find_multipliers(scale);
  if (friction_ == nullptr) return residual;
  constexpr double good_enough = 1e-12;
  if (friction_->measure(lambda_.data()) > good_enough) {
    {
      const Stopwatch watch(&model_.times.friction);
      friction_->add(-1.0, w, right_side_.data());
      friction_->refine(right_side_.data(), lambda_.data());
      friction_->add(1.0, w, right_side_.data());
    }
    residual = find_multipliers(scale);
    friction_->measure(lambda_.data());
  }
  last_.friction = friction_->report();
  last_.friction.sticking_is_indeterminate = is_compliant();
  return residual;
}

/// S lambda = -b, dw = M^-1 K lambda; then refinement in w (theory, section 8):
/// rho = K'dw + b = K'w + phi, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho. Returns |rho|/scale over all rows.
double NormalForm::find_multipliers(double scale) {
  {
    const Stopwatch watch(&model_.times.solve);
    ++model_.counters.solves;
    solve_negative(right_side_.data(), lambda_.data());
    model_.gather.write_scaled(model_.parallel, blocks_.data(), lambda_.data(), model_.inverse_mass.data(),
                               model_.num_moving(), dw_.data());
  }
  refine(scale);
  share_out(lambda_.data());
  return last_.residual;
}

double NormalForm::refine(double scale) {
  constexpr int patience = 5;
  const int most_passes = is_compliant() ? 50 : 5;
  double residual = 0.0, least = std::numeric_limits<double>::infinity();
  int since_least = 0;
  last_.refinements = 0;
  for (int pass = 0;; ++pass) {
    const double before = residual;
    const double largest = model_.constraints.apply_transposed(model_.parallel, blocks_.data(), dw_.data(),
                                                               right_side_.data(), rows_.data());
    last_.residual = residual = relative_residual(largest, scale);
    // What dependent rows leave over is not for the others to mend.
    if (redundancy_.is_found()) {
      measure_accelerations(scale);
      residual = largest_active(rows_, accelerations_);
    }
    // Exact beside all, good enough beside its own neighbourhood.
    constexpr double little = 1e-12;
    const bool is_little = largest <= good_enough() * scale && residual <= little;
    since_least = residual < 0.5 * least ? 0 : since_least + 1;
    least = std::min(least, residual);
    const bool stands = is_compliant() ? since_least == patience : pass > 0 && !(residual < 0.5 * before);
    if (is_little || residual <= good_enough() || pass == most_passes || stands) break;
    ++last_.refinements;
    correct_conjugately(pass == 0, rows_.data(), dw_.data());
    for (std::size_t a = 0; a < rows_.size(); ++a) lambda_[a] += rows_[a];
  }
  return last_.residual;
}

/// Laws of friction read multipliers: where several serve, the smallest ones.
void NormalForm::share_out(double* lambda) const {
  if (friction_ != nullptr && redundancy_.is_found()) redundancy_.minimize_norm(lambda);
}

/// Rows that join supports alone take no part in S: what is prescribed must satisfy them by itself.
Outcome NormalForm::check_idle_rows(double t, double scale) const {
  constexpr double allowed = 1e-8;
  for (std::size_t a = model_.numbering.first_idle_row(); a < num_rows(); ++a) {
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
  if (row >= model_.numbering.first_idle_row()) {
    return {Status::Contradictory, "what is prescribed at supports breaks " + place};
  }
  // The independent rows are satisfied, what depends on them is not.
  const std::vector<double>& lengths = model_.scales.lengths();
  if (largest_active(rows_, lengths) < 1e-3 * largest_dependent(rows_, lengths)) {
    const std::vector<double> nothing(model_.scales.size(), 0.0);
    if (Outcome outcome = explain_contradiction(t, rows_, nothing, 1e-9, " m"); !outcome.ok()) return outcome;
  }
  constexpr double poor = 1e-6;
  const double condition = last_.reciprocal_condition;
  const std::string why = condition < poor ? "; S has the reciprocal condition " + text(condition) + " there" : "";
  return {Status::NotConverged, "projection onto the constraints stalls; the worst is " + place + why};
}

/// A gradient that does not exist, or vanishes: no combination of others, but a constraint that has no direction here.
Outcome NormalForm::check_gradients(double t) const {
  std::vector<double> largest(num_rows(), 0.0);  // over the moving points of a row
  for (const Incidence& incidence : model_.incidences) {
    const double length = norm(load(blocks_.data(), incidence.block));
    const auto row = static_cast<std::size_t>(incidence.row);
    if (!std::isfinite(length)) {
      return {Status::Singular, "the gradient of " + name_row(row) + " does not exist at t = " + text(t) +
                                    ": a point lies where it is measured from"};
    }
    if (model_.inverse_mass[static_cast<std::size_t>(incidence.point)] > 0.0)
      largest[row] = std::max(largest[row], length);
  }
  for (std::size_t a = 0; a < model_.numbering.first_idle_row(); ++a) {
    // a contact that slides has none, and needs none
    if (static_cast<std::size_t>(model_.numbering.user_row[a]) >= model_.numbering.num_user_rows) continue;
    if (largest[a] * model_.scales.length(model_.scales.of_row(a)) < 1e-12)
      return {Status::Singular, "the gradient of " + name_row(a) + " vanishes at t = " + text(t)};
  }
  return {};
}

// ---- outputs ----

void NormalForm::respond(const double* b, double* lambda, double* dw) {
  std::fill(lambda, lambda + num_rows(), 0.0);
  std::fill(dw, dw + size(), 0.0);
  std::copy(b, b + num_rows(), rows_.begin());
  // rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho
  const int passes = is_compliant() ? 5 : 3;
  for (int pass = 0; pass < passes && num_rows() > 0; ++pass) {
    correct_conjugately(pass == 0, rows_.data(), dw);
    for (std::size_t a = 0; a < num_rows(); ++a) lambda[a] += rows_[a];
    model_.constraints.apply_transposed(model_.parallel, blocks_.data(), dw, b, rows_.data());
  }
}

void NormalForm::reactions(double* eta) const {
  if (!has_switches()) return model_.gather.reactions(model_.parallel, blocks_.data(), lambda_.data(), eta);
  // What holds a contact that sticks is friction.
  of_constraints_ = lambda_;
  for (std::size_t a = 0; a < num_rows(); ++a) {
    if (static_cast<std::size_t>(model_.numbering.user_row[a]) >= model_.numbering.num_user_rows)
      of_constraints_[a] = 0.0;
  }
  model_.gather.reactions(model_.parallel, blocks_.data(), of_constraints_.data(), eta);
}

void NormalForm::friction_forces(double* tau) const {
  if (friction_ != nullptr)
    friction_->write_all(lambda_.data(), tau);
  else
    std::fill_n(tau, size(), 0.0);
}

const std::vector<double>& NormalForm::measure_accelerations(const double* w0, const double* b, double scale) {
  w0_ = w0;
  std::copy(b, b + num_rows(), right_side_.begin());
  knows_accelerations_ = false;
  measure_accelerations(scale);
  return accelerations_;
}

Outcome NormalForm::begin(double t, const double* r, double* v, const Request& request, double* w) {
  if (friction_ != nullptr && friction_->laws().depend_on_reactions()) return contacts_->begin(t, r, v, request, w);
  Request anew = request;
  anew.gradients = Gradients::Evaluate;
  if (anew.judgement == Judgement::Quick) anew.judgement = Judgement::None;
  return accelerations({t, r, v}, anew, w);
}

/// A compliant factor alone is no answer.
void NormalForm::solve_once(const double* b, double* x) {
  if (is_compliant()) return respond(b, x, respond_.data());
  ++model_.counters.solves;
  solve_negative(b, x);
}

Power NormalForm::power(const double* r, const double* v) const {
  Power result = model_.power(dw_.data(), r, v);
  if (friction_ == nullptr) return result;
  result.friction = friction_->power(lambda_.data(), v);
  // Of what M^-1 K lambda does, that part belongs to contacts that stick.
  if (model_.is_rheonomic()) result.supports -= friction_->held_power(lambda_.data(), v);
  return result;
}

/// What starts an iteration, or was decided where the motion has been.
void NormalForm::exchange_memory(Memory& memory) {
  model_.exchange_memory(memory);
  memory.exchange(lambda_, step_multipliers_.last, step_multipliers_.before, step_multipliers_.last_h,
                  step_multipliers_.before_h, suspect_below_);
  bool have_same_frames = step_multipliers_.frames == model_.constraints.frames();
  memory.exchange(have_same_frames);
  if (memory.reads()) step_multipliers_.frames = model_.constraints.frames() + (have_same_frames ? 0 : 1);
  if (reuse_ != nullptr) reuse_->exchange_memory(memory);
  if (contacts_ != nullptr) contacts_->exchange_memory(memory);
}

ErrorRatios NormalForm::error_ratios(double, const StepErrors& errors, double atol, double rtol) {
  if (model_.joints.allows_rounding() && !errors.are_of_projections) {
    // e - M^-1 K S^-1 K'e: what constraints take is rounding most of all.
    const auto take = [&](const double* error, std::vector<double>* left) {
      left->assign(error, error + size());
      if (num_rows() == 0) return left->data();
      model_.constraints.apply_transposed(model_.parallel, blocks_.data(), left->data(), nullptr, rows_.data());
      correct(rows_.data(), left->data());
      return left->data();
    };
    StepErrors left = errors;
    left.x = take(errors.x, &error_x_);
    left.v = take(errors.v, &error_v_);
    return model_.error_ratios(left, atol, rtol);
  }
  return model_.error_ratios(errors, atol, rtol);
}

ProjectionReport NormalForm::put_positions(double t, double* r) {
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome)};
  return project_positions(t, r);
}

ProjectionReport NormalForm::put_velocities(double t, const double* r, double* v) {
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return {std::move(outcome)};
  return project_velocities(t, r, v);
}

Outcome NormalForm::adopt(double, const double* r, const double* v, double* x, double* x_dot) {
  std::copy(r, r + size(), x);
  std::copy(v, v + size(), x_dot);
  return {};
}

void NormalForm::write_points(double, const double* x, const double* x_dot, const double* x_ddot, double* r, double* v,
                              double* w) {
  std::copy(x, x + size(), r);
  std::copy(x_dot, x_dot + size(), v);
  std::copy(x_ddot, x_ddot + size(), w);
}

}  // namespace tanor
