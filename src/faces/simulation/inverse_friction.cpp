#include "simulation/inverse_friction.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace tanor::detail {

InverseFriction::InverseFriction(Workspace& work, NormalSpace& normal)
    : work_(work),
      model_(work.model()),
      normal_(normal),
      laws_(model_.system, model_.numbering, work.constraints.tangents(), model_.incidences),
      scales_(work, laws_),
      fixed_point_(laws_, scales_, *this, model_.num_rows()),
      lambda_(model_.num_rows()),
      forces_(3 * work.constraints.tangents().size()),
      points_(3 * model_.num_points()),
      part_(points_.size()) {}

/// Adds sign tau(x) to `points`.
void InverseFriction::add(double sign, const double* x, std::vector<double>* points) {
  laws_.write_forces(x, forces_.data());
  const Tangents& tangents = work_.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c)
    add_to(points->data(), tangents[c].point, sign * load(forces_.data(), c));
}

/// Finds lambda = Gamma^-1 K'(Mw - f - tau).
void InverseFriction::find_multipliers(const double* x, double* lambda) {
  points_ = *force_;
  add(-1.0, x, &points_);
  normal_.project(points_.data(), part_.data(), lambda);
}

void InverseFriction::find_change(const double* x, double* lambda) {
  std::fill(points_.begin(), points_.end(), 0.0);
  add(-1.0, x, &points_);
  normal_.project(points_.data(), part_.data(), lambda);
}

Outcome InverseFriction::find(double t, const std::vector<double>& r, const std::vector<double>& v,
                              const std::vector<double>& blocks, const std::vector<double>& force,
                              std::vector<double>* tau) {
  constexpr double rest = 1e-9;  // relative to the fastest point, for rounding of a velocity that was given as 0
  Tangents& tangents = work_.constraints.tangents();
  const double fastest = model_.largest_norm(v.data());
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const bool is_exact = tangents[c].first_row >= 0;
    tangents.set_stick(c, is_exact && norm(tangents.sliding_velocity(c, v.data())) <= rest * fastest);
  }
  laws_.set_state(model_.parallel, t, r.data(), v.data(), blocks.data());
  force_ = &force;
  const std::vector<double> nothing(laws_.num_parts(), 0.0);
  find_multipliers(nothing.data(), lambda_.data());
  constexpr int depth = 10;
  bool is_found = !laws_.depend_on_reactions();
  if (!is_found) {
    // Anderson's method starts from afar, Newton's method finds the last digits.
    constexpr double wanted = 1e-15;
    std::vector<double> guess = lambda_;
    is_found = fixed_point_.iterate(model_.parallel, depth, lambda_.data()).has_converged;
    if (is_found) guess = lambda_;
    if (!is_found) lambda_ = guess;
    const bool is_closer = fixed_point_.solve_by_newton(model_.parallel, lambda_.data(), wanted).has_converged;
    if (!is_closer) lambda_ = guess;
    is_found = is_found || is_closer;
  }
  std::fill(tau->begin(), tau->end(), 0.0);
  std::vector<double> x(laws_.num_parts());
  laws_.evaluate(model_.parallel, lambda_.data(), x.data());
  add(1.0, x.data(), tau);
  // Contacts at rest have no rows of their own here.
  for (std::size_t c = 0; c < tangents.size(); ++c) tangents.set_stick(c, false);
  if (is_found) return {};
  return {Status::NotConverged, "friction of the given motion at t = " + text(t) + ": no multipliers obey the law"};
}

}  // namespace tanor::detail
