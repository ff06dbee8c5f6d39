#include "statics/newton_descent.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "statics/dot.hpp"

namespace tanor {

namespace {

constexpr int most_disturbances = 3;
constexpr double eps = std::numeric_limits<double>::epsilon();
/// Forces that have fallen so far beside the largest one on the way have died away.
constexpr double nothing = 1e-100;

}  // namespace

double longest(const std::vector<double>& dr) {
  double result = 0.0;
  for (std::size_t i = 0; i < dr.size() / 3; ++i) result = larger(result, norm(load(dr.data(), i)));
  return result;
}

Outcome explain_fading(const Model& model, const StaticResidual& residual, int iterations) {
  return {Status::NoSolution,
          "there is no equilibrium: forces die away along the search and nothing stops it; after " +
              std::to_string(iterations) + " iterations " + text(residual.force) + " N are left at point " +
              std::to_string(model.numbering.user_point[residual.worst_point]) +
              ", and Newton's method still moves points by more than " + text(short_step) + " of the scene's size"};
}

StaticResidual NewtonDescent::measure(const StaticState& state) {
  g_.resize(equations_.size());
  xi_.resize(model_.num_rows());
  StaticResidual result;
  result.scale = equations_.evaluate(state.r.data(), state.lambda.data(), g_.data(), xi_.data());
  result.violation = equations_.violation();
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const double force = norm(load(g_.data(), i));
    if (larger(result.force, force) != result.force) result.worst_point = i;
    result.force = larger(result.force, force);
    if (!(force <= equations_.rounding_of_forces(i))) result.known = larger(result.known, force);
  }
  return result;
}

/// Positions are known to eps of the scene's size.
double NewtonDescent::violation_tolerance() const {
  return std::max(1e-12, 16.0 * eps * model_.scene_size / model_.smallest_length);
}

/// Large beside the weight of a few points, small beside that of all.
double NewtonDescent::find_tension() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) sum += norm(load(equations_.forces().data(), i));
  return std::max(sum / std::sqrt(std::max(1.0, static_cast<double>(model_.num_moving()))), residual_.scale * 1e-3);
}

Outcome NewtonDescent::run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals) {
  penalties_.assign(model_.num_rows(), 0.0);
  residual_ = measure(*state);
  tension_ = find_tension();
  mass_shift_ = 0.0;
  iterations_ = factorizations_ = disturbances_ = 0;
  last_move_ = std::numeric_limits<double>::infinity();
  largest_scale_ = 0.0;
  bool trusts_newton = true;
  int long_steps = 0;
  for (int done = 0;; ++done) {
    residuals->push_back(residual_.force);
    const double size = residual_.force + residual_.scale + residual_.violation;
    if (!std::isfinite(size)) return {Status::NotFinite, "forces or constraints are not finite where it starts"};
    largest_scale_ = std::max(largest_scale_, residual_.scale);
    if (is_small(limits)) {
      if (rests(*state)) return {};
      if (++long_steps == most_long_steps) return explain_fading(model_, residual_, iterations_);
    }
    if (residual_.force > 0.0 && residual_.force <= nothing * largest_scale_)
      return explain_fading(model_, residual_, iterations_);
    if (done == limits.max_iterations) return explain("does not converge");
    ++iterations_;
    constexpr double near = 0.1;
    trusts_newton = (trusts_newton || combined(residual_) < near) && try_newton(state);
    if (!trusts_newton && !try_descent(state)) {
      if (disturbances_ == most_disturbances) return explain("stalls");
      disturb(state);
    }
    if (model_.largest_norm(state->r.data()) > 1e6 * model_.scene_size) return explain("moves away without end");
  }
}

bool NewtonDescent::is_small(const NewtonLimits& limits) const {
  const double force = iterations_ > 0 ? residual_.known : residual_.force;
  return force <= limits.force_tolerance * residual_.scale && residual_.violation <= violation_tolerance();
}

/// Newton's next step is short. Where motions cost nothing, small springs keep rounding from long ones; where the
/// energy gains in some direction, stability says so.
bool NewtonDescent::rests(const StaticState& state) {
  const double most = short_step * model_.scene_size;
  if (residual_.force == 0.0 || last_move_ <= most) return true;
  equations_.linearise(state.r.data(), state.lambda.data());
  equations_.stiffness().hold_rows(held_rows, held_rows * residual_.scale / model_.scene_size);
  if (!factorize(0.0)) return true;
  Step step;
  solve_step(&step);
  return longest(step.dr) <= most;
}

bool NewtonDescent::factorize(double shift) {
  ++factorizations_;
  return solver_.factorize(shift);
}

/// [ W  K ] [  dr     ]   [  g  ]
/// [ K' 0 ] [ -dlambda] = [ -xi ]
void NewtonDescent::solve_step(Step* step) {
  step->dr = g_;
  step->dlambda = xi_;
  for (double& x : step->dlambda) x = -x;
  (void)solver_.solve(step->dr.data(), step->dlambda.data());
  for (double& x : step->dlambda) x = -x;
}

/// Where rows contradict each other to first order, as those of a straight chain that is too long for its supports, a
/// step that changes no length comes first.
void NewtonDescent::solve_consistent_step(Step* step) {
  solve_step(step);
  constexpr double poor = 0.1;
  if (solver_.row_residual() < poor) return;
  step->dr = g_;
  std::fill(step->dlambda.begin(), step->dlambda.end(), 0.0);
  (void)solver_.solve(step->dr.data(), step->dlambda.data());
  for (double& x : step->dlambda) x = -x;
}

/// Out of a place of perfect symmetry.
void NewtonDescent::disturb(StaticState* state) {
  constexpr double part = 0.01;
  ++disturbances_;
  for (std::size_t i = 0; i < equations_.size(); ++i)
    state->r[i] += part * model_.smallest_length * std::sin(1.0 + 2.3 * static_cast<double>(i));
  std::fill(state->lambda.begin(), state->lambda.end(), 0.0);
  std::fill(penalties_.begin(), penalties_.end(), 0.0);
  residual_ = measure(*state);
  tension_ = find_tension();
}

bool NewtonDescent::try_newton(StaticState* state) {
  equations_.linearise(state->r.data(), state->lambda.data());
  if (!factorize(0.0)) return false;
  Step step;
  solve_step(&step);
  StaticState next = *state;
  for (std::size_t i = 0; i < step.dr.size(); ++i) next.r[i] += step.dr[i];
  for (std::size_t a = 0; a < step.dlambda.size(); ++a) next.lambda[a] += step.dlambda[a];
  const StaticResidual found = measure(next);
  constexpr double enough = 0.6;
  const double before = combined(residual_), scale = std::max(residual_.scale, eps * found.scale);
  const double after = (scale > 0.0 ? found.known / scale : 0.0) + found.violation;
  const bool is_better = after < enough * before || (before < 1e3 * eps && after <= before);
  if (!is_better) {
    residual_ = measure(*state);
    return false;
  }
  *state = std::move(next);
  residual_ = found;
  last_move_ = longest(step.dr);
  return true;
}

/// U + nu'|xi|
double NewtonDescent::merit(const std::vector<double>& r) {
  std::vector<double> xi(model_.num_rows());
  (void)equations_.work().constraints.evaluate_values(model_.parallel, r.data(), xi.data());
  double sum = equations_.energy(r.data());
  for (std::size_t a = 0; a < xi.size(); ++a) sum += penalties_[a] * std::abs(xi[a]);
  return sum;
}

/// Where points turn, lengths change by the square of the step: back along K, with the factor that stands.
void NewtonDescent::correct_lengths(std::vector<double>* r) {
  const Constraints& constraints = equations_.work().constraints;
  std::vector<double> xi(model_.num_rows()), dr(equations_.size());
  double before = constraints.evaluate_values(model_.parallel, r->data(), xi.data());
  for (int round = 0; round < 2; ++round) {
    std::fill(dr.begin(), dr.end(), 0.0);
    for (double& x : xi) x = -x;
    (void)solver_.solve(dr.data(), xi.data(), 1);
    std::vector<double> corrected = *r;
    for (std::size_t i = 0; i < dr.size(); ++i) corrected[i] += dr[i];
    const double after = constraints.evaluate_values(model_.parallel, corrected.data(), xi.data());
    if (!(after < before)) return;
    before = after;
    *r = std::move(corrected);
  }
}

/// Of W beside the largest mass, 1/s^2; where forces alone keep points on a plane, that of a fall through the scene.
double NewtonDescent::find_frequency2() const {
  constexpr double small = 1e-6;
  const double stiffness = std::max(equations_.stiffness().largest(), small * residual_.scale / model_.scene_size);
  return stiffness / *std::max_element(model_.mass.begin(), model_.mass.end());
}

/// A + s M, with as much of the masses as it takes.
bool NewtonDescent::factorize_with_masses() {
  const double frequency2 = find_frequency2(), most = 1e12 * std::max(frequency2, mass_shift_);
  while (!factorize(mass_shift_)) {
    mass_shift_ = std::max(4.0 * mass_shift_, 1e-4 * frequency2);
    if (!(mass_shift_ < most)) return false;
  }
  return true;
}

bool NewtonDescent::try_descent(StaticState* state) {
  last_move_ = std::numeric_limits<double>::infinity();
  const double most_tension = 1e9 * std::max(residual_.scale, 1e-300);
  std::vector<double> image(equations_.size()), rows(model_.num_rows());
  const std::vector<double> penalties_before = penalties_;
  // Near a soft equilibrium, where W is definite but a full step bends too far, W as it is leads there, not slowly.
  constexpr double near = 1e-3;
  auto curvature = StiffnessMatrix::Curvature::Convex;
  if (combined(residual_) < near) {
    equations_.linearise(state->r.data(), state->lambda.data());
    if (factorize(0.0)) curvature = StiffnessMatrix::Curvature::Exact;
  }
  for (Step step; tension_ <= most_tension;) {
    equations_.linearise(state->r.data(), state->lambda.data(), curvature);
    equations_.stiffness().add_tension(tension_, state->r.data());
    if (!factorize_with_masses()) return false;
    solve_consistent_step(&step);

    // nu is larger than any multiplier, so that the penalty is exact.
    for (std::size_t a = 0; a < penalties_.size(); ++a)
      penalties_[a] = std::max(penalties_before[a], 1.2 * std::abs(state->lambda[a] + step.dlambda[a]));
    equations_.stiffness().multiply(step.dr.data(), image.data());
    equations_.apply_transposed(step.dr.data(), rows.data());
    double predicted = dot(step.dr, equations_.forces()) - 0.5 * dot(step.dr, image);
    for (std::size_t a = 0; a < rows.size(); ++a)
      predicted += penalties_[a] * (std::abs(xi_[a]) - std::abs(xi_[a] + rows[a]));
    const double before = merit(state->r);
    StaticState next = *state;
    for (std::size_t i = 0; i < step.dr.size(); ++i) next.r[i] += step.dr[i];
    correct_lengths(&next.r);
    const double gained = before - merit(next.r), ratio = gained / predicted;
    const double energy = std::max(std::abs(before), residual_.scale * model_.scene_size);
    const bool is_lost_in_rounding = std::abs(predicted) < 1e-13 * energy;
    if (std::isfinite(gained) && (is_lost_in_rounding || (predicted > 0.0 && ratio > 1e-3))) {
      for (std::size_t a = 0; a < step.dlambda.size(); ++a) {
        next.lambda[a] += step.dlambda[a];
        penalties_[a] = std::max(0.5 * penalties_before[a], 1.2 * std::abs(next.lambda[a]));
      }
      *state = std::move(next);
      residual_ = measure(*state);
      tension_ *= ratio > 0.7 ? 0.1 : ratio > 0.3 ? 0.4 : ratio < 0.1 ? 3.0 : 1.0;
      mass_shift_ = mass_shift_ > 1e-6 * find_frequency2() ? 0.1 * mass_shift_ : 0.0;
      return true;
    }
    penalties_ = penalties_before;
    tension_ = std::max(4.0 * tension_, 1e-8 * residual_.scale);
    residual_ = measure(*state);
  }
  return false;
}

Outcome NewtonDescent::explain(const char* why) const {
  const auto point = model_.numbering.user_point[residual_.worst_point];
  return {Status::NotConverged,
          std::string("no equilibrium was found: the search ") + why + " after " + std::to_string(iterations_) +
              " iterations; best residual " + text(residual_.force) + " N (" + text(residual_.relative_force()) +
              " of the largest force) at point " + std::to_string(point) + ", violation " + text(residual_.violation)};
}

}  // namespace tanor
