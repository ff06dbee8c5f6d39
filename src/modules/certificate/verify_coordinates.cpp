#include <algorithm>
#include <cmath>

#include "certificate/verifier.hpp"

/// \file Verifies what coordinates must satisfy, alone and with constraints.
namespace tanor::detail {

namespace {

// Second derivatives by 9 places, of order 8 around the middle one and of order 7 at the first one.
constexpr double middle_stencil[9] = {-1.0 / 560.0, 8.0 / 315.0, -1.0 / 5.0,  8.0 / 5.0,   -205.0 / 72.0,
                                      8.0 / 5.0,    -1.0 / 5.0,  8.0 / 315.0, -1.0 / 560.0};
constexpr double side_stencil[9] = {29531.0 / 5040.0, -962.0 / 35.0, 621.0 / 10.0,  -4006.0 / 45.0, 691.0 / 8.0,
                                    -282.0 / 5.0,     2143.0 / 90.0, -206.0 / 35.0, 363.0 / 560.0};

}  // namespace

/// Returns A H^-1 A'M u.
Verifier::Vector Verifier::project_by_coordinates(const Vector& u) {
  Vector M_rest(n_, 0.0), x(work_.coordinates.num_coordinates()), change(n_, 0.0), result(n_, 0.0);
  const Vector& A = forms_.tangent->dynamics().blocks();
  repeat(most_passes(rcond_of_H_), [&] {
    for (std::size_t i = 0; i < moving_; ++i) M_rest[i] = model_.mass[i / 3] * (u[i] - result[i]);
    work_.coordinates.apply_transposed(model_.parallel, A.data(), M_rest.data(), x.data());
    forms_.tangent->dynamics().completed().solve_negative(x.data());
    work_.coordinates.apply(model_.parallel, A.data(), x.data(), change.data());
    std::fill(change.begin() + static_cast<std::ptrdiff_t>(moving_), change.end(), 0.0);
    for (std::size_t i = 0; i < moving_; ++i) result[i] -= change[i];
    return norm_of(change);
  });
  return result;
}

void Verifier::verify_coordinates() {
  const double rcond = rcond_of_H_;
  const double allowed = conditioned(rcond);

  // A'(M w - f - tau) = 0, measured as the acceleration A H^-1 A'(M w - f - tau)
  Vector rest(n_, 0.0);
  for (std::size_t i = 0; i < moving_; ++i) rest[i] = answer_.w[i] - w0_[i];
  add_point(&result_.residual, {"A'(M w" + given_force(" - ") + ") = 0", "Newton's law along the coordinates"},
            worst_point(project_by_coordinates(rest), acceleration_), 1e-11 + 1e2 * eps / rcond);

  if (forms_.is_tangent()) verify_curve();
  if (d_ > 0) return;
  const Vector u = random_.points_by_M(), y = random_.points_by_M();
  const Vector Pu = project_by_coordinates(u), PPu = project_by_coordinates(Pu), Py = project_by_coordinates(y);
  for (std::size_t i = 0; i < n_; ++i) rest[i] = PPu[i] - Pu[i];
  add_point(&result_.tangent_identity, {"P P u = P u, P = A H^-1 A'M", "projection by coordinates that is done twice"},
            worst_point_by_M(rest, worst_point_by_M(u, 1.0).error), allowed);
  const double asymmetry = std::abs(product(y, Pu) - product(u, Py)) / (norm_of(u) * norm_of(y));
  add(&result_.tangent_identity, {"y'M P u = u'M P y", "symmetry of the projection by coordinates"}, asymmetry, allowed,
      "");
}

/// Verifies w = d2 r(q(t), t)/dt2 by differences of positions alone, which share no derivative with A and psi. The
/// stencil has order 8 and steps of a fiftieth of the time in which points cross the smallest neighbourhood, or a drive
/// turns their velocity. One of the sides alone is enough beside a corner, which a stencil must not reach over. All
/// points move together, so that errors are relative to the largest acceleration of the scene.
void Verifier::verify_curve() {
  const double acceleration = *std::max_element(acceleration_.begin(), acceleration_.end());
  const double speed = std::max(model_.largest_norm(answer_.v.data()), 1e-3 * work_.velocity_scale);
  double length = model_.smallest_length;
  for (std::size_t i = 0; i < model_.num_moving(); ++i)
    length = std::min(length, work_.scales.length(work_.scales.of_point(i)));
  const double crossing = length / std::max(speed, std::sqrt(length * acceleration));
  const bool is_driven = work_.coordinates.depends_on_time();
  const double h = 0.02 * (is_driven ? std::min(speed / acceleration, crossing) : crossing);
  constexpr double enough = 1e-6;
  const double far = eps * model_.largest_norm(answer_.r.data()) / (h * h * acceleration);
  // Returns the error by 9 places, the first one `first` steps after the answer; nothing if a table ends among them.
  const auto measure = [&](const double(&weights)[9], int first, double step) -> std::optional<Worst> {
    Vector sum(n_, 0.0), place(n_);
    try {
      for (int k = 0; k < 9; ++k) {
        forms_.tangent->dynamics().write_place_along((first + k) * step, place.data());
        for (std::size_t i = 0; i < moving_; ++i) sum[i] += weights[k] * (place[i] - answer_.r[i]);
      }
    } catch (const InputError&) {
      work_.set_time(answer_.t);
      return {};
    }
    work_.set_time(answer_.t);
    for (std::size_t i = 0; i < moving_; ++i) sum[i] = sum[i] / (step * step) - answer_.w[i];
    return worst_point(sum, acceleration);
  };
  std::optional<Worst> least = measure(middle_stencil, -4, h);
  if (!least) return;
  if (double allowed = enough + 1e2 * far; !(least->error > allowed))
    return add_point(&result_.residual, {"w = d2/dt2 r(q(t), t)", "accelerations as differences of positions"}, *least,
                     allowed);
  for (const double step : {h, -h}) {
    const std::optional<Worst> side = measure(side_stencil, 0, step);
    if (side && side->error < least->error) least = side;
  }
  add_point(&result_.residual, {"w = d2/dt2 r(q(t), t)", "accelerations as differences of positions"}, *least,
            enough + 1e4 * far);
}

/// Verifies A H^-1 A'M u + M^-1 K S^-1 K'u = u (9). Both projectors are orthogonal in the norm |M^1/2 .|, in which
/// errors are measured, whatever the masses. For M u, in |M^-1/2 .|, the same numbers verify (10) = M (9) M^-1.
void Verifier::verify_identity(const std::string& symbols, double allowed) {
  const Vector u = random_.points_by_M(), Qu = project_onto_tangent(u);
  Vector rest = project_by_coordinates(u);
  for (std::size_t i = 0; i < moving_; ++i) rest[i] -= Qu[i];
  add_point(&result_.normal_identity, {symbols, "sum of the two projections"},
            worst_point_by_M(rest, worst_point_by_M(u, 1.0).error), allowed);
}

void Verifier::verify_both() {
  const double rcond =
      std::min(forms_.tangent->reciprocal_condition_here(), forms_.normal->reciprocal_condition_here());
  const double allowed = conditioned(rcond) + rounding_of_places();
  if (something_sticks_) {
    result_.left_out.push_back("sum of the two projections: S holds contacts that stick, the coordinates do not");
  } else {
    verify_identity("A H^-1 A'M + M^-1 K S^-1 K' = I (9)", allowed);
    verify_identity("M A H^-1 A' + K S^-1 K'M^-1 = I (10)", allowed);
  }

  // K'A x = 0 (3)
  Vector x(work_.coordinates.num_coordinates()), Ax(n_, 0.0), rows(num_rows_);
  for (double& value : x) value = random_.number();
  work_.coordinates.apply(model_.parallel, forms_.tangent->dynamics().blocks().data(), x.data(), Ax.data());
  work_.constraints.apply_transposed(model_.parallel, forms_.normal->linearization().blocks().data(), Ax.data(),
                                     nullptr, rows.data());
  Worst worst;
  const double size_of_Ax = model_.largest_norm(Ax.data());
  for (std::size_t a = 0; a < num_rows_; ++a) {
    if (is_users(a)) worst.see(std::abs(rows[a]) / (row_norms_[user_row(a)] * size_of_Ax), user_row(a));
  }
  add_row(&result_.bases_orthogonal, {"K'A = 0 (3)", "right angle between coordinates and constraints"}, worst,
          1e-11 + rounding_of_places());

  compare_forms();
}

/// Solves by the other form before everything else, so that both are at the answer. Whether the answer is unique is
/// verified with the friction of the form that stepped.
void Verifier::solve_other() {
  other_w_.resize(n_);
  other_eta_.resize(n_);
  const Outcome outcome = forms_.solve_other({answer_.t, answer_.r.data(), answer_.v.data()}, {.exact = true},
                                             other_w_.data(), other_eta_.data());
  if (outcome.ok()) return;
  has_both_ = false;
  result_.checks.push_back({"the other form has an answer: " + outcome.what, Certificate::none, 0.0, ""});
}

void Verifier::compare_forms() {
  Vector &w = other_w_, &eta = other_eta_;
  for (std::size_t i = 0; i < moving_; ++i) {
    w[i] -= answer_.w[i];
    eta[i] = model_.inverse_mass[i / 3] * (eta[i] - answer_.eta[i]);
  }
  const double allowed = 1e-10 + rounding_of_places();
  add_point(&result_.forms_agree, {"w by A = w by K", "accelerations by coordinates and by constraints"},
            worst_point(w, acceleration_), allowed);
  add_point(&result_.forms_agree, {"eta by A = eta by K", "reactions by coordinates and by constraints"},
            worst_point(eta, acceleration_), allowed);
}

}  // namespace tanor::detail
