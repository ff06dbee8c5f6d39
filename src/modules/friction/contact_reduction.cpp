#include "friction/contact_reduction.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tanor::detail {

std::vector<ContactChoice> ContactReduction::list(const ModeSwitch& at, const std::vector<char>& wanted,
                                                  std::size_t most_contacts) const {
  const Tangents& tangents = state_.tangents;
  const FrictionLaws& laws = state_.laws;
  const ContactIslands& islands = friction_.islands();
  std::vector<ContactChoice> result;
  for (std::size_t island = 0; island < islands.size(); ++island) {
    if (wanted[island] == 0) continue;
    ContactChoice choice;
    choice.island = island;
    std::vector<double> before;
    for (const std::size_t c : islands.contacts[island]) {
      if (!laws.is_coulomb(c)) continue;
      const bool moves = at.at_rest[c] == 0;
      const Eigen::Index dimension = moves ? 1 : tangents[c].num_tangents();
      choice.problem.contacts.push_back(
          {static_cast<Eigen::Index>(before.size()), dimension, moves, moves ? laws.coefficient(c) : 0.0});
      choice.members.push_back(c);
      const Vec3 tau = friction_.force(c, state_.system.lambda().data());
      for (Eigen::Index k = 0; k < dimension; ++k) {
        const Vec3 e =
            moves ? laws.part_direction(laws.first_part(c)) : tangents.directions(c)[static_cast<std::size_t>(k)];
        choice.directions.push_back(e);
        before.push_back(dot(tau, e));
      }
    }
    if (choice.members.empty() || choice.size() > most_contacts) continue;
    choice.before = Eigen::Map<const Eigen::VectorXd>(before.data(), static_cast<Eigen::Index>(before.size()));
    result.push_back(std::move(choice));
  }
  return result;
}

void ContactReduction::reduce(const ModeSwitch& at, std::vector<ContactChoice>* choices) {
  Answer answer = solve_without_coulomb(at, choices);
  set_constant_terms(at, answer, choices);
  std::size_t most = 0;
  for (const ContactChoice& choice : *choices) most = std::max(most, choice.directions.size());
  for (std::size_t j = 0; j < most; ++j) set_column(j, choices, &answer);
  for (ContactChoice& choice : *choices) clear_rounding(&choice);
}

/// Computes lambda = -S^-1 b and dw = M^-1 K lambda.
void ContactReduction::solve(const std::vector<double>& b, std::vector<double>* lambda, std::vector<double>* dw) {
  state_.system.response().solve_refined(b.data(), lambda->data(), dw->data());
  state_.system.response().minimize_multiplier_norm(lambda->data());
}

/// Computes w = w0 and b = phi + K'w0 with forces alone. Returns their largest number.
double ContactReduction::evaluate_without_coulomb(const ModeSwitch& at, std::vector<double>* w,
                                                  std::vector<double>* b) {
  Workspace& work = state_.work;
  const Model& model = state_.model;
  const double largest_w = work.evaluate_free(at.t, at.r, at.v, w->data());
  return larger(largest_w,
                work.constraints.evaluate_right_side(model.parallel, at.r, at.v, w->data(), b->data(), nullptr));
}

/// Solves with forces and with the friction laws other than Coulomb's.
ContactReduction::Answer ContactReduction::solve_without_coulomb(const ModeSwitch& at,
                                                                 std::vector<ContactChoice>* choices) {
  const std::size_t size = 3 * state_.model.num_points(), num_rows = state_.model.num_rows();
  Answer answer{std::vector<double>(num_rows), std::vector<double>(size)};
  std::vector<double> b(num_rows), dw(size);
  const double scale = evaluate_without_coulomb(at, &answer.w, &b);
  const std::vector<double>& scales = state_.system.measure_accelerations(answer.w.data(), b.data(), scale);
  for (ContactChoice& choice : *choices) {
    choice.acceleration_scale = 0.0;
    for (const std::size_t contact : choice.members)
      choice.acceleration_scale = std::max(choice.acceleration_scale, scales[state_.neighbourhood(contact)]);
  }
  friction_.set_given(state_.place(at.t, at.r, at.v), state_.system.lambda().data());
  friction_.add(1.0, answer.w.data(), b.data());
  solve(b, &answer.lambda, &dw);
  for (std::size_t i = 0; i < size; ++i) answer.w[i] += dw[i];
  return answer;
}

template <class Column>
void ContactReduction::write_forces(const ContactChoice& choice, const double* lambda, Column&& column) const {
  for (std::size_t c = 0; c < choice.size(); ++c) {
    const Vec3 N = state_.laws.normal_force(choice.members[c], lambda);
    column.template segment<3>(3 * static_cast<Eigen::Index>(c)) << N.x, N.y, N.z;
  }
}

template <class Column>
void ContactReduction::write_accelerations(const ContactChoice& choice, const double* w, Column&& column) const {
  for (std::size_t c = 0; c < choice.size(); ++c) {
    const Vec3 a = load(w, state_.tangents[choice.members[c]].point);
    column.template segment<3>(3 * static_cast<Eigen::Index>(c)) << a.x, a.y, a.z;
  }
}

/// Sets N0, a0 and P0 from an answer without Coulomb friction.
void ContactReduction::set_constant_terms(const ModeSwitch& at, const Answer& answer,
                                          std::vector<ContactChoice>* choices) const {
  constexpr double rounding = 1e-12;
  Workspace& work = state_.work;
  const Model& model = state_.model;
  std::vector<double> rows(model.num_rows());  // T'w + phi
  work.constraints.evaluate_contacts(model.parallel, at.r, at.v, answer.w.data(), Tangents::Which::All, rows.data());
  for (ContactChoice& choice : *choices) {
    const auto m = 3 * static_cast<Eigen::Index>(choice.size()),
               k = static_cast<Eigen::Index>(choice.directions.size());
    ContactProblem& problem = choice.problem;
    problem.A.setZero(k, k);
    problem.W.setZero(m, k);
    problem.a0.setZero(k);
    problem.N0.setZero(m);
    choice.P.setZero(m, k);
    choice.P0.setZero(m);
    write_forces(choice, answer.lambda.data(), problem.N0);
    write_accelerations(choice, answer.w.data(), choice.P0);
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& contact = problem.contacts[c];
      const Tangents::Place& place = state_.tangents[choice.members[c]];
      for (Eigen::Index i = 0; i < contact.dimension; ++i) {
        const auto row = contact.first + i;
        const double a = contact.moves
                             ? dot(choice.directions[static_cast<std::size_t>(row)], load(answer.w.data(), place.point))
                             : rows[static_cast<std::size_t>(place.first_row + i)];
        problem.a0(row) = std::abs(a) > rounding * choice.acceleration_scale ? a : 0.0;
      }
    }
  }
}

/// Computes the responses to one newton along the j-th component of every island. `answer` is scratch space.
void ContactReduction::set_column(std::size_t j, std::vector<ContactChoice>* choices, Answer* answer) {
  const Model& model = state_.model;
  const auto has_column = [&](const ContactChoice& choice) { return j < choice.directions.size(); };
  const auto member_of_column = [&](const ContactChoice& choice) {
    const auto& contacts = choice.problem.contacts;
    std::size_t member = 0;
    while (contacts[member].first + contacts[member].dimension <= static_cast<Eigen::Index>(j)) ++member;
    return choice.members[member];
  };
  std::vector<double> b(model.num_rows(), 0.0);
  for (const ContactChoice& choice : *choices) {
    if (has_column(choice)) friction_.coupling().add_force(member_of_column(choice), choice.directions[j], b.data());
  }
  std::vector<double>& dw = answer->w;
  solve(b, &answer->lambda, &dw);
  for (ContactChoice& choice : *choices) {
    if (!has_column(choice)) continue;
    const auto point = static_cast<std::size_t>(state_.tangents[member_of_column(choice)].point);
    add_to(dw.data(), point, model.inverse_mass[point] * choice.directions[j]);
    const auto column = static_cast<Eigen::Index>(j);
    write_forces(choice, answer->lambda.data(), choice.problem.W.col(column));
    write_accelerations(choice, dw.data(), choice.P.col(column));
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& contact = choice.problem.contacts[c];
      const Vec3 a = load(dw.data(), state_.tangents[choice.members[c]].point);
      for (Eigen::Index i = contact.first; i < contact.first + contact.dimension; ++i)
        choice.problem.A(i, column) = dot(choice.directions[static_cast<std::size_t>(i)], a);
    }
  }
}

/// Symmetrizes A := (A + A')/2, and clears the rows and columns of points that cannot move.
void ContactReduction::clear_rounding(ContactChoice* choice) const {
  Eigen::MatrixXd& A = choice->problem.A;
  A = (0.5 * (A + A.transpose())).eval();
  // The mobility of a point that others hold altogether is rounding.
  constexpr double rounding = 1e-13;
  for (std::size_t c = 0; c < choice->size(); ++c) {
    const auto& contact = choice->problem.contacts[c];
    const auto point = static_cast<std::size_t>(state_.tangents[choice->members[c]].point);
    const double mobility = state_.model.inverse_mass[point];
    for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k) {
      if (std::abs(A(k, k)) > rounding * mobility) continue;
      A.row(k).setZero();
      A.col(k).setZero();
    }
  }
}

void ContactReduction::guess_multipliers(const ModeSwitch& at, const std::vector<ContactChoice>& choices) {
  std::vector<double> w(3 * state_.model.num_points()), b(state_.model.num_rows());
  (void)evaluate_without_coulomb(at, &w, &b);
  friction_.set_given(state_.place(at.t, at.r, at.v), state_.system.lambda().data());
  friction_.add(1.0, w.data(), b.data());
  for (const ContactChoice& choice : choices) {
    for (std::size_t c = 0; choice.has_solution() && c < choice.size(); ++c) {
      const auto& contact = choice.problem.contacts[c];
      for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k) {
        const Vec3 force = choice.x(k) * choice.directions[static_cast<std::size_t>(k)];
        friction_.coupling().add_force(choice.members[c], force, b.data());
      }
    }
  }
  solve(b, &state_.system.lambda(), &w);
}

}  // namespace tanor::detail
