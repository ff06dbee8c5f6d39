#include "dynamics/linearization.hpp"

#include <algorithm>
#include <cmath>

#include "base/power_iteration.hpp"
#include "base/stopwatch.hpp"
#include "schur/rod_rows.hpp"

namespace tanor::detail {

namespace {

SchurProblem problem_of(const Workspace& work) {
  const Model& model = work.model();
  return {work.constraints, model.gather,       model.incidences,
          model.numbering,  model.inverse_mass, model.system.positions};
}

/// Writes w0 = M^-1 f into w. Returns the largest number.
double evaluate_free(Workspace& work, const Kinematics& at, const Request& request, double* w) {
  if (request.given == nullptr) return work.evaluate_free(at.t, at.x, at.v, w);
  work.write_support_accelerations(at.t, w);
  bring(work.model().parallel, request.given, 0, work.model().num_points());
  return request.given->largest();
}

/// Writes as little of w0 as a solve in one pass reads. Returns the largest number, as far as it is known.
double evaluate_free_lightly(Workspace& work, const Kinematics& at, const Request& request, FreeMotion* motion,
                             double* w) {
  const Stopwatch watch(&work.times.evaluate);
  if (request.given != nullptr) {
    work.write_support_accelerations(at.t, w);
    return 0.0;
  }
  motion->uniform = work.model().uniform_free();
  return motion->uniform != nullptr ? work.write_unconstrained(at.t, w) : work.evaluate_free(at.t, at.x, at.v, w);
}

/// Returns true if a solution needs no refinement. A residual that is small beside each island, or beside the slowest
/// neighbourhood, is small beside each neighbourhood.
bool is_fine(const Elimination& passed, double relative_residual, double enough, const Scales& scales) {
  constexpr double little = 1e-12;
  const bool is_little =
      scales.are_one() || passed.own_residual <= little || passed.residual <= little * scales.least_acceleration();
  return relative_residual <= enough && is_little;
}

/// Returns true if the composite may make the next factor.
bool may_serve(const CompositeSolver& composite, const Dependences& dependences) {
  return !composite.is_empty() && !dependences.is_found();
}

/// Computes dw = M^-1 K lambda.
void write_reactions(const Model& model, const std::vector<double>& blocks, const double* lambda, double* dw) {
  model.gather.write_scaled(model.parallel, blocks.data(), lambda, model.inverse_mass.data(), model.num_moving(), dw);
}

void add_rows(const Model& model, const double* rows, double* sum) {
  if (sum == nullptr) return;
  model.parallel.for_ranges(model.num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) sum[a] += rows[a];
  });
}

}  // namespace

Linearization::Linearization(Workspace& work, const SolverOptions& options, Contacts* contacts)
    : work_(work),
      model_(work.model()),
      contacts_(contacts),
      blocks_(3 * work.constraints.num_blocks()),
      composite_(work.team().is_alone() ? make_composite_solver(problem_of(work), options) : CompositeSolver()),
      all_rows_(work.team().make_factor(work, options, blocks_, contacts)),
      summary_(composite_.is_empty() ? all_rows_->summarize() : composite_.summary()),
      conjugate_(work, *all_rows_, blocks_),
      has_constant_gradients_(work.team().all(work.constraints.gradients_are_constant())),
      rows_(model_.num_rows()) {
  if (composite_.is_empty() && work.team().is_alone() && options.reuse && all_rows_->solver() == LinearSolver::General)
    reuse_ = FactorReuse::make(work, all_rows_->gram().summary());
}

// ---- the configuration ----

Outcome Linearization::update(double t, const double* r, const PointSource* source) {
  work_.set_time(t);
  if (!work_.has_rows() || !is_needed()) {
    bring(model_.parallel, source, 0, model_.num_points());
    return {};
  }
  work_.constraints.choose_frames();
  bring(model_.parallel, source, model_.num_constrained(), model_.num_points());
  if (may_serve(composite_, dependences())) {
    const Stopwatch watch(&work_.times.factor);
    ++work_.counters.factorizations;
    const Elimination made = composite_.linearise(model_.parallel, r, source, blocks_.data());
    if (note_composite(made.reciprocal_condition)) return {};
  } else {
    bring(model_.parallel, source, 0, model_.num_constrained());
  }
  {
    const Stopwatch watch(&work_.times.evaluate);
    work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  }
  if (Outcome outcome = work_.check_contacts(t); !outcome.ok()) return outcome;
  return factorize(t, r);
}

void Linearization::set_offsets(std::span<const Constraints::RowOffset> offsets) {
  work_.constraints.set_offsets(offsets);
  if (composite_.is_empty()) return;
  if (offsets_.empty()) offsets_ = RodRows(work_.constraints, model_.num_rows()).offset;
  for (const auto& [row, offset] : offsets) offsets_[row] = offset;
  composite_.read_offsets(offsets_);
}

/// Factorizes S of the present K, evaluated at (t, r), for all rows together.
Outcome Linearization::factorize(double t, const double* r) {
  Outcome outcome = all_rows_->factorize(t, r);
  note_all_rows();
  if (!outcome.ok()) state_ = State::None;
  return outcome;
}

/// Accepts a factor of the composite, unless it looks singular; then the factor of all rows decides.
bool Linearization::note_composite(double reciprocal_condition) {
  reciprocal_condition_ = reciprocal_condition;
  const bool is_regular = reciprocal_condition > all_rows_->suspect_below();
  present_ = is_regular ? static_cast<SchurFactor*>(&composite_) : all_rows_.get();
  state_ = is_regular ? State::Fresh : State::None;
  return is_regular;
}

/// Notes that the factor of all rows was made anew.
void Linearization::note_all_rows() {
  present_ = all_rows_.get();
  state_ = State::Fresh;
  reciprocal_condition_ = all_rows_->reciprocal_condition();
  if (reuse_ != nullptr) reuse_->note_factor();
}

SchurFactor& Linearization::factor() {
  if (state_ == State::Stale) {
    all_rows_->factorize_again();
    note_all_rows();
  }
  return *present_;
}

/// Estimates 1/cond(D S D), D = diag(S)^-1/2. The factors of the composite and of QR hold no matrix: there the largest
/// eigenvalues of D S D and of its inverse are found by power iterations.
double Linearization::estimate_reciprocal_condition() {
  if (present_ == all_rows_.get() && !dependences().uses_qr()) return gram().estimate_reciprocal_condition();
  constexpr int iterations = 4;
  std::vector<double> scale(work_.constraints.num_rows(), 0.0), x(scale.size()), dw(3 * model_.num_points(), 0.0);
  for (const auto& [point, row, block, sign] : model_.incidences) {
    const Vec3 g = load(blocks_.data(), block);
    scale[static_cast<std::size_t>(row)] += model_.inverse_mass[static_cast<std::size_t>(point)] * dot(g, g);
  }
  for (double& each : scale) each = each > 0.0 ? std::sqrt(each) : 1.0;  // 1 for rows that move nothing
  const double largest = estimate_norm(&x, iterations, [&] {
    for (std::size_t a = 0; a < x.size(); ++a) x[a] /= scale[a];
    write_reactions(model_, blocks_, x.data(), dw.data());
    work_.constraints.apply_transposed(model_.parallel, blocks_.data(), dw.data(), nullptr, x.data());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] /= scale[a];
  });
  const double largest_of_inverse = estimate_norm(&x, iterations, [&] {
    for (std::size_t a = 0; a < x.size(); ++a) x[a] *= scale[a];
    present_->solve_negative(model_.parallel, x.data(), x.data());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] *= scale[a];
  });
  const double condition = largest * largest_of_inverse;
  return condition > 0.0 ? 1.0 / condition : 1.0;  // rows that move nothing have none
}

// ---- solutions ----

/// Solves all by the composite in one pass over the memory. Returns nothing where it does not serve and where S looks
/// singular.
std::optional<Outcome> Linearization::solve_in_one_pass(const Kinematics& at, const Request& request, double* w,
                                                        MultiplierSolution* found) {
  const bool keeps = request.gradients == Gradients::Keep;
  if (!(keeps ? present_ == &composite_ : may_serve(composite_, dependences()))) return std::nullopt;
  FreeMotion motion{.r = at.x, .v = at.v, .w0 = w, .source = request.given};
  const double free = evaluate_free_lightly(work_, at, request, &motion, w);
  const auto passed = eliminate(motion, keeps ? FactorUse::Keep : FactorUse::Renew, w, found);
  if (!passed) return std::nullopt;
  const double scale = larger(request.given != nullptr ? request.given->largest() : free, passed->largest_right_side);
  found->scale = scale;
  found->refinements = passed->refinements;
  found->residual = 0.0;
  if (!std::isfinite(scale)) return work_.not_finite(at.t, at.x);
  found->residual = passed->residual / (scale > 0.0 ? scale : 1.0);
  found->is_complete = is_fine(*passed, found->residual, good_enough(model_.is_exact_for(request)), work_.scales);
  if (found->is_complete && !model_.is_rheonomic()) return Outcome{};

  // Refinement and the power of the reactions need w0 and dw separately.
  write_reactions(model_, blocks_, found->lambda.data(), found->dw.data());
  if (found->is_complete) return Outcome{};
  (void)evaluate_free(work_, at, request, w);
  work_.constraints.evaluate_right_side(model_.parallel, at.x, at.v, w, found->b.data(), nullptr);
  return Outcome{};
}

bool Linearization::find_multipliers(const Kinematics& at, const double* w0, double largest_w0, double* lambda) {
  if (present_ != &composite_ || !composite_.finds_multipliers_alone()) return false;
  work_.set_time(at.t);
  const FreeMotion motion{.r = at.x, .v = at.v, .w0 = w0};
  const Elimination passed =
      composite_.solve(model_.parallel, motion, FactorUse::Keep, nullptr, nullptr, lambda, nullptr);
  const double scale = larger(largest_w0, passed.largest_right_side);
  return std::isfinite(scale) &&
         is_fine(passed, passed.residual / (scale > 0.0 ? scale : 1.0), good_enough(false), work_.scales);
}

/// Computes K, the factor of S, b, lambda and w, or the last three with the present K and factor.
std::optional<Elimination> Linearization::eliminate(const FreeMotion& motion, FactorUse use, double* w,
                                                    MultiplierSolution* found) {
  bring(model_.parallel, motion.source, model_.num_constrained(), model_.num_points());
  const Stopwatch watch(&work_.times.solve);
  const bool renews = use == FactorUse::Renew;
  if (renews && is_needed()) ++work_.counters.factorizations;
  const Elimination passed =
      composite_.solve(model_.parallel, motion, use, blocks_.data(), found->b.data(), found->lambda.data(), w);
  work_.counters.solves += 1 + static_cast<std::size_t>(passed.refinements);
  if (renews) reciprocal_condition_ = passed.reciprocal_condition;
  if (std::isfinite(passed.largest_right_side) && !note_composite(reciprocal_condition_)) return std::nullopt;
  return passed;
}

/// Computes w0 = M^-1 f, b = phi + K'w0, K and the factor of S, or lambda and w where the factor of another
/// configuration serves.
Outcome Linearization::prepare(const Kinematics& at, const Request& request, double* w, MultiplierSolution* found) {
  if (reuse_ != nullptr) reuse_->allow_error(model_.is_exact_for(request) ? 0.0 : request.allowed_error);
  const bool is_new = request.gradients == Gradients::Evaluate && is_needed();
  {
    const Stopwatch watch(&work_.times.evaluate);
    const double free = evaluate_free(work_, at, request, w);
    const double right_side = work_.constraints.evaluate_right_side(model_.parallel, at.x, at.v, w, found->b.data(),
                                                                    is_new ? blocks_.data() : nullptr);
    found->scale = work_.team().largest(larger(free, right_side));
  }
  found->residual = 0.0;
  found->refinements = 0;
  found->is_complete = !work_.has_rows();
  if (!std::isfinite(found->scale)) return work_.not_finite(at.t, at.x);
  if (found->is_complete || !is_new) return {};
  const bool may_be_stale =
      reuse_ != nullptr && state_ != State::None && !dependences().is_found() && reuse_->serves(reciprocal_condition_);
  if (!may_be_stale ||
      !reuse_->solve(at.t, is_fresh(), blocks_.data(), found->b.data(), &found->lambda, found->dw.data()))
    return factorize(at.t, at.x);  // S = K'M^-1K
  state_ = State::Stale;
  found->is_complete = true;
  model_.add_to_moving(found->dw.data(), w);
  return {};
}

void Linearization::solve_once(const double* b, double* lambda, double* dw) {
  const Stopwatch watch(&work_.times.solve);
  ++work_.counters.solves;
  factor().solve_negative(model_.parallel, b, lambda);  // (31)
  write_reactions(model_, blocks_, lambda, dw);
  work_.team().fetch_guests(dw);
}

void Linearization::solve_negative(const double* b, double* x) {
  if (!shares_loads()) return factor().solve_negative(model_.parallel, b, x);
  right_side_.assign(b, b + model_.num_rows());
  points_.resize(3 * model_.num_points());
  solve_refined(right_side_.data(), x, points_.data());
}

/// Computes rho = K'dw + b, lambda -= S^-1 rho, dw -= M^-1 K S^-1 rho in each pass.
void Linearization::solve_refined(const double* b, double* lambda, double* dw) {
  const std::size_t num_rows = model_.num_rows();
  std::fill(lambda, lambda + num_rows, 0.0);
  std::fill(dw, dw + 3 * model_.num_points(), 0.0);
  std::copy(b, b + num_rows, rows_.begin());
  if (num_rows == 0) return;
  const Refinement all{rows_.data(), dw, lambda, 3, 5};
  refine_solution(
      shares_loads() ? all.most_where_shared : all.most_passes, [&] { apply_transposed(dw, b, rows_.data()); },
      [&](int pass) { correct_once(all, pass == 0); });
}

void Linearization::correct(double* rows, double* points, double* sum) {
  {
    const Stopwatch watch(&work_.times.solve);
    ++work_.counters.solves;
    if (state_ != State::Stale || !reuse_->correct(blocks_.data(), rows, points))
      factor().correct(model_.parallel, blocks_.data(), rows, points);
  }
  add_rows(model_, rows, sum);
}

/// `begins` is false if the earlier corrections were of the same problem.
void Linearization::correct_once(const Refinement& what, bool begins) {
  if (!shares_loads()) return correct(what.rows, what.points, what.sum);
  conjugate_.correct(begins, what.rows, what.points);
  add_rows(model_, what.rows, what.sum);
}

// ---- violations ----

double Linearization::evaluate_values(const double* r, double* xi) {
  const Stopwatch watch(&work_.times.evaluate);
  return work_.team().largest(work_.constraints.evaluate_values(model_.parallel, r, xi));
}

double Linearization::evaluate_rates(const double* r, const double* v, double* rates) {
  const Stopwatch watch(&work_.times.evaluate);
  return work_.team().largest(work_.constraints.evaluate_rates(model_.parallel, r, v, rates));
}

std::optional<Projection> Linearization::project_positions(double target, double* r, const PointSource* source,
                                                           double* sum) {
  const bool by_islands = present_ == &composite_;
  bring(model_.parallel, source, by_islands ? model_.num_constrained() : 0, model_.num_points());
  if (!by_islands) {
    if (sum != nullptr) add_reactions(sum, r);
    return std::nullopt;
  }
  const Stopwatch watch(&work_.times.solve);
  const Projection found = composite_.project_positions(model_.parallel, blocks_.data(), target, r, source, sum);
  work_.counters.solves += static_cast<std::size_t>(found.iterations);
  return found;
}

std::optional<Projection> Linearization::project_velocities(double target, const double* r, double* v, double* sum) {
  if (present_ != &composite_) return std::nullopt;
  const Stopwatch watch(&work_.times.solve);
  const Projection found = composite_.project_velocities(model_.parallel, blocks_.data(), target, r, v, sum);
  work_.counters.solves += static_cast<std::size_t>(found.iterations);
  return found;
}

// ---- rank ----

bool Linearization::decide_rank_again(const double* r, RankScope scope) {
  const bool is_new = all_rows_->decide_rank_again(r, scope);
  if (is_new) note_all_rows();
  return is_new;
}

void Linearization::decide_rank_of_poor_parts(const double* r, const std::vector<double>& rows,
                                              const std::vector<double>& accelerations, double allowed) {
  all_rows_->decide_rank_of_poor_parts(r, rows, accelerations, allowed);
  note_all_rows();
}

std::optional<Outcome> Linearization::improve_factor(double t, const double* r) {
  if (present_ == &composite_) {
    work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
    return factorize(t, r);
  }
  if (!all_rows_->share_loads()) return std::nullopt;
  all_rows_->factorize_again();
  note_all_rows();
  return Outcome{};
}

void Linearization::exchange_memory(Memory& memory) {
  all_rows_->exchange_memory(memory);
  if (reuse_ != nullptr) reuse_->exchange_memory(memory);
}

}  // namespace tanor::detail
