#include "simulation/reaction_decomposition.hpp"

#include <algorithm>
#include <string>

namespace tanor::detail {

namespace {

/// Separates a function quadratic in a velocity, phi(v) = quadratic + rest, by phi(v), phi(-v) and phi(0).
struct Terms {
  std::vector<double> quadratic, rest;

  Terms(const std::vector<double>& at_v, const std::vector<double>& at_minus_v, const std::vector<double>& at_0)
      : quadratic(at_v.size()), rest(at_v.size()) {
    for (std::size_t a = 0; a < at_v.size(); ++a) {
      quadratic[a] = 0.5 * (at_v[a] + at_minus_v[a]) - at_0[a];
      rest[a] = at_v[a] - quadratic[a];
    }
  }
};

std::vector<double> negative(const double* x, std::size_t size) {
  std::vector<double> result(size);
  std::transform(x, x + size, result.begin(), [](double each) { return -each; });
  return result;
}

}  // namespace

ReactionDecomposition::ReactionDecomposition(Forms& forms) : forms_(forms), work_(forms.work), model_(forms.model) {
  System alone = model_.system;
  for (const Force& force : model_.system.forces) {
    alone.forces = {force};
    forces_.push_back(std::make_unique<Forces>(alone, model_.numbering));
  }
}

template <class Use>
void ReactionDecomposition::for_each_force(double t, const double* r, const double* v, const Use& use) {
  std::vector<double> f(3 * model_.num_points());
  for (std::size_t k = 0; k < forces_.size(); ++k) {
    forces_[k]->evaluate(model_.parallel, t, r, v, f.data());
    use(force_name(model_.system, k), f);
  }
}

std::vector<ReactionPart> ReactionDecomposition::find(double t, const double* r, const double* v, const double* q,
                                                      const double* q_dot) {
  return forms_.normal != nullptr ? find_by_constraints(t, r, v) : find_by_coordinates(t, r, v, q, q_dot);
}

std::vector<ReactionPart> ReactionDecomposition::find_by_constraints(double t, const double* r, const double* v) {
  std::vector<ReactionPart> result;
  const auto add_force = [&](const std::string& name, const std::vector<double>& f) {
    result.push_back(find_part(name, r, apply_transposed_to_forces(f)));
  };
  for_each_force(t, r, v, add_force);
  if (model_.has_friction()) {
    std::vector<double> tau(3 * model_.num_points());
    forms_.normal->contacts()->write_given(tau.data());
    add_force("friction", tau);
  }
  add_inertia_and_drive(t, r, v, &result);
  return result;
}

/// Solves S lambda = -b for one part of the reaction.
ReactionPart ReactionDecomposition::find_part(std::string cause, const double* r, const std::vector<double>& b) {
  Linearization& linearization = forms_.normal->linearization();
  const std::size_t size = 3 * model_.num_points();
  std::vector<double> lambda(model_.num_rows()), dw(size), eta(size);
  linearization.solve_refined(b.data(), lambda.data(), dw.data());
  linearization.minimize_multiplier_norm(r, lambda.data());
  for (std::size_t a = 0; a < lambda.size(); ++a) {
    if (model_.numbering.is_contact_row(a)) lambda[a] = 0.0;
  }
  model_.gather.reactions(model_.parallel, linearization.blocks().data(), lambda.data(), eta.data());
  ReactionPart part{std::move(cause), std::vector<double>(model_.numbering.num_user_rows), std::vector<double>(size)};
  model_.numbering.scatter_rows(lambda, part.multipliers);
  model_.numbering.scatter_points(eta, part.reactions);
  return part;
}

/// Returns b = K'M^-1 f.
std::vector<double> ReactionDecomposition::apply_transposed_to_forces(const std::vector<double>& f) {
  std::vector<double> w0(f.size(), 0.0);
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) w0[i] = model_.inverse_mass[i / 3] * f[i];
  return apply_transposed(w0, nullptr);
}

/// Returns K'w + rest, or K'w if `rest` is null.
std::vector<double> ReactionDecomposition::apply_transposed(const std::vector<double>& w, const double* rest) {
  std::vector<double> b(model_.num_rows());
  if (!b.empty()) {
    work_.constraints.apply_transposed(model_.parallel, forms_.normal->linearization().blocks().data(), w.data(), rest,
                                       b.data());
  }
  return b;
}

void ReactionDecomposition::add_inertia_and_drive(double t, const double* r, const double* v,
                                                  std::vector<ReactionPart>* result) {
  const std::size_t size = 3 * model_.num_points();
  const std::vector<double> nothing(size, 0.0), minus_v = negative(v, size);
  const auto phi = [&](const double* velocities) {
    std::vector<double> rows(model_.num_rows());
    work_.constraints.evaluate_right_side(model_.parallel, r, velocities, nothing.data(), rows.data(), nullptr);
    return rows;
  };
  const std::vector<double> whole = phi(v);
  if (!model_.is_rheonomic()) {
    result->push_back(find_part("inertia", r, whole));
    return;
  }
  const Terms terms(whole, phi(minus_v.data()), phi(nothing.data()));
  result->push_back(find_part("inertia", r, terms.quadratic));
  // adds K_s'a_s, the accelerations of supports
  std::vector<double> given(nothing);
  work_.write_support_accelerations(t, given.data());
  result->push_back(find_part("drive", r, apply_transposed(given, terms.rest.data())));
}

std::vector<ReactionPart> ReactionDecomposition::find_by_coordinates(double t, const double* r, const double* v,
                                                                     const double* q, const double* q_dot) {
  const std::size_t size = 3 * model_.num_points(), moving = 3 * model_.num_moving();
  std::vector<ReactionPart> result;
  std::vector<double> eta(size), force(size, 0.0);
  // eta = [I - M A H^-1 A'] (M psi - f) (24); the part of psi in T does not enter.
  const auto add = [&](std::string cause) {
    forms_.tangent->dynamics().completed().find_reactions(force.data(), eta.data());
    ReactionPart part{std::move(cause), {}, std::vector<double>(size)};
    model_.numbering.scatter_points(eta, part.reactions);
    result.push_back(std::move(part));
  };
  for_each_force(t, r, v, [&](const std::string& name, const std::vector<double>& f) {
    for (std::size_t i = 0; i < moving; ++i) force[i] = -f[i];
    add(name);
  });

  const std::size_t s = work_.coordinates.num_coordinates();
  const auto psi = [&](const double* rates) {
    std::vector<double> places(r, r + size), velocities(v, v + size), result_psi(size, 0.0);
    work_.write_support_accelerations(t, result_psi.data());
    work_.coordinates.evaluate(model_.parallel, q, rates, places.data(), velocities.data(), result_psi.data(), nullptr);
    return result_psi;
  };
  const std::vector<double> rest(s, 0.0), minus_q_dot = negative(q_dot, s), whole = psi(q_dot);
  const Terms terms(whole, psi(minus_q_dot.data()), psi(rest.data()));
  const auto weigh = [&](const std::vector<double>& accelerations) {
    for (std::size_t i = 0; i < moving; ++i) force[i] = model_.mass[i / 3] * accelerations[i];
  };
  if (!model_.is_rheonomic()) {
    weigh(whole);
    add("inertia");
    return result;
  }
  weigh(terms.quadratic);
  add("inertia");
  weigh(terms.rest);
  add("drive");
  return result;
}

}  // namespace tanor::detail
