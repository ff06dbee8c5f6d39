#include "contact/rough_islands.hpp"

#include <algorithm>
#include <cmath>

#include "system/contacts.hpp"

namespace tanor::detail {

RoughIslands::RoughIslands(Workspace& work, ConstrainedSystem& system, const Groups<Incidence>& arms)
    : work_(work),
      model_(work.model()),
      system_(system),
      arms_(arms),
      contact_of_row_(model_.numbering.one_sided.size(), RoughContact::none),
      island_of_row_(contact_of_row_) {
  const Tangents& tangents = work.constraints.tangents();
  const std::vector<OneSidedRow>& rows = model_.numbering.one_sided;
  std::vector<std::size_t> number(model_.numbering.num_islands(), RoughContact::none);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Index row = tangents[c].guide_row[0];
    const auto found = std::ranges::lower_bound(rows, row, {}, &OneSidedRow::row);
    contact_of_row_[static_cast<std::size_t>(found - rows.begin())] = c;
    std::size_t& own = number[model_.numbering.island_of(row)];
    if (own == RoughContact::none) {
      own = rows_.size();
      rows_.emplace_back();
    }
    island_of_contact_.push_back(own);
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    island_of_row_[k] = number[model_.numbering.island_of(rows[k].row)];
    if (island_of_row_[k] != RoughContact::none) rows_[island_of_row_[k]].push_back(k);
  }
}

void RoughIslands::measure(const double* r, const double* v, std::span<const char> take_part) {
  Constraints& constraints = work_.constraints;
  const Tangents& tangents = constraints.tangents();
  const std::vector<double> nothing(3 * model_.num_points(), 0.0);
  blocks_.assign(3 * constraints.num_blocks(), 0.0);
  std::vector<double> bias(model_.num_rows()), tangent_bias(bias);
  constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  constraints.evaluate_right_side(model_.parallel, r, v, nothing.data(), bias.data(), nullptr);
  constraints.evaluate_contacts(model_.parallel, r, v, nothing.data(), Tangents::Which::All, tangent_bias.data());
  measured_.clear();
  for (std::size_t island = 0; island < rows_.size(); ++island) {
    RoughProblem problem{.island = island};
    for (const std::size_t k : rows_[island]) {
      if (take_part[k] == 0) continue;
      RoughContact contact{.row = k, .contact = contact_of_row_[k]};
      double squares = 0.0;
      for (const Incidence& arm : arms_[k]) {
        const Vec3 g = load(blocks_.data(), arm.block);
        squares += dot(g, g);
        contact.mobility = std::max(contact.mobility, model_.inverse_mass[static_cast<std::size_t>(arm.point)]);
      }
      contact.gradient = std::sqrt(squares);
      contact.bias[0] = sign(k) * bias[inner_row(k)] / contact.gradient;
      if (contact.has_friction()) {
        const Tangents::Place& place = tangents[contact.contact];
        for (std::size_t i = 0; i < 2; ++i)
          contact.bias[i + 1] = tangent_bias[static_cast<std::size_t>(place.first_row) + i];
        contact.mu = static_coefficient_of(model_.system.friction[static_cast<std::size_t>(place.friction)]);
        contact.tangents = tangents.directions(contact.contact);
      }
      problem.contacts.push_back(contact);
    }
    if (problem.size() > 0) measured_.push_back(std::move(problem));
  }
}

/// Adds the accelerations of the points by a force along a component, w += M^-1 H e size.
void RoughIslands::push(const RoughContact& contact, int component, double size, double* w) const {
  const auto add = [&](std::size_t point, Vec3 force) { add_to(w, point, model_.inverse_mass[point] * force); };
  if (component > 0) {
    const auto point = static_cast<std::size_t>(work_.constraints.tangents()[contact.contact].point);
    return add(point, size * contact.tangents[static_cast<std::size_t>(component - 1)]);
  }
  const double factor = size * sign(contact.row) / contact.gradient;
  for (const Incidence& arm : arms_[contact.row])
    add(static_cast<std::size_t>(arm.point), arm.sign * factor * load(blocks_.data(), arm.block));
}

/// Returns H'x along a component.
double RoughIslands::pull(const RoughContact& contact, int component, const double* x) const {
  if (component > 0) {
    const Index point = work_.constraints.tangents()[contact.contact].point;
    return dot(contact.tangents[static_cast<std::size_t>(component - 1)], load(x, point));
  }
  double sum = 0.0;
  for (const Incidence& arm : arms_[contact.row])
    sum += arm.sign * dot(load(blocks_.data(), arm.block), load(x, arm.point));
  return sign(contact.row) / contact.gradient * sum;
}

void RoughIslands::respond(double* w) {
  b_.assign(model_.num_rows(), 0.0);
  lambda_.assign(model_.num_rows(), 0.0);
  dw_.assign(3 * model_.num_points(), 0.0);
  (void)work_.constraints.apply_transposed(model_.parallel, system_.blocks().data(), w, nullptr, b_.data());
  system_.response().solve_refined(b_.data(), lambda_.data(), dw_.data());
  model_.add_to_moving(dw_.data(), w);
}

/// Turns the tangents of a contact to the principal axes of its mobility, so that a direction in which other
/// constraints hold it is one of them.
static void turn_tangents(std::size_t c, RoughProblem* problem) {
  RoughContact& contact = problem->contacts[c];
  const Eigen::Index i = 3 * static_cast<Eigen::Index>(c) + 1;
  Eigen::MatrixXd& W = problem->W;
  if (!contact.has_friction() || W(i, i + 1) == 0.0) return;
  const double angle = 0.5 * std::atan2(2.0 * W(i, i + 1), W(i, i) - W(i + 1, i + 1));
  Eigen::Matrix2d turn;
  turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  W.middleRows<2>(i) = (turn.transpose() * W.middleRows<2>(i)).eval();
  W.middleCols<2>(i) = (W.middleCols<2>(i) * turn).eval();
  const auto [t, s] = contact.tangents;
  const auto [n, a, b] = contact.bias;
  contact.tangents = {turn(0, 0) * t + turn(1, 0) * s, turn(0, 1) * t + turn(1, 1) * s};
  contact.bias = {n, turn(0, 0) * a + turn(1, 0) * b, turn(0, 1) * a + turn(1, 1) * b};
}

std::vector<RoughProblem> RoughIslands::reduce() {
  constexpr double rounding = 1e-13;  // The mobility of a point that others hold altogether is rounding.
  std::size_t most = 0;
  for (RoughProblem& problem : measured_) {
    const auto size = 3 * static_cast<Eigen::Index>(problem.size());
    problem.W.setZero(size, size);
    problem.q.setZero(size);
    most = std::max(most, problem.size());
  }
  // Islands do not affect each other, so that one solve serves a component of each.
  std::vector<double> w(3 * model_.num_points());
  for (std::size_t c = 0; c < most; ++c) {
    for (int component = 0; component < 3; ++component) {
      const auto has_it = [&](const RoughProblem& problem) {
        return c < problem.size() && (component == 0 || problem.contacts[c].has_friction());
      };
      if (std::ranges::none_of(measured_, has_it)) continue;
      std::ranges::fill(w, 0.0);
      for (const RoughProblem& problem : measured_)
        if (has_it(problem)) push(problem.contacts[c], component, 1.0, w.data());
      respond(w.data());
      for (RoughProblem& problem : measured_) {
        if (!has_it(problem)) continue;
        for (std::size_t other = 0; other < problem.size(); ++other) {
          for (int k = 0; k < (problem.contacts[other].has_friction() ? 3 : 1); ++k)
            problem.W(3 * static_cast<Eigen::Index>(other) + k, 3 * static_cast<Eigen::Index>(c) + component) =
                pull(problem.contacts[other], k, w.data());
        }
      }
    }
  }
  for (RoughProblem& problem : measured_) {
    Eigen::MatrixXd& W = problem.W;
    W = (0.5 * (W + W.transpose())).eval();
    for (std::size_t c = 0; c < problem.size(); ++c) turn_tangents(c, &problem);
    for (Eigen::Index i = 0; i < W.rows(); ++i) {
      if (std::abs(W(i, i)) > rounding * problem.contacts[static_cast<std::size_t>(i / 3)].mobility) continue;
      W.row(i).setZero();
      W.col(i).setZero();
    }
  }
  return measured_;
}

void RoughIslands::set_velocities(const double* r, const double* v, std::vector<RoughProblem>* problems) const {
  std::vector<double> rates(model_.num_rows());
  const Constraints& constraints = work_.constraints;
  const Tangents& tangents = constraints.tangents();
  (void)constraints.evaluate_rates(model_.parallel, constraints.select(model_.numbering.may_open), r, v, rates.data());
  for (RoughProblem& problem : *problems) {
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const RoughContact& contact = problem.contacts[c];
      auto own = problem.q.segment<3>(3 * static_cast<Eigen::Index>(c));
      own.setZero();
      own(0) = sign(contact.row) * rates[inner_row(contact.row)] / contact.gradient;
      if (!contact.has_friction()) continue;
      const Vec3 u = load(v, tangents[contact.contact].point) - tangents.own_velocity(contact.contact).value;
      for (int k = 0; k < 2; ++k) own(k + 1) = dot(contact.tangents[static_cast<std::size_t>(k)], u);
    }
  }
}

void RoughIslands::set_accelerations(double t, const double* r, const double* v, std::vector<RoughProblem>* problems) {
  std::vector<double> w(3 * model_.num_points()), b(model_.num_rows()), lambda(model_.num_rows()), dw(w.size());
  (void)work_.evaluate_free(t, r, v, w.data());
  (void)work_.constraints.evaluate_right_side(model_.parallel, r, v, w.data(), b.data(), nullptr);
  system_.response().solve_refined(b.data(), lambda.data(), dw.data());
  model_.add_to_moving(dw.data(), w.data());
  for (RoughProblem& problem : *problems) {
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const RoughContact& contact = problem.contacts[c];
      auto own = problem.q.segment<3>(3 * static_cast<Eigen::Index>(c));
      own.setZero();
      for (int k = 0; k < (contact.has_friction() ? 3 : 1); ++k)
        own(k) = pull(contact, k, w.data()) + contact.bias[static_cast<std::size_t>(k)];
    }
  }
}

std::vector<double> RoughIslands::strike(const std::vector<RoughProblem>& problems,
                                         const std::vector<Eigen::VectorXd>& P, double* v) {
  std::vector<double> w(3 * model_.num_points(), 0.0);
  for (std::size_t k = 0; k < problems.size(); ++k) {
    for (Eigen::Index i = 0; i < P[k].size(); ++i)
      if (P[k](i) != 0.0)
        push(problems[k].contacts[static_cast<std::size_t>(i / 3)], static_cast<int>(i % 3), P[k](i), w.data());
  }
  respond(w.data());
  model_.add_to_moving(w.data(), v);
  return lambda_;
}

Eigen::VectorXd RoughIslands::forces(const RoughProblem& problem, const double* lambda,
                                     const std::vector<double>& friction) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(problem.size()));
  for (std::size_t c = 0; c < problem.size(); ++c) {
    const RoughContact& contact = problem.contacts[c];
    auto own = result.segment<3>(3 * static_cast<Eigen::Index>(c));
    own(0) = sign(contact.row) * lambda[inner_row(contact.row)] * contact.gradient;
    if (!contact.has_friction()) continue;
    const Vec3 tau = load(friction.data(), contact.contact);
    for (int k = 0; k < 2; ++k) own(k + 1) = dot(contact.tangents[static_cast<std::size_t>(k)], tau);
  }
  return result;
}

}  // namespace tanor::detail
