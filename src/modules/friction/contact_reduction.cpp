#include <algorithm>
#include <cmath>
#include <utility>

#include "friction/contact_choices.hpp"

namespace tanor::detail {

namespace {

/// The responses of islands to forces at their contacts, with all other unknowns eliminated.
class Reduction {
 public:
  Reduction(const ContactState& state, FrictionSolver& friction, const ModeSwitch& at)
      : state_(state),
        model_(state.model),
        friction_(friction),
        at_(at),
        lambda_(model_.num_rows()),
        w_(3 * model_.num_points()),
        b_(model_.num_rows()) {}

  /// Computes w = w0 + M^-1 tau and b = phi + K'w with forces and with the friction laws other than Coulomb's. Calls
  /// see(largest number of both) before friction is added.
  template <class See>
  void evaluate_without_coulomb(const See& see);
  /// Computes lambda = -S^-1 b and dw = M^-1 K lambda.
  void solve(std::vector<double>* lambda, std::vector<double>* dw) {
    state_.system.response().solve_refined(b_.data(), lambda->data(), dw->data());
    state_.system.response().minimize_multiplier_norm(lambda->data());
  }
  void set_constant_terms(std::vector<ContactChoice>* choices);
  void set_column(std::size_t j, std::vector<ContactChoice>* choices);
  void guess_multipliers(const std::vector<ContactChoice>& choices);

 private:
  void add_force(const ContactChoice& choice, std::size_t member, Eigen::Index component, double size) {
    const Vec3 force = size * choice.directions[static_cast<std::size_t>(component)];
    friction_.coupling().add_force(choice.members[member], force, b_.data());
  }
  /// Writes [3 contacts] the reactions of the contacts at the last lambda, and the accelerations of their points at w.
  template <class Column>
  void write(const ContactChoice& choice, Column&& forces, Column&& accelerations) const {
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const Vec3 N = state_.laws.normal_force(choice.members[c], lambda_.data());
      const Vec3 a = load(w_.data(), state_.tangents[choice.members[c]].point);
      forces.template segment<3>(3 * static_cast<Eigen::Index>(c)) << N.x, N.y, N.z;
      accelerations.template segment<3>(3 * static_cast<Eigen::Index>(c)) << a.x, a.y, a.z;
    }
  }

  const ContactState& state_;
  const Model& model_;
  FrictionSolver& friction_;
  const ModeSwitch& at_;
  std::vector<double> lambda_, w_, b_;  // [rows], [3n], [rows]
};

template <class See>
void Reduction::evaluate_without_coulomb(const See& see) {
  Workspace& work = state_.work;
  const double largest_w = work.evaluate_free(at_.t, at_.r, at_.v, w_.data());
  see(larger(largest_w,
             work.constraints.evaluate_right_side(model_.parallel, at_.r, at_.v, w_.data(), b_.data(), nullptr)));
  friction_.set_given(state_.place(at_.t, at_.r, at_.v), state_.system.lambda().data());
  friction_.add(1.0, w_.data(), b_.data());
}

/// Sets N0, a0 and P0 from the answer without Coulomb friction.
void Reduction::set_constant_terms(std::vector<ContactChoice>* choices) {
  constexpr double rounding = 1e-12;
  evaluate_without_coulomb([&](double scale) {
    const std::vector<double>& scales = state_.system.measure_accelerations(w_.data(), b_.data(), scale);
    for (ContactChoice& choice : *choices) {
      choice.acceleration_scale = 0.0;
      for (const std::size_t contact : choice.members)
        choice.acceleration_scale = std::max(choice.acceleration_scale, scales[state_.neighbourhood(contact)]);
    }
  });
  std::vector<double> dw(w_.size()), rows(model_.num_rows());  // rows: T'w + phi
  solve(&lambda_, &dw);
  for (std::size_t i = 0; i < w_.size(); ++i) w_[i] += dw[i];
  state_.work.constraints.evaluate_contacts(model_.parallel, at_.r, at_.v, w_.data(), Tangents::Which::All,
                                            rows.data());
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
    write(choice, problem.N0, choice.P0);
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& contact = problem.contacts[c];
      const Tangents::Place& place = state_.tangents[choice.members[c]];
      for (Eigen::Index i = 0; i < contact.dimension; ++i) {
        const auto row = contact.first + i;
        const double a = contact.moves
                             ? dot(choice.directions[static_cast<std::size_t>(row)], load(w_.data(), place.point))
                             : rows[static_cast<std::size_t>(place.first_row + i)];
        problem.a0(row) = std::abs(a) > rounding * choice.acceleration_scale ? a : 0.0;
      }
    }
  }
}

/// Computes the responses to one newton along the j-th component of every island.
void Reduction::set_column(std::size_t j, std::vector<ContactChoice>* choices) {
  const auto column = static_cast<Eigen::Index>(j);
  const auto has_column = [&](const ContactChoice& choice) { return j < choice.directions.size(); };
  const auto member_of_column = [&](const ContactChoice& choice) {
    const auto& contacts = choice.problem.contacts;
    std::size_t member = 0;
    while (contacts[member].first + contacts[member].dimension <= column) ++member;
    return member;
  };
  std::fill(b_.begin(), b_.end(), 0.0);
  for (const ContactChoice& choice : *choices) {
    if (has_column(choice)) add_force(choice, member_of_column(choice), column, 1.0);
  }
  solve(&lambda_, &w_);
  for (ContactChoice& choice : *choices) {
    if (!has_column(choice)) continue;
    const auto point = static_cast<std::size_t>(state_.tangents[choice.members[member_of_column(choice)]].point);
    add_to(w_.data(), point, model_.inverse_mass[point] * choice.directions[j]);
    write(choice, choice.problem.W.col(column), choice.P.col(column));
    for (std::size_t c = 0; c < choice.size(); ++c) {
      const auto& contact = choice.problem.contacts[c];
      const Vec3 a = load(w_.data(), state_.tangents[choice.members[c]].point);
      for (Eigen::Index i = contact.first; i < contact.first + contact.dimension; ++i)
        choice.problem.A(i, column) = dot(choice.directions[static_cast<std::size_t>(i)], a);
    }
  }
}

void Reduction::guess_multipliers(const std::vector<ContactChoice>& choices) {
  evaluate_without_coulomb([](double) {});
  for (const ContactChoice& choice : choices) {
    for (std::size_t c = 0; choice.has_solution() && c < choice.size(); ++c) {
      const auto& contact = choice.problem.contacts[c];
      for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k)
        add_force(choice, c, k, choice.x(k));
    }
  }
  solve(&state_.system.lambda(), &w_);
}

/// Symmetrizes A := (A + A')/2, and clears the rows and columns of points that cannot move.
void clear_rounding(const ContactState& state, ContactChoice* choice) {
  Eigen::MatrixXd& A = choice->problem.A;
  A = (0.5 * (A + A.transpose())).eval();
  // The mobility of a point that others hold altogether is rounding.
  constexpr double rounding = 1e-13;
  for (std::size_t c = 0; c < choice->size(); ++c) {
    const auto& contact = choice->problem.contacts[c];
    const auto point = static_cast<std::size_t>(state.tangents[choice->members[c]].point);
    const double mobility = state.model.inverse_mass[point];
    for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k) {
      if (std::abs(A(k, k)) > rounding * mobility) continue;
      A.row(k).setZero();
      A.col(k).setZero();
    }
  }
}

}  // namespace

std::vector<ContactChoice> list_islands(const ContactState& state, const FrictionSolver& friction, const ModeSwitch& at,
                                        const std::vector<char>& wanted, std::size_t most_contacts) {
  const Tangents& tangents = state.tangents;
  const FrictionLaws& laws = state.laws;
  const ContactIslands& islands = friction.islands();
  std::vector<ContactChoice> result;
  for (std::size_t island = 0; island < islands.size(); ++island) {
    if (wanted[island] == 0) continue;
    ContactChoice choice;
    choice.island = island;
    std::vector<double> before;
    for (const std::size_t c : islands.contacts[island]) {
      if (!laws.is_coulomb(c) || tangents.is_open(c)) continue;
      const bool moves = at.at_rest[c] == 0;
      const Eigen::Index dimension = moves ? 1 : tangents[c].num_tangents();
      choice.problem.contacts.push_back(
          {static_cast<Eigen::Index>(before.size()), dimension, moves, moves ? laws.coefficient(c) : 0.0});
      choice.problem.outward.push_back(outward(tangents, c));
      choice.members.push_back(c);
      const Vec3 tau = friction.force(c, state.system.lambda().data());
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

void reduce_islands(const ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                    std::vector<ContactChoice>* choices) {
  Reduction reduction(state, friction, at);
  reduction.set_constant_terms(choices);
  std::size_t most = 0;
  for (const ContactChoice& choice : *choices) most = std::max(most, choice.directions.size());
  for (std::size_t j = 0; j < most; ++j) reduction.set_column(j, choices);
  for (ContactChoice& choice : *choices) clear_rounding(state, &choice);
}

void guess_multipliers(const ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                       const std::vector<ContactChoice>& choices) {
  Reduction(state, friction, at).guess_multipliers(choices);
}

}  // namespace tanor::detail
