#include "certificate/verifier.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "evaluate/energy_definitions.hpp"
#include "system/members.hpp"

namespace tanor {

Verifier::Verifier(Forms& forms, const Answer& answer, SecondWay way)
    : forms_(forms),
      work_(forms.work),
      model_(forms.model),
      answer_(answer),
      way_(way),
      n_(3 * model_.num_points()),
      moving_(3 * model_.num_moving()),
      d_(model_.numbering.num_user_rows),
      num_rows_(model_.num_rows()),
      has_friction_(model_.has_friction()),
      something_sticks_(work_.constraints.tangents().num_sticking() > 0) {
  work_.set_time(answer.t);
  measure_scale();
  inverse_sine_ = measure_angles();
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

// ---- words ----

/// Accelerations are measured by the largest of w, M^-1 f, M^-1 tau and M^-1 eta in the neighbourhood.
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

void Verifier::add(double* figure, const std::string& identity, double error, double allowed,
                   const std::string& where) {
  if (std::isnan(*figure) || !(error <= *figure)) *figure = error;
  result_.checks.push_back({identity, error, std::min(allowed, fewest_digits), where});
}

void Verifier::add_row(double* figure, const std::string& identity, const Worst& worst, double allowed) {
  const std::string where = worst.error > 0.0 ? equation_name(model_.system, worst.index) : "";
  add(figure, identity, worst.error, allowed, where);
}

void Verifier::add_point(double* figure, const std::string& identity, const Worst& worst, double allowed) {
  const std::string where =
      worst.error > 0.0 ? "point " + text(model_.numbering.user_point[worst.index]) : std::string();
  add(figure, identity, worst.error, allowed, where);
}

Verifier::Worst Verifier::worst_point(const Vector& difference, double scale) const {
  Worst worst;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) worst.see(norm(load(difference.data(), i)) / scale, i);
  return worst;
}

Verifier::Worst Verifier::worst_point(const Vector& difference, const Vector& scale) const {
  Worst worst;
  for (std::size_t i = 0; i < model_.num_moving(); ++i)
    worst.see(norm(load(difference.data(), i)) / at_point(scale, i), i);
  return worst;
}

Verifier::Worst Verifier::worst_point_by_M(const Vector& difference, double scale) const {
  Worst worst;
  for (std::size_t i = 0; i < model_.num_moving(); ++i)
    worst.see(std::sqrt(model_.mass[i]) * norm(load(difference.data(), i)) / scale, i);
  return worst;
}

Verifier::Vector Verifier::to_user(const Vector& inner) const {
  Vector user(n_);
  model_.numbering.scatter_points(inner, user);
  return user;
}

Verifier::Vector Verifier::inner_rows(const Vector& user) const {
  Vector inner(num_rows_, 0.0);
  for (std::size_t a = 0; a < num_rows_; ++a) {
    if (is_users(a)) inner[a] = user[user_row(a)];
  }
  return inner;
}

/// splitmix64 (G. L. Steele, D. Lea, C. H. Flood 2014)
double Verifier::random_number() {
  std::uint64_t z = random_ += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return 0x1p-63 * static_cast<double>(static_cast<std::int64_t>(z ^ (z >> 31)));
}

Verifier::Vector Verifier::random_points_by_M() {
  Vector u = random_points();
  for (std::size_t i = 0; i < moving_; ++i) u[i] *= std::sqrt(model_.inverse_mass[i / 3]);
  return u;
}

Verifier::Vector Verifier::random_points() {
  Vector u(n_, 0.0);
  for (std::size_t i = 0; i < moving_; ++i) u[i] = random_number();
  return u;
}

double Verifier::product(const Vector& x, const Vector& y) const {
  return model_.parallel.sum(model_.num_moving(),
                             [&](std::size_t i) { return model_.mass[i] * dot(load(x.data(), i), load(y.data(), i)); });
}

double Verifier::norm_of(const Vector& x) const {
  return std::sqrt(product(x, x));
}

double Verifier::rounding_of_places() const {
  return 1e2 * eps * std::max({1.0, model_.largest_norm(answer_.r.data()) / model_.smallest_length, inverse_sine_});
}

/// 1/sin of the angle that is nearest to straight: across its arms its points are known to so much less.
double Verifier::measure_angles() const {
  double smallest = 1.0;
  const auto place = [&](Index point) {
    return load(answer_.r.data(), model_.numbering.inner_point[static_cast<std::size_t>(point)]);
  };
  for (const Constraint& constraint : model_.system.constraints) {
    const auto* const angles = std::get_if<Angles>(&constraint);
    if (angles == nullptr) continue;
    for (const auto& [i, j, k] : angles->triples) {
      const Vec3 a = place(i) - place(j), b = place(k) - place(j);
      smallest = std::min(smallest, norm(cross(a, b)) / (norm(a) * norm(b)));
    }
  }
  return 1.0 / std::max(smallest, eps);
}

/// Neither constraints nor coordinates: M w = f.
/// Energies of tuples by their second definition.
void Verifier::verify_energies() {
  Vector found(n_), wanted(n_), rest(n_, 0.0);
  work_.forces.energies().write_forces(found.data());
  model_.numbering.gather_points(find_defined_forces(model_.system, answer_.t, to_user(answer_.r)), wanted);
  for (std::size_t i = 0; i < moving_; ++i) rest[i] = model_.inverse_mass[i / 3] * (found[i] - wanted[i]);
  add_point(&result_.residual, "f = -dU/dr", worst_point(rest, acceleration_), 1e-10 + rounding_of_places());
}

void Verifier::verify_free() {
  Vector rest(n_, 0.0);
  for (std::size_t i = 0; i < moving_; ++i) rest[i] = answer_.w[i] - w0_[i];
  add_point(&result_.residual, "M w = f", worst_point(rest, acceleration_), 1e-14);
}

}  // namespace tanor
