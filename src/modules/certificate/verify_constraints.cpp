#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "certificate/verifier.hpp"
#include "dynamics/split.hpp"
#include "system/members.hpp"

/// \file Verifies what constraints must satisfy, by their second definition, and the projector of S.
namespace tanor::detail {

void Verifier::verify_constraints() {
  Definitions definitions(model_.system, forms_.start_time());
  user_r_ = to_user(answer_.r);
  K_.resize(3 * work_.constraints.num_blocks());
  work_.constraints.evaluate_gradients(model_.parallel, answer_.r.data(), K_.data());
  work_.clear_contacts(K_.data());
  row_norms_ = measure_rows(Vector(model_.num_points(), 1.0));
  {
    const Vector user_v = to_user(answer_.v);
    measure_cancellation(definitions);
    scale_ = measure_curvature(definitions, user_v);
    for (std::size_t k = 0; k < scale_.size(); ++k) scale_[k] = std::max(scale_[k], acceleration_[k]);
    verify_equations(definitions, user_v);
    verify_branch(definitions, user_v);
  }
  if (forms_.tangent == nullptr) {
    verify_normal_projector(definitions);
    verify_by_second_factor();
  }
  verify_split();
  verify_euclidean(definitions);
  if (has_friction_) verify_friction(definitions);
}

void Verifier::verify_equations(const Definitions& definitions, const Vector& user_v) {
  const double rounding = rounding_of_places();

  // K'w + phi: the second derivative of xi along r + e v + e^2/2 w
  Vector xi(d_), rate(d_), second(d_);
  definitions.taylor(model_.parallel, answer_.t, user_r_, user_v, to_user(answer_.w), xi, rate, second);
  Worst worst;
  for (std::size_t a = 0; a < num_rows_; ++a) {
    if (!is_users(a)) continue;
    const std::size_t row = user_row(a);
    worst.see(std::abs(second[row]) / (row_norms_[row] * scale_[work_.scales.of_row(a)]), row);
  }
  add_row(&result_.residual, {"K'w + phi = 0", "constraints of accelerations"}, worst, 1e-10 + rounding);

  // M w = f + tau + K lambda
  Vector lambda(d_), K_lambda(n_), inner(n_);
  model_.numbering.scatter_rows(answer_.lambda, lambda);
  turn_pairs_of_lines(definitions, &lambda);
  definitions.reactions(answer_.t, user_r_, lambda, K_lambda);
  model_.numbering.gather_points(K_lambda, inner);
  Vector rest(n_, 0.0);
  for (std::size_t i = 0; i < moving_; ++i) {
    rest[i] = answer_.w[i] - w0_[i] - model_.inverse_mass[i / 3] * inner[i];
  }
  // If constraints depend on each other, their forces are larger than their sum, which rounds accordingly.
  Vector terms(model_.num_points(), 0.0);
  for (const Incidence& incidence : model_.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row), point = static_cast<std::size_t>(incidence.point);
    const auto user_row = static_cast<std::size_t>(model_.numbering.user_row[row]);
    if (user_row < d_)
      terms[point] += model_.inverse_mass[point] * std::abs(answer_.lambda[row]) * row_norms_[user_row];
  }
  Vector cancelled = scale_;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    double& own = cancelled[work_.scales.of_point(i)];
    own = std::max(own, terms[i]);
  }
  add_point(&result_.residual, {"M w = " + given_force() + " + K lambda", "Newton's law"}, worst_point(rest, cancelled),
            1e-10 + rounding);

  verify_power(definitions, user_v, lambda, K_lambda);
}

/// Verifies by values of xi alone that the motion r + s v + s^2/2 w stays on a user's constraints, for s > 0 or for s <
/// 0: in a corner the derivatives at r may be those of a branch that it does not follow.
void Verifier::verify_branch(const Definitions& definitions, const Vector& user_v) {
  const auto is_users = [](const Constraint& group) { return std::holds_alternative<UserConstraints>(group); };
  if (std::ranges::none_of(model_.system.constraints, is_users)) return;
  constexpr double part = 1e-5;  // of the time to cross a length
  const Vector user_w = to_user(answer_.w);
  const double speed = model_.largest_norm(answer_.v.data()), acceleration = model_.largest_norm(answer_.w.data());
  const double crossing = model_.smallest_length / std::max(speed, std::sqrt(model_.smallest_length * acceleration));
  const double s = part * crossing, way = s * (speed + 0.5 * s * acceleration);
  if (!(std::isfinite(s) && way > 0.0)) return;
  Vector here(d_), rate(d_), second(d_), least(d_, std::numeric_limits<double>::infinity());
  definitions.taylor(model_.parallel, answer_.t, user_r_, user_v, user_w, here, rate, second);
  try {
    for (const double step : {-s, s}) {
      Vector moved = user_r_, xi(d_);
      for (std::size_t i = 0; i < n_; ++i) moved[i] += step * (user_v[i] + 0.5 * step * user_w[i]);
      definitions.taylor(model_.parallel, answer_.t + step, moved, user_v, user_w, xi, rate, second);
      for (std::size_t a = 0; a < d_; ++a) least[a] = std::min(least[a], std::abs(xi[a] - here[a]));
    }
  } catch (const InputError&) {
    return;  // a table ends there
  }
  Worst worst;
  std::size_t row = 0;
  for (const Constraint& group : model_.system.constraints) {
    const auto [members, rows_per_member] = shape_of(group);
    for (std::size_t k = 0; k < members * rows_per_member; ++k, ++row)
      if (is_users(group)) worst.see(least[row] / (row_norms_[row] * way), row);
  }
  if (!(worst.error > fewest_digits)) worst.error = 0.0;  // it tells yes or no, and nothing about digits
  add_row(&result_.residual, {"xi(r + s v + s^2/2 w) = 0", "path along the constraints"}, worst, fewest_digits);
}

/// Numbers the rows of lines that turn: 1 at the first line of a point, 2 at the next one, and 0 at all other rows.
std::vector<std::size_t> Verifier::number_turning_lines() const {
  std::vector<std::size_t> number(d_, 0), count(model_.num_points(), 0);
  std::size_t row = 0;
  for (const Constraint& constraint : model_.system.constraints) {
    const auto [members, rows_per_member] = shape_of(constraint);
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (requires { KindOf<Group>::turning; }) {
            if ((group.*KindOf<Group>::turning).is_constant()) return;
            for (std::size_t k = 0; k < members; ++k) {
              const auto point = static_cast<std::size_t>(member_points(group, k)[0]);
              std::fill_n(number.begin() + static_cast<std::ptrdiff_t>(row + k * rows_per_member), rows_per_member,
                          ++count[point]);
            }
          }
        },
        constraint);
    row += members * rows_per_member;
  }
  return number;
}

/// Expresses the pairs of lines that turn by the definitions' unit vectors, which are a convention and may differ. What
/// a pair carries, K lambda at its point, is decomposed along theirs. Lines at one point have their turns.
void Verifier::turn_pairs_of_lines(const Definitions& definitions, Vector* lambda) const {
  const std::vector<std::size_t> number = number_turning_lines();
  const std::size_t most = number.empty() ? 0 : *std::ranges::max_element(number);
  for (std::size_t turn = 1; turn <= most; ++turn) {
    Vector carried(n_, 0.0), along(d_);
    for (const Incidence& i : model_.incidences) {
      const std::size_t row = user_row(static_cast<std::size_t>(i.row));
      if (row >= d_ || number[row] != turn) continue;
      const double factor = i.sign * answer_.lambda[static_cast<std::size_t>(i.row)];
      store(carried.data(), i.point, load(carried.data(), i.point) + factor * load(K_.data(), i.block));
    }
    definitions.transposed(model_.parallel, answer_.t, user_r_, to_user(carried), along);
    for (std::size_t a = 0; a < d_; ++a) {
      if (number[a] == turn) (*lambda)[a] = along[a];
    }
  }
}

/// Returns |W^1/2 column of K| of each of the user's rows, with the weights W of the points.
Verifier::Vector Verifier::measure_rows(const Vector& weights) const {
  Vector inner(num_rows_, 0.0), result(d_);
  for (const Incidence& incidence : model_.incidences) {
    const Vec3 g = load(K_.data(), incidence.block);
    inner[static_cast<std::size_t>(incidence.row)] += weights[static_cast<std::size_t>(incidence.point)] * dot(g, g);
  }
  model_.numbering.scatter_rows(inner, result);
  for (double& x : result) x = x > 0.0 ? std::sqrt(x) : 1.0;
  return result;
}

/// Returns the maximum of |phi|/|gradient| in each neighbourhood, with phi along r + e v and the prescribed motion of
/// supports.
Verifier::Vector Verifier::measure_curvature(const Definitions& definitions, const Vector& user_v) {
  Vector given(n_, 0.0), xi(d_), rate(d_);
  work_.write_support_accelerations(answer_.t, given.data());
  phi_.resize(d_);
  definitions.taylor(model_.parallel, answer_.t, user_r_, user_v, to_user(given), xi, rate, phi_);
  Vector worst(work_.scales.size(), 0.0);
  for (std::size_t a = 0; a < num_rows_; ++a) {
    if (!is_users(a)) continue;
    double& own = worst[work_.scales.of_row(a)];
    own = std::max(own, std::abs(phi_[user_row(a)]) / row_norms_[user_row(a)]);
  }
  return worst;
}

/// Raises scales of accelerations to where the rounding of phi is small. Along straight lines phi is a difference of
/// terms as large as for velocities that are turned by a right angle.
void Verifier::measure_cancellation(const Definitions& definitions) {
  constexpr double cancels = 1e-2;  // 1e-12 of a scale are then some roundings of these terms
  const Vec3 axis = (1.0 / std::sqrt(14.0)) * Vec3{1.0, 2.0, 3.0};
  Vector turned(n_);
  for (std::size_t i = 0; i < n_ / 3; ++i) {
    const Vec3 v = load(answer_.v.data(), i);
    store(turned.data(), i, cross(axis, v) + dot(axis, v) * axis);
  }
  const Vector terms = measure_curvature(definitions, to_user(turned));
  for (std::size_t k = 0; k < terms.size(); ++k) acceleration_[k] = std::max(acceleration_[k], cancels * terms[k]);
}

/// Verifies eta'v + lambda'xi_t = 0 over all points, including supports.
void Verifier::verify_power(const Definitions& definitions, const Vector& user_v, const Vector& lambda,
                            const Vector& eta) {
  Vector xi_t(d_, 0.0);
  if (work_.constraints.depends_on_time()) {
    const Vector zero(n_, 0.0);
    Vector xi(d_), second(d_);
    definitions.taylor(model_.parallel, answer_.t, user_r_, zero, zero, xi, xi_t, second);
  }
  double sum = 0.0, size = 0.0;
  for (std::size_t i = 0; i < n_ / 3; ++i) {
    sum += dot(load(eta.data(), i), load(user_v.data(), i));
    size += norm(load(eta.data(), i)) * std::max(norm(load(user_v.data(), i)), work_.velocity_scale * 1e-3);
  }
  for (std::size_t a = 0; a < d_; ++a) {
    sum += lambda[a] * xi_t[a];
    size += std::abs(lambda[a] * xi_t[a]);
  }
  // Velocities satisfy K'v + xi_t = 0 to the tolerance of their projection.
  add(&result_.power_balance, {"eta'v = -lambda'xi_t", "power of the constraints"},
      size > 0.0 ? std::abs(sum) / size : 0.0, 1e-9, "");
}

/// Returns Q u = u - M^-1 K S^-1 K'u.
Verifier::Vector Verifier::project_onto_tangent(const Vector& u) {
  Vector result = u;
  Linearization& linearization = forms_.normal->linearization();
  project(
      linearization.blocks(), model_.inverse_mass, nullptr, most_passes(rcond_of_S_),
      [&](double* rows) { linearization.solve_negative(rows, rows); }, &result);
  return result;
}

Verifier::Worst Verifier::rows_of(const Definitions& definitions, const Vector& u, const Vector& row_norms,
                                  double size) const {
  Vector rows(d_);
  definitions.transposed(model_.parallel, answer_.t, user_r_, to_user(u), rows);
  Worst worst;
  for (std::size_t a = 0; a < d_; ++a) worst.see(std::abs(rows[a]) / (row_norms[a] * size), a);
  return worst;
}

/// Verifies the projector Q, which is orthogonal in the norm |M^1/2 .|. Errors are measured in it, whatever the masses.
void Verifier::verify_normal_projector(const Definitions& definitions) {
  const double allowed = conditioned(rcond_of_S_) + rounding_of_places();
  const Vector u = random_.points_by_M(), Qu = project_onto_tangent(u);
  const double size = worst_point_by_M(u, 1.0).error;

  add_row(&result_.normal_identity, {"K'Q u = 0", "projection along the constraints"},
          rows_of(definitions, Qu, measure_rows(model_.inverse_mass), size), allowed);

  Vector rest = project_onto_tangent(Qu);
  for (std::size_t i = 0; i < n_; ++i) rest[i] -= Qu[i];
  add_point(&result_.normal_identity, {"Q Q u = Q u", "projection that is done twice"}, worst_point_by_M(rest, size),
            allowed);

  const Vector y = random_.points_by_M(), Qy = project_onto_tangent(y);
  const double asymmetry = std::abs(product(y, Qu) - product(u, Qy)) / (norm_of(u) * norm_of(y));
  add(&result_.normal_identity, {"y'M Q u = u'M Q y", "symmetry of the projection"}, asymmetry, allowed, "");
}

/// With equal masses w_T lies in T and w_N in N: verifies w_T'M w_N = 0 with w_N = -K Gamma^-1 phi, Gamma = m S (36).
void Verifier::verify_split() {
  if (!has_one_mass(model_)) return;
  if (something_sticks_) {
    result_.left_out.push_back("right angle between tangent and normal acceleration: S holds contacts that stick");
    return;
  }
  // S x = -phi; w_N = M^-1 K x, since K Gamma^-1 = K (m S)^-1
  Vector x = inner_rows(phi_), w_N(n_, 0.0), w_T(n_, 0.0);
  forms_.normal->linearization().solve_negative(x.data(), x.data());
  model_.gather.add_scaled(model_.parallel, forms_.normal->linearization().blocks().data(), x.data(),
                           model_.inverse_mass.data(), model_.num_moving(), w_N.data());
  for (std::size_t i = 0; i < moving_; ++i) w_T[i] = answer_.w[i] - w_N[i];
  // Without forces w_T is rounding of w_N, so that both are measured by the larger of w and M^-1 f.
  const double size = std::max(product(answer_.w, answer_.w), product(w0_, w0_));
  const double rcond = rcond_of_S_;
  add(&result_.orthogonality, {"w_T'M w_N = 0", "right angle between tangent and normal acceleration"},
      size > 0.0 ? std::abs(product(w_T, w_N)) / size : 0.0, conditioned(rcond) + rounding_of_places(), "");
}

}  // namespace tanor::detail
