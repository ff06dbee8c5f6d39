#include "certificate/verifier.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "evaluate/energy_definitions.hpp"
#include "system/members.hpp"

namespace tanor::detail {

Verifier::Verifier(Forms& forms, const Answer& answer, SecondFactorization by)
    : AnswerMeasures(forms, answer),
      second_factorization_(by),
      has_friction_(model_.has_friction()),
      something_sticks_(work_.constraints.tangents().num_sticking() > 0),
      random_(model_) {
  work_.set_time(answer.t);
  measure_scale();
}

Certificate Verifier::verify() {
  if (model_.num_moving() == 0) return std::move(result_);
  if (work_.forces.has_energies()) verify_energies();
  if (d_ == 0 && forms_.tangent == nullptr) verify_free();
  has_both_ = d_ > 0 && forms_.tangent != nullptr && forms_.normal != nullptr;
  if (has_both_) solve_other();
  if (d_ > 0 && forms_.normal != nullptr) rcond_of_S_ = forms_.normal->linearization().estimate_reciprocal_condition();
  if (forms_.tangent != nullptr) rcond_of_H_ = forms_.tangent->dynamics().completed().estimate_reciprocal_condition();
  result_.reciprocal_condition = std::min(rcond_of_S_, rcond_of_H_);
  if (d_ > 0) verify_constraints();
  if (forms_.tangent != nullptr) verify_coordinates();
  if (has_both_) verify_both();
  return std::move(result_);
}

// ---- findings ----

/// Finds the scale of accelerations: the largest of w, M^-1 f, M^-1 tau and M^-1 eta in each neighbourhood.
void Verifier::measure_scale() {
  w0_.assign(n_, 0.0);
  work_.evaluate_free(answer_.t, answer_.r.data(), answer_.v.data(), w0_.data());
  acceleration_.assign(work_.scales.size(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const Vec3 w0 = load(w0_.data(), i), tau = load(answer_.tau.data(), i), eta = load(answer_.eta.data(), i);
    store(w0_.data(), i, w0 + model_.inverse_mass[i] * tau);
    double& own = acceleration_[work_.scales.of_point(i)];
    own = std::max({own, norm(load(answer_.w.data(), i)), norm(w0), model_.inverse_mass[i] * norm(tau),
                    model_.inverse_mass[i] * norm(eta)});
  }
  for (double& own : acceleration_) own = own > 0.0 ? own : 1.0;
}

void Verifier::add(double* figure, const Identity& identity, double error, double allowed, const std::string& where) {
  if (std::isnan(*figure) || !(error <= *figure)) *figure = error;
  result_.checks.push_back({identity.symbols, error, std::min(allowed, fewest_digits), where, identity.words});
}

void Verifier::add_row(double* figure, const Identity& identity, const Worst& worst, double allowed) {
  const std::string where = worst.error > 0.0 ? equation_name(model_.system, worst.index) : "";
  add(figure, identity, worst.error, allowed, where);
}

void Verifier::add_point(double* figure, const Identity& identity, const Worst& worst, double allowed) {
  const std::string where =
      worst.error > 0.0 ? "point " + text(model_.numbering.user_point[worst.index]) : std::string();
  add(figure, identity, worst.error, allowed, where);
}

/// Verifies the forces of tuple energies by their second definition. Near rest these forces cancel, within a tuple too,
/// and have only the digits that rounding leaves. They are then measured by their change when points move, and by the
/// rounding of the terms that cancel, if these are larger.
void Verifier::verify_energies() {
  constexpr double small = 1e-9, digits = 1e-4;       // relative to the scene; 1e-14 of df/dr times it
  constexpr double allowed = 1e-10, other_way = 8.0;  // rounding of the kernel relative to that of the definition
  const auto define_at = [&](const Vector& r) { return find_defined_forces(model_.system, answer_.t, to_user(r)); };
  const auto gather = [&](const Vector& of_user) {
    Vector result(n_);
    model_.numbering.gather_points(of_user, result);
    return result;
  };
  Vector found(n_), moved = answer_.r;
  work_.forces.energies().write_forces(found.data());
  for (std::size_t i = 0; i < n_; ++i)
    moved[i] += small * model_.scene_size * std::sin(1.0 + 2.3 * static_cast<double>(i));
  const DefinedForces defined = define_at(answer_.r);
  const Vector wanted = gather(defined.f), rounding = gather(defined.rounding), beside = gather(define_at(moved).f);
  Worst worst;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const Vec3 here = load(wanted.data(), i), change = load(beside.data(), i) - here;
    const double in_sum = std::max(digits / small * norm(change), other_way / allowed * norm(load(rounding.data(), i)));
    const double scale = std::max(at_point(acceleration_, i), model_.inverse_mass[i] * in_sum);
    worst.see(model_.inverse_mass[i] * norm(load(found.data(), i) - here) / scale, i);
  }
  add_point(&result_.residual, {"f = -dU/dr", "forces from their energies"}, worst, allowed + rounding_of_places());
}

/// Verifies M w = f if there are neither constraints nor coordinates.
void Verifier::verify_free() {
  Vector rest(n_, 0.0);
  for (std::size_t i = 0; i < moving_; ++i) rest[i] = answer_.w[i] - w0_[i];
  add_point(&result_.residual, {"M w = f", "Newton's law"}, worst_point(rest, acceleration_), 1e-14);
}

}  // namespace tanor::detail
