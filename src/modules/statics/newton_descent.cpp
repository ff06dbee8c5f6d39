#include "statics/newton_descent.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"
#include "base/text.hpp"
#include "base/with_unit.hpp"

namespace tanor::detail {

namespace {

constexpr int most_disturbances = 3;
/// While forces are small, at most so many steps may be long.
constexpr int most_long_steps = 40;
/// Residual forces over their scale plus the violation, below which a state counts as near an equilibrium.
constexpr double near_equilibrium = 1e-3;
/// Forces that fall below this part of the largest one met on the way have died away.
constexpr double nothing = 1e-100;

}  // namespace

double longest(const std::vector<double>& dr) {
  double result = 0.0;
  for (std::size_t i = 0; i < dr.size() / 3; ++i) result = larger(result, norm(load(dr.data(), i)));
  return result;
}

std::string NewtonDescent::worst_point() const {
  return "point " + std::to_string(model_.numbering.user_point[residual_.worst_point]);
}

/// Returns the failure of a search that came no nearer: "no equilibrium was found: the search stalls after …".
Outcome NewtonDescent::explain_failure(const std::string& why) const {
  const std::string& unit = model_.system.units.force;
  return {Status::NotConverged, "no equilibrium was found: " + why + " after " +
                                    text_of_count(iterations_, "iteration") + "; best residual " +
                                    with_unit(text(residual_.force), unit) + " (the largest force is " +
                                    with_unit(text(residual_.scale), unit) + ") at " + worst_point() + ", violation " +
                                    text(residual_.violation)};
}

Outcome NewtonDescent::explain_fading() const {
  const std::string& unit = model_.system.units.force;
  return {Status::NoSolution, "there is no equilibrium: forces die away along the search and nothing stops it; after " +
                                  text_of_count(iterations_, "iteration") + " " +
                                  with_unit(text(residual_.force), unit) + " are left at " + worst_point() +
                                  ", and Newton's method still moves points by more than " + text(short_step) +
                                  " of the scene's size"};
}

Outcome NewtonDescent::explain_not_finite() const {
  const std::string what =
      (std::isfinite(residual_.force) ? "constraints are" : "the force at " + worst_point() + " is") + " not finite ";
  if (iterations_ == 0) return {Status::NotFinite, what + "where it starts; do points lie on each other?"};
  return {Status::NotFinite, "no equilibrium was found: after " + text_of_count(iterations_, "iteration") +
                                 " of the search " + what +
                                 "any more; points that pull each other without bound, as opposite charges do, meet"};
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

/// Returns the tolerance of the violation: positions are accurate to eps of the scene's size or of their own.
double NewtonDescent::violation_tolerance() const {
  return std::max(1e-12, 16.0 * eps * equations_.extent() / model_.smallest_length);
}

/// Returns the first tension, large beside the weight of a few points and small beside that of all.
double NewtonDescent::find_tension() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) sum += norm(load(equations_.forces().data(), i));
  return std::max(sum / std::sqrt(std::max(1.0, static_cast<double>(model_.num_moving()))), residual_.scale * 1e-3);
}

Outcome NewtonDescent::run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals) {
  penalties_.assign(model_.num_rows(), 0.0);
  residual_ = measure(*state);
  tension_ = find_tension();
  const double farthest = equations_.extent() + 1e6 * model_.scene_size;
  mass_shift_ = 0.0;
  iterations_ = factorizations_ = disturbances_ = slow_steps_ = 0;
  last_move_ = std::numeric_limits<double>::infinity();
  largest_scale_ = 0.0;
  trusts_newton_ = true;
  int long_steps = 0;
  for (int done = 0;; ++done) {
    residuals->push_back(residual_.force);
    const double size = residual_.force + residual_.scale + residual_.violation;
    if (!std::isfinite(size)) return explain_not_finite();
    largest_scale_ = std::max(largest_scale_, residual_.scale);
    if (is_small(limits) && is_small_here(limits, *state)) {
      if (rests(*state)) {
        if (residual_.force > limits.force_tolerance * residual_.scale && done < limits.max_iterations && halves(state))
          continue;
        return {};
      }
      if (++long_steps == most_long_steps) return explain_fading();
    }
    if (is_near(limits, *state)) return {};
    if (residual_.force > 0.0 && residual_.force <= nothing * largest_scale_) return explain_fading();
    if (done == limits.max_iterations)
      return explain_failure(whole_ ? "no convergence" : "the search does not converge");
    ++iterations_;
    if (!advance(state)) return explain_failure("the search stalls");
    if (model_.largest_norm(state->r.data()) > farthest) return explain_failure("the search moves away without end");
  }
}

/// Takes one step. Returns false if nothing leads further.
bool NewtonDescent::advance(StaticState* state) {
  constexpr double near = 0.1, slow = 0.8;
  const double before = combined(residual_);
  if (whole_) return try_shortened(state);
  trusts_newton_ = (trusts_newton_ || before < near) && try_newton(state);
  if (!trusts_newton_ && !try_descent(state)) {
    if (disturbances_ == most_disturbances) return false;
    disturb(state);
  }
  slow_steps_ = combined(residual_) > slow * before ? slow_steps_ + 1 : 0;
  return true;
}

bool NewtonDescent::is_small(const NewtonLimits& limits) const {
  const double force = iterations_ > 0 ? residual_.known : residual_.force;
  return force <= limits.force_tolerance * residual_.scale && residual_.violation <= violation_tolerance();
}

/// Returns true if all forces have become small beside those met on the way, and Newton's steps are as short as the
/// tolerance of forces asks for beside the scene's size. Where all forces vanish at rest, as at the minimum of x^4, the
/// largest one is no scale for what is left of them.
bool NewtonDescent::is_near(const NewtonLimits& limits, const StaticState& state) {
  if (!have_forces_vanished(limits) || residual_.violation > violation_tolerance()) return false;
  if (whole_) last_move_ = std::min(last_move_, find_next_step(state));  // shorter steps do not improve rounding
  return last_move_ <= limits.force_tolerance * model_.scene_size;
}

/// Returns true if the residual is small, with rounding measured at this configuration. Rounding of one that the search
/// has left, where charges had met, would excuse any force.
bool NewtonDescent::is_small_here(const NewtonLimits& limits, const StaticState& state) {
  equations_.linearise(state.r.data(), state.lambda.data());
  residual_ = measure(state);
  if (residual_.force <= limits.force_tolerance * residual_.scale || !is_small(limits)) return is_small(limits);
  return is_linear_near(state);
}

/// Returns true if forces grow as W predicts over a step that is short beside the scene and long beside rounding. Where
/// charges meet they do not, and W is no measure of rounding.
bool NewtonDescent::is_linear_near(const StaticState& state) {
  constexpr double part = 1e-8, enough = 0.5;
  std::vector<double> dr(equations_.size()), image(dr.size()), xi(xi_.size());
  for (std::size_t i = 0; i < dr.size(); ++i) dr[i] = part * model_.scene_size * irregular(i);
  StaticState moved = state;
  for (std::size_t i = 0; i < dr.size(); ++i) moved.r[i] += dr[i];
  const std::vector<double> before = g_;
  equations_.stiffness().multiply(dr.data(), image.data());
  (void)measure(moved);
  bool is_linear = true;
  const auto size = [](Vec3 a) {
    return std::abs(a.x) + std::abs(a.y) + std::abs(a.z);
  };  // squares of its entries may overflow
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    // g(r + dr) = g - W dr
    const Vec3 grown = load(g_.data(), i) - load(before.data(), i), expected = load(image.data(), i);
    const double allowed = enough * size(expected);  // says nothing where W overflows
    const bool grows = std::isfinite(allowed) && size(grown + expected) <= allowed;
    if (size(load(before.data(), i)) > 0.0 && !grows) is_linear = false;
  }
  residual_ = measure(state);
  return is_linear;
}

/// Returns true if loads cancel but for rounding, or Newton's next step is short. Small springs prevent long steps from
/// rounding along motions that cost nothing. If the energy falls in some direction, the stability check reports it.
bool NewtonDescent::rests(const StaticState& state) {
  const double most = short_step * model_.scene_size;
  bool are_cancelled = true;
  for (std::size_t i = 0; i < model_.num_moving(); ++i)
    are_cancelled = are_cancelled && norm(load(g_.data(), i)) <= equations_.rounding_of_loads(i);
  return are_cancelled || last_move_ <= most || find_next_step(state) <= most;
}

/// Returns the length of Newton's next step, m, with each coordinate held by a small spring; 0 if there is none.
double NewtonDescent::find_next_step(const StaticState& state) {
  equations_.linearise(state.r.data(), state.lambda.data());
  equations_.stiffness().hold_rows(held_rows, held_rows * residual_.scale / model_.scene_size);
  if (!factorize(0.0)) return 0.0;
  Step step;
  solve_step(&step);
  return longest(step.dr);
}

/// Takes a part of Newton's step if `is_better` accepts its residual; otherwise the state stays.
template <class Accepts>
bool NewtonDescent::take_newton_step(const Step& step, double length, StaticState* state, const Accepts& is_better) {
  StaticState next = *state;
  for (std::size_t i = 0; i < step.dr.size(); ++i) next.r[i] += length * step.dr[i];
  for (std::size_t a = 0; a < step.dlambda.size(); ++a) next.lambda[a] += length * step.dlambda[a];
  const StaticResidual found = measure(next);
  if (!is_better(found)) {
    residual_ = measure(*state);
    return false;
  }
  *state = std::move(next);
  residual_ = found;
  last_move_ = length == 1.0 ? longest(step.dr) : std::numeric_limits<double>::infinity();
  return true;
}

/// Takes another Newton step if it halves the residual. Rounding of single points excuses their residual forces, but
/// not a sum of many of the same sign.
bool NewtonDescent::halves(StaticState* state) {
  equations_.linearise(state->r.data(), state->lambda.data());
  Step step;
  if (!factorize(0.0)) return false;
  solve_step(&step);
  const bool is_taken = take_newton_step(step, 1.0, state, [this](const StaticResidual& found) {
    return found.force < 0.5 * residual_.force &&
           found.violation <= std::max(residual_.violation, violation_tolerance());
  });
  iterations_ += is_taken ? 1 : 0;
  return is_taken;
}

bool NewtonDescent::factorize(double shift) {
  ++factorizations_;
  return whole_ ? whole_->factorize(shift) : solver_.factorize(shift);
}

/// [ W  K ] [  dr     ]   [       g   ]
/// [ K' 0 ] [ -dlambda] = [ -share xi ]
void NewtonDescent::solve_step(Step* step, double share, int refinements) {
  step->dr = g_;
  step->dlambda = xi_;
  for (double& x : step->dlambda) x *= -share;
  if (whole_)
    whole_->solve(&step->dr, &step->dlambda);
  else
    (void)solver_.solve(step->dr.data(), step->dlambda.data(), refinements);
  for (double& x : step->dlambda) x = -x;
}

/// Solves for a step. If rows contradict each other to first order, as in a straight chain that is too long for its
/// supports, the step changes no length. Lengths are corrected after it, so that few digits suffice.
void NewtonDescent::solve_consistent_step(Step* step, double share) {
  constexpr int refinements = 1;
  constexpr double poor = 0.1;
  solve_step(step, share, refinements);
  if (solver_.row_residual() < poor) return;
  step->dr = g_;
  std::fill(step->dlambda.begin(), step->dlambda.end(), 0.0);
  (void)solver_.solve(step->dr.data(), step->dlambda.data(), refinements);
  for (double& x : step->dlambda) x = -x;
}

/// Moves the state out of a configuration of perfect symmetry.
void NewtonDescent::disturb(StaticState* state) {
  constexpr double part = 0.01;
  ++disturbances_;
  equations_.disturb(part * model_.smallest_length, state->r.data());
  std::fill(state->lambda.begin(), state->lambda.end(), 0.0);
  std::fill(penalties_.begin(), penalties_.end(), 0.0);
  residual_ = measure(*state);
  tension_ = find_tension();
}

bool NewtonDescent::try_newton(StaticState* state) {
  equations_.linearise(state->r.data(), state->lambda.data());
  if (!factorize_nearly_exact()) return false;
  Step step;
  solve_step(&step);
  return take_newton_step(step, 1.0, state, [this](const StaticResidual& found) {
    constexpr double enough = 0.6;
    const double before = combined(residual_), scale = std::max(residual_.scale, eps * found.scale);
    const double after = (scale > 0.0 ? found.known / scale : 0.0) + found.violation;
    return after < enough * before || (before < 1e3 * eps && after <= before);
  });
}

/// Takes Newton's step, shortened until the residual falls, or with masses added where no length is short enough.
bool NewtonDescent::try_shortened(StaticState* state) {
  constexpr int most_attempts = 40;
  const auto relative = [](const StaticResidual& at, double scale) {
    return (scale > 0.0 ? at.force / scale : at.force) + at.violation;
  };
  equations_.linearise(state->r.data(), state->lambda.data());
  const double frequency2 = equations_.stiffness().largest() / *std::ranges::max_element(model_.mass) + 1e-300;
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    Step step;
    const bool has_factor = factorize(mass_shift_);
    if (has_factor) solve_step(&step);
    const StaticResidual now = residual_;
    for (double length = 1.0; has_factor && std::isfinite(longest(step.dr)) && length > 1e-3; length *= 0.5) {
      const double wanted = (1.0 - 1e-4 * length) * relative(now, now.scale);
      if (!take_newton_step(step, length, state,
                            [&](const StaticResidual& found) { return relative(found, now.scale) < wanted; }))
        continue;
      if (mass_shift_ > 0.0) last_move_ = std::numeric_limits<double>::infinity();
      mass_shift_ = mass_shift_ > 1e-12 * frequency2 ? 0.1 * mass_shift_ : 0.0;
      return true;
    }
    mass_shift_ = std::max(10.0 * mass_shift_, 1e-6 * frequency2);
  }
  return false;
}

/// Returns the exact penalty function U + nu'|xi|.
double NewtonDescent::merit(const std::vector<double>& r) {
  std::vector<double> xi(model_.num_rows());
  (void)equations_.work().constraints.evaluate_values(model_.parallel, r.data(), xi.data());
  double sum = equations_.energy(r.data());
  for (std::size_t a = 0; a < xi.size(); ++a) sum += penalties_[a] * std::abs(xi[a]);
  return sum;
}

/// Corrects the lengths, which change by the square of the step where rods turn. Points move along K, with the current
/// factor, until xi is what the step was meant to leave.
void NewtonDescent::correct_lengths(double share, std::vector<double>* r) {
  const Constraints& constraints = equations_.work().constraints;
  std::vector<double> xi(model_.num_rows()), dr(equations_.size());
  const auto measure_rest = [&](const std::vector<double>& at) {
    const double violation = constraints.evaluate_values(model_.parallel, at.data(), xi.data());
    if (share == 1.0) return violation;
    double most = 0.0;
    for (std::size_t a = 0; a < xi.size(); ++a) {
      xi[a] -= (1.0 - share) * xi_[a];
      most = larger(most, std::abs(xi[a]));
    }
    return most;
  };
  double before = measure_rest(*r);
  for (int round = 0; round < 2; ++round) {
    std::fill(dr.begin(), dr.end(), 0.0);
    for (double& x : xi) x = -x;
    (void)solver_.solve(dr.data(), xi.data(), 1);
    std::vector<double> corrected = *r;
    for (std::size_t i = 0; i < dr.size(); ++i) corrected[i] += dr[i];
    const double after = measure_rest(corrected);
    if (!(after < before)) return;
    before = after;
    *r = std::move(corrected);
  }
}

/// Returns the squared frequency of W with the largest mass, 1/s^2. If forces alone keep points on a plane, it is that
/// of a fall through the scene.
double NewtonDescent::find_frequency2() const {
  constexpr double small = 1e-6;
  const double stiffness = std::max(equations_.stiffness().largest(), small * residual_.scale / model_.scene_size);
  return stiffness / *std::max_element(model_.mass.begin(), model_.mass.end());
}

/// Factorizes A. If motions cost nothing, so that rounding and residual forces decide the sign of a pivot, a mass shift
/// is added that is small enough for Newton steps: a shift proportional to the residual keeps their order, as in the
/// Levenberg-Marquardt method.
bool NewtonDescent::factorize_nearly_exact() {
  constexpr double little = 1e-9;
  if (factorize(0.0)) return true;
  const double mass = *std::max_element(model_.mass.begin(), model_.mass.end());
  return factorize(little * find_frequency2() + residual_.force / (model_.scene_size * mass));
}

/// Factorizes A + s M with a mass shift large enough to make it positive definite.
bool NewtonDescent::factorize_with_masses() {
  const double frequency2 = find_frequency2(), most = 1e12 * std::max(frequency2, mass_shift_);
  while (!factorize(mass_shift_)) {
    mass_shift_ = std::max(4.0 * mass_shift_, 1e-4 * frequency2);
    if (!(mass_shift_ < most)) return false;
  }
  return true;
}

/// Chooses between W and its convex part. Near a soft equilibrium, where W is definite but a full step bends too far,
/// the exact W converges faster. So it does if the rods of a rigid body push and pull each other much harder than the
/// load.
StiffnessMatrix::Curvature NewtonDescent::choose_curvature(const StaticState& state) {
  constexpr int many = 5;
  if (slow_steps_ >= 4 * many) return StiffnessMatrix::Curvature::Exact;
  if (combined(residual_) >= near_equilibrium && slow_steps_ < many) return StiffnessMatrix::Curvature::Convex;
  equations_.linearise(state.r.data(), state.lambda.data());
  return factorize_nearly_exact() ? StiffnessMatrix::Curvature::Exact : StiffnessMatrix::Curvature::Convex;
}

bool NewtonDescent::try_descent(StaticState* state) {
  last_move_ = std::numeric_limits<double>::infinity();
  const double most_tension = 1e9 * std::max(residual_.scale, 1e-300);
  const std::vector<double> penalties_before = penalties_;
  const StiffnessMatrix::Curvature curvature = choose_curvature(*state);
  while (tension_ <= most_tension) {
    equations_.linearise(state->r.data(), state->lambda.data(), curvature);
    equations_.stiffness().add_tension(tension_, state->r.data());
    if (!factorize_with_masses()) return false;
    // Rods that are much too short demand steps beyond the range of the linear model; they are then corrected in parts.
    constexpr double least = 1e-3;
    for (double share = 1.0; share > least; share *= 0.25) {
      Step step;
      solve_consistent_step(&step, share);
      if (take_step(step, share, penalties_before, state)) return true;
      if (!(residual_.violation > near_equilibrium && longest(step.dr) > model_.smallest_length)) break;
    }
    tension_ = std::max(4.0 * tension_, 1e-8 * residual_.scale);
  }
  return false;
}

/// Takes the step if the gain agrees with the prediction; otherwise the state stays.
bool NewtonDescent::take_step(const Step& step, double share, const std::vector<double>& penalties_before,
                              StaticState* state) {
  std::vector<double> image(equations_.size()), rows(model_.num_rows());
  // The penalty is exact because nu exceeds every multiplier.
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
  correct_lengths(share, &next.r);
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
  residual_ = measure(*state);
  return false;
}

}  // namespace tanor::detail
