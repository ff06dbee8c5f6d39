#include "statics/equilibrium_equations.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "base/numbers.hpp"
#include "dynamics/prestress_rigidity.hpp"
#include "statics/islands.hpp"

namespace tanor::detail {

namespace {

constexpr double step_of_irregular = 2.3, unknown = std::numeric_limits<double>::quiet_NaN();

/// The rounding error of a sum of forces that cancel is this part of the largest one.
constexpr double rounding_of_cancellation = 64.0 * eps;

/// Replaces each value by the largest one of all points that constraints join.
void spread_largest(const std::vector<int>& joined, std::vector<double>* values) {
  std::vector<double> largest(values->size(), 0.0);
  for (std::size_t i = 0; i < values->size(); ++i) {
    double& own = largest[static_cast<std::size_t>(joined[i])];
    own = larger(own, (*values)[i]);
  }
  for (std::size_t i = 0; i < values->size(); ++i) (*values)[i] = largest[static_cast<std::size_t>(joined[i])];
}

std::vector<double> find_rounding_of_loads(const Model& model, double t, const std::vector<int>& joined) {
  std::vector<double> loads(model.num_points(), 0.0);
  for (const Force& force : model.system.forces) {
    if (const auto* const gravity = std::get_if<Gravity>(&force)) {
      for (std::size_t i = 0; i < loads.size(); ++i) loads[i] += model.mass[i] * norm(make_vec3(gravity->acceleration));
    } else if (const auto* const given = std::get_if<ConstantForce>(&force)) {
      const std::array<Jet<2>, 3> now = given->force(t);
      const double size = norm(Vec3{now[0].value(), now[1].value(), now[2].value()});
      for (const Index point : given->points)
        loads[static_cast<std::size_t>(model.numbering.inner_point[static_cast<std::size_t>(point)])] += size;
    }
  }
  loads.resize(model.num_moving());
  for (double& each : loads) each *= rounding_of_cancellation;
  spread_largest(joined, &loads);
  return loads;
}

}  // namespace

EquilibriumEquations::EquilibriumEquations(Workspace& work, double t, Vec3 spin)
    : work_(work),
      model_(work.model()),
      t_(t),
      extent_(model_.scene_size),
      spin_(spin),
      stiffness_(work),
      joined_(find_joined_points(model_)),
      rounding_of_loads_(find_rounding_of_loads(model_, t, joined_)),
      rounding_(model_.num_moving(), 0.0),
      blur_(model_.num_moving(), 0.0),
      blocks_(3 * work.constraints.num_blocks()),
      f_(3 * model_.num_points()),
      reactions_(3 * model_.num_points()),
      at_rest_(3 * model_.num_points(), 0.0) {}

double EquilibriumEquations::evaluate(const double* r, const double* lambda, double* g, double* xi) {
  work_.set_time(t_);
  const Parallel& parallel = model_.parallel;
  ++work_.counters.evaluations;
  work_.forces.evaluate(parallel, t_, r, at_rest_.data(), f_.data());
  violation_ = work_.constraints.evaluate_values(parallel, r, xi);
  extent_ = std::max(model_.scene_size, model_.largest_norm(r));
  work_.constraints.evaluate_gradients(parallel, r, blocks_.data());
  // g = f + K lambda
  model_.gather.reactions(parallel, blocks_.data(), lambda, reactions_.data());
  double largest = larger(work_.forces.largest_single(parallel, r), std::isfinite(violation_) ? 0.0 : violation_);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const Vec3 force = load(f_.data(), i), sum = force + load(reactions_.data(), i);
    store(g, i, sum);
    largest = larger(largest, norm(force));
    largest = larger(largest, 0.0 * norm(sum));  // is NaN where a reaction is
  }
  for (const Incidence& incidence : model_.incidences) {
    if (static_cast<std::size_t>(incidence.point) < model_.num_moving())
      largest = larger(largest, std::abs(lambda[incidence.row]) * norm(load(blocks_.data(), incidence.block)));
  }
  return largest;
}

void EquilibriumEquations::linearise(const double* r, const double* lambda, StiffnessMatrix::Curvature curvature) {
  work_.set_time(t_);
  work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  stiffness_.evaluate(t_, r, lambda, curvature);
  for (std::size_t i = 0; i < rounding_.size(); ++i)
    rounding_[i] = rounding_of_cancellation * stiffness_.largest_of(i) * std::max(model_.scene_size, norm(load(r, i)));
  spread_largest(joined_, &rounding_);
  for (std::size_t i = 0; i < rounding_.size(); ++i) rounding_[i] += rounding_of_loads_[i];
  std::ranges::fill(blur_, 0.0);
}

void EquilibriumEquations::linearise_near(const double* r, const double* lambda, double error) {
  if (error == 0.0) return linearise(r, lambda);
  std::vector<double> near(r, r + 3 * model_.num_points());
  disturb(error, near.data());
  linearise(near.data(), lambda);
  const std::vector<double> there = stiffness_.sum_rows();
  linearise(r, lambda);
  const std::vector<double> here = stiffness_.sum_rows();
  for (std::size_t i = 0; i < blur_.size(); ++i) blur_[i] = std::abs(there[i] - here[i]);
}

Eigen::SparseMatrix<double> EquilibriumEquations::find_coriolis() const {
  const auto size = static_cast<Eigen::Index>(this->size());
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < size; i += 3) {
    const double twice = 2.0 * model_.mass[static_cast<std::size_t>(i / 3)];
    const auto add = [&](Eigen::Index row, Eigen::Index column, double value) {
      entries.emplace_back(i + row, i + column, twice * value);
      entries.emplace_back(i + column, i + row, -twice * value);
    };
    add(2, 1, spin_.x);
    add(0, 2, spin_.y);
    add(1, 0, spin_.z);
  }
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

Eigen::VectorXd EquilibriumEquations::masses() const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(size()));
  for (std::size_t i = 0; i < size(); ++i) result[static_cast<Eigen::Index>(i)] = model_.mass[i / 3];
  return result;
}

void EquilibriumEquations::disturb(double by, double* r) const {
  for (std::size_t i = 0; i < size(); ++i) r[i] += by * irregular(i, step_of_irregular);
}

void EquilibriumEquations::forget_idle_multipliers(const double* r, std::vector<double>* lambda) {
  work_.forces.evaluate(model_.parallel, t_, r, at_rest_.data(), f_.data());
  std::vector<char> is_loaded(joined_.size(), 0);
  const auto own = [&](std::size_t point) { return static_cast<std::size_t>(joined_[point]); };
  for (std::size_t i = 0; i < joined_.size(); ++i) {
    if (norm(load(f_.data(), i)) > 0.0) is_loaded[own(i)] = 1;
  }
  for (const Incidence& incidence : model_.incidences) {
    const auto point = static_cast<std::size_t>(incidence.point);
    if (point < joined_.size() && is_loaded[own(point)] == 0) (*lambda)[static_cast<std::size_t>(incidence.row)] = 0.0;
  }
}

void EquilibriumEquations::write_forces(const std::vector<double>& lambda, std::vector<double>* multipliers,
                                        std::vector<double>* reactions, std::vector<double>* support_forces) const {
  const Numbering& numbering = model_.numbering;
  const std::size_t size = 3 * model_.num_points(), moving = 3 * model_.num_moving();
  std::vector<double> eta(size), loads(size, 0.0);
  model_.gather.reactions(model_.parallel, blocks_.data(), lambda.data(), eta.data());
  for (std::size_t i = moving; i < size; ++i) loads[i] = eta[i] + f_[i];
  for (const auto& [inner, user] : {std::pair(&eta, reactions), {&loads, support_forces}}) {
    user->resize(size);
    numbering.scatter_points(*inner, *user);
  }
  multipliers->resize(numbering.num_user_rows);
  numbering.scatter_rows(lambda, *multipliers);

  std::vector<char> is_rigid(model_.num_points(), 0), is_unknown(model_.num_rows(), 0);
  for (const Support& support : model_.system.supports)
    for (const Index point : support.points)
      is_rigid[static_cast<std::size_t>(numbering.inner_point[static_cast<std::size_t>(point)])] =
          support.name == rigid_points_name;
  for (const Incidence& incidence : model_.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row);
    if (row >= numbering.first_idle_row() && is_rigid[static_cast<std::size_t>(incidence.point)] != 0)
      is_unknown[row] = 1;
  }
  for (const Incidence& incidence : model_.incidences) {
    const auto row = static_cast<std::size_t>(incidence.row);
    if (is_unknown[row] == 0) continue;
    (*multipliers)[static_cast<std::size_t>(numbering.user_row[row])] = unknown;
    const auto point = static_cast<std::ptrdiff_t>(numbering.user_point[static_cast<std::size_t>(incidence.point)]);
    for (std::vector<double>* each : {reactions, support_forces}) std::fill_n(each->begin() + 3 * point, 3, unknown);
  }
}

void EquilibriumEquations::add_reactions(const double* lambda, double* y) const {
  std::vector<double> all(3 * model_.num_points());
  model_.gather.reactions(model_.parallel, blocks_.data(), lambda, all.data());
  for (std::size_t i = 0; i < size(); ++i) y[i] += all[i];
}

void EquilibriumEquations::apply_transposed(const double* x, double* rows) const {
  std::vector<double> all(3 * model_.num_points(), 0.0);  // supports do not move
  std::copy_n(x, size(), all.begin());
  work_.constraints.apply_transposed(model_.parallel, blocks_.data(), all.data(), nullptr, rows);
}

}  // namespace tanor::detail
