#include "certificate/answer_measures.hpp"

namespace tanor::detail {

AnswerMeasures::AnswerMeasures(Forms& forms, const Answer& answer)
    : forms_(forms),
      work_(forms.work),
      model_(forms.model),
      answer_(answer),
      n_(3 * model_.num_points()),
      moving_(3 * model_.num_moving()),
      d_(model_.numbering.num_user_rows),
      num_rows_(model_.num_rows()),
      inverse_sine_(measure_angles()) {}

AnswerMeasures::Vector AnswerMeasures::to_user(const Vector& inner) const {
  Vector user(n_);
  model_.numbering.scatter_points(inner, user);
  return user;
}

AnswerMeasures::Vector AnswerMeasures::inner_rows(const Vector& user) const {
  Vector inner(num_rows_, 0.0);
  for (std::size_t a = 0; a < num_rows_; ++a) {
    if (is_users(a)) inner[a] = user[user_row(a)];
  }
  return inner;
}

double AnswerMeasures::product(const Vector& x, const Vector& y) const {
  return model_.parallel.sum(model_.num_moving(),
                             [&](std::size_t i) { return model_.mass[i] * dot(load(x.data(), i), load(y.data(), i)); });
}

double AnswerMeasures::norm_of(const Vector& x) const {
  return std::sqrt(product(x, x));
}

double AnswerMeasures::rounding_of_places() const {
  return 1e2 * eps * std::max({1.0, model_.largest_norm(answer_.r.data()) / model_.smallest_length, inverse_sine_});
}

/// Returns 1/sin of the angle that is nearest to straight. Across its arms its points are known less exactly by this
/// factor.
double AnswerMeasures::measure_angles() const {
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

}  // namespace tanor::detail
