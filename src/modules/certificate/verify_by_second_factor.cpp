#include <algorithm>
#include <cmath>

#include "certificate/verifier.hpp"
#include "dynamics/split.hpp"

/// \file Verifies by additional factorizations: w and lambda once more, and Gamma = K'K for the Euclidean split
/// and the direct problem.
namespace tanor::detail {

/// Computes w and lambda once more from scratch by the second factor of S, refined in w.
void Verifier::verify_by_second_factor() {
  second_.emplace(model_, K_.data(), model_.inverse_mass, forms_.normal->orderings(), second_factorization_);
  if (!second_->trouble().empty()) {
    result_.left_out.push_back("second factorization: " + second_->trouble());
    second_.reset();
    return;
  }
  Vector w(n_, 0.0), lambda(num_rows_, 0.0), phi = inner_rows(phi_);
  std::copy_n(w0_.begin(), moving_, w.begin());
  // rho = K'w + phi, with the prescribed motion of supports in phi; lambda -= S^-1 rho, w -= M^-1 K S^-1 rho
  project(
      K_, model_.inverse_mass, phi.data(), 1 + most_passes(rcond_of_S_),
      [&](double* rows) { second_->solve_negative(rows); }, &w, &lambda);
  for (std::size_t i = 0; i < moving_; ++i) w[i] -= answer_.w[i];
  // Both solutions have the same rounded positions; each is refined in w.
  add_point(&result_.second_factorization,
            {std::string("w by ") + second_->name() + " = w", "accelerations by a second factorization"},
            worst_point(w, scale_), refined(rcond_of_S_) + rounding_of_places());
  compare_multipliers(lambda);
}

/// Compares multipliers. Their effect K lambda is always unique. The multipliers themselves may lose digits by the
/// condition of S, and are compared in rows where they are unique.
void Verifier::compare_multipliers(const Vector& lambda) {
  Vector difference(num_rows_, 0.0), dw(n_, 0.0);
  for (std::size_t a = 0; a < num_rows_; ++a) {
    if (is_users(a)) difference[a] = answer_.lambda[a] - lambda[a];
  }
  model_.gather.write_scaled(model_.parallel, K_.data(), difference.data(), model_.inverse_mass.data(),
                             model_.num_moving(), dw.data());
  const double rounding = rounding_of_places();
  add_point(&result_.second_factorization,
            {std::string("K lambda by ") + second_->name() + " = K lambda",
             "forces of the constraints by a second factorization"},
            worst_point(dw, scale_), refined(rcond_of_S_) + rounding);

  const std::vector<bool> is_unique = forms_.normal->linearization().dependences().report().multipliers_unique;
  const Vector& lengths = second_->lengths();  // |M^-1/2 k|; lengths times lambda are accelerations
  Vector size = scale_;
  for (std::size_t a = 0; a < num_rows_; ++a) {
    double& own = size[work_.scales.of_row(a)];
    own = std::max(own, lengths[a] * std::abs(lambda[a]));
  }
  Worst worst;
  for (std::size_t a = 0; a < num_rows_; ++a) {
    const std::size_t row = user_row(a);
    if (row < d_ && is_unique[row]) worst.see(lengths[a] * std::abs(difference[a]) / size[work_.scales.of_row(a)], row);
  }
  add_row(&result_.second_factorization,
          {std::string("lambda by ") + second_->name() + " = lambda", "multipliers by a second factorization"}, worst,
          (1e-12 + rounding) / rcond_of_S_);
}

// ---- the Euclidean split ----

/// Returns u_T = u - K Gamma^-1 K'u.
Verifier::Vector Verifier::tangent_part(const Vector& u) {
  Vector result = u;
  project(
      K_, euclidean_->weights(), nullptr, most_passes(euclidean_->reciprocal_condition()),
      [&](double* rows) { euclidean_->solve_negative(rows); }, &result);
  return result;
}

/// Verifies u = u_T + u_N (15), (16).
void Verifier::verify_euclidean(const Definitions& definitions) {
  euclidean_.emplace(model_, K_, *forms_.normal, second_factorization_, second_ ? &*second_ : nullptr, rcond_of_S_);
  if (!euclidean_->trouble().empty()) {
    result_.left_out.push_back("projector onto the tangent space, motion from the given forces: " +
                               euclidean_->trouble());
    return;
  }
  const double condition = euclidean_->reciprocal_condition();
  const double allowed = conditioned(condition) + rounding_of_places();
  const Vector u = random_.points(), u_T = tangent_part(u);
  const double size = model_.largest_norm(u.data());
  if (has_both_) {
    verify_both_euclidean(u, u_T);
  } else {
    // K'u_T = 0 makes K Gamma^-1 K' idempotent, u_T'u_N = 0 makes it orthogonal.
    double dot_product = 0.0, square = 0.0;
    for (std::size_t i = 0; i < moving_; ++i) {
      dot_product += u_T[i] * (u[i] - u_T[i]);
      square += u[i] * u[i];
    }
    add_row(&result_.tangent_identity, {"K'(I - K Gamma^-1 K')u = 0 (15)", "projector onto the tangent space"},
            rows_of(definitions, u_T, row_norms_, size), allowed);
    add(&result_.tangent_identity, {"u_T'u_N = 0 (16)", "right angle between tangent and normal part"},
        std::abs(dot_product) / square, allowed, "");
  }
  verify_direct_problem(refined(condition) + rounding_of_places());
}

/// Verifies A G^-1 A'u + K Gamma^-1 K'u = u (15).
void Verifier::verify_both_euclidean(const Vector& u, const Vector& u_T) {
  Vector unit(model_.inverse_mass);
  for (double& weight : unit) weight = weight > 0.0 ? 1.0 : 0.0;
  GramSolver g(work_.coordinates.list_products(unit),
               {work_.coordinates.island_start(), work_.coordinates.num_coordinates()}, Ordering::Auto);
  const Vector& A = forms_.tangent->dynamics().blocks();
  g.assemble(model_.parallel, A.data());
  const GramSolver::Quality quality = g.factorize(model_.parallel);
  if (!quality.positive_definite) {
    result_.left_out.push_back("sum of the two projectors: A'A is singular to rounding");
    return;
  }
  Vector x(work_.coordinates.num_coordinates()), sum(n_, 0.0);
  work_.coordinates.apply_transposed(model_.parallel, A.data(), u.data(), x.data());
  g.solve_negative(model_.parallel, x.data(), x.data());
  work_.coordinates.apply(model_.parallel, A.data(), x.data(), sum.data());  // -A G^-1 A'u
  for (std::size_t i = 0; i < moving_; ++i) sum[i] += u_T[i];
  const double rcond = std::min(quality.reciprocal_condition, euclidean_->reciprocal_condition());
  add_point(&result_.tangent_identity, {"A G^-1 A' + K Gamma^-1 K' = I (15)", "sum of the two projectors"},
            worst_point(sum, model_.largest_norm(u.data())), conditioned(rcond) + rounding_of_places());
}

/// Verifies the forces from the motion: K Gamma^-1 K'(M w - f - tau) is eta, and nothing is left of M w - f - tau for a
/// control force. Errors are relative to the largest force of the neighbourhood.
void Verifier::verify_direct_problem(double allowed) {
  Vector force(n_, 0.0);
  Vector largest(work_.scales.size(), 0.0);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const Vec3 w = load(answer_.w.data(), i), w0 = load(w0_.data(), i);
    store(force.data(), i, model_.mass[i] * (w - w0));
    double& own = largest[work_.scales.of_point(i)];
    own = std::max({own, model_.mass[i] * norm(w), model_.mass[i] * norm(w0)});
  }
  const Vector left = tangent_part(tangent_part(force));
  for (double& own : largest) own = own > 0.0 ? own : 1.0;
  Vector rest(n_, 0.0);
  for (std::size_t i = 0; i < moving_; ++i) rest[i] = force[i] - left[i] - answer_.eta[i];
  add_point(&result_.residual,
            {"(M w" + given_force(" - ") + ")_T = 0, the direct problem", "motion from the given forces"},
            worst_point(left, largest), allowed);
  add_point(&result_.residual,
            {"K Gamma^-1 K'(M w" + given_force(" - ") + ") = eta, the direct problem", "reactions from the motion"},
            worst_point(rest, largest), allowed);
}

}  // namespace tanor::detail
