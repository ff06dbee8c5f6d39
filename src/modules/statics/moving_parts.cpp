#include "statics/moving_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <variant>

#include "base/numbers.hpp"
#include "system/members.hpp"

namespace tanor::detail {

MovingParts::MovingParts(const System& system, double t)
    : system_(system), t_(t), work_(system, {}, 0.0), model_(work_.model()), r_(3 * model_.num_points()) {
  model_.numbering.gather_points(system.positions, r_);
  std::vector<double> v(r_.size());
  work_.prescribe_all(t, r_.data(), v.data());
  for (std::size_t i = 0; i < model_.num_points(); ++i)
    centre_ = centre_ + (1.0 / static_cast<double>(model_.num_points())) * load(r_.data(), i);
  std::vector<int> inner(model_.numbering.num_user_rows, -1);
  for (std::size_t a = 0; a < model_.num_rows(); ++a) {
    const auto row = static_cast<std::size_t>(model_.numbering.user_row[a]);
    if (row < inner.size()) inner[row] = static_cast<int>(a);
  }
  std::size_t next = 0;
  for_each_member(system, [&](std::span<const Index>, int rows) {
    const auto first = inner.begin() + static_cast<std::ptrdiff_t>(next);
    members_.emplace_back(first, first + rows);
    next += static_cast<std::size_t>(rows);
  });
}

MovingParts::Configuration MovingParts::place(const SteadyFrame& frame, double tau, const Disturbance& by) {
  Configuration result{tau, r_, std::vector<double>(r_.size(), 0.0)};
  for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i)
    result.r[i] += by.part * size() * irregular(i + by.number * r_.size());
  for (std::size_t i = 0; i < model_.num_moving(); ++i)
    store(result.r.data(), i, frame.carry(load(result.r.data(), i), tau));
  work_.set_time(t_ + tau);
  work_.prescribe_all(t_ + tau, result.r.data(), result.prescribed.data());
  return result;
}

Eigen::VectorXd MovingParts::find_rates(const SteadyFrame& frame, const Configuration& at) {
  const std::size_t n = model_.num_points();
  std::vector<double> v(3 * n), result;
  for (std::size_t i = 0; i < n; ++i) store(v.data(), i, frame.velocity_at(load(at.r.data(), i), at.tau));
  add_members(at, v, &result);
  for (std::size_t i = 3 * model_.num_moving(); i < 3 * n; ++i) result.push_back(v[i] - at.prescribed[i]);
  add_forces(frame, at, v, &result);
  for (double& rate : result) rate = std::isfinite(rate) ? rate : 0.0;
  return Eigen::Map<Eigen::VectorXd>(result.data(), static_cast<Eigen::Index>(result.size()));
}

void MovingParts::add_members(const Configuration& at, const std::vector<double>& v, std::vector<double>* rates) {
  std::vector<double> xi(model_.num_rows()), xi_rates(model_.num_rows()), squares(model_.num_rows(), 0.0),
      blocks(3 * work_.constraints.num_blocks());
  work_.set_time(t_ + at.tau);
  (void)work_.constraints.evaluate_values(model_.parallel, at.r.data(), xi.data());
  (void)work_.constraints.evaluate_rates(model_.parallel, at.r.data(), v.data(), xi_rates.data());
  work_.constraints.evaluate_gradients(model_.parallel, at.r.data(), blocks.data());
  for (const Incidence& incidence : model_.incidences)
    squares[static_cast<std::size_t>(incidence.row)] += squared(load(blocks.data(), incidence.block));
  for (const std::vector<int>& rows : members_) {
    double product = 0.0, distance2 = 0.0;
    for (const int a : rows) {
      const auto row = static_cast<std::size_t>(a);
      product += xi[row] * xi_rates[row] / squares[row];
      distance2 += xi[row] * xi[row] / squares[row];
    }
    rates->push_back(distance2 > 0.0 ? product / std::sqrt(distance2) : 0.0);
  }
}

/// Adds f' - Omega x f over |f| and times the scene's size, and dU/dt over |grad U|, both along the frame's velocities.
void MovingParts::add_forces(const SteadyFrame& frame, const Configuration& at, const std::vector<double>& v,
                             std::vector<double>* rates) const {
  const double t = t_ + at.tau;
  for (const Force& force : system_.forces) {
    if (const auto* const given = std::get_if<ConstantForce>(&force); given != nullptr && !given->force.is_constant()) {
      const std::array<Jet<2>, 3> now = given->force(t);
      const Vec3 f{now[0].value(), now[1].value(), now[2].value()},
          rate{now[0].derivative(1), now[1].derivative(1), now[2].derivative(1)}, rest = rate - cross(frame.spin, f);
      for (const double each : {rest.x, rest.y, rest.z}) rates->push_back(size() * each / norm(f));
    }
    const auto* const potential = std::get_if<Potential>(&force);
    if (potential == nullptr || !potential->kernel.depends_on_time) continue;
    for (std::size_t tuple = 0; tuple < potential->points.size(); ++tuple)
      rates->push_back(find_rate_of_level(*potential, tuple, t, at.r, v));
  }
}

/// Returns the speed at which the level of the energy that a tuple is on leaves it.
double MovingParts::find_rate_of_level(const Potential& potential, std::size_t tuple, double t,
                                       const std::vector<double>& at, const std::vector<double>& velocities) const {
  const std::vector<Index>& points = potential.points[tuple];
  std::vector<double> r(3 * points.size()), v(r.size()), gradient(r.size()), constants;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Index inner = model_.numbering.inner_point[static_cast<std::size_t>(points[i])];
    store(r.data(), i, load(at.data(), inner));
    store(v.data(), i, load(velocities.data(), inner));
  }
  for (const std::vector<double>& each : potential.constants) constants.push_back(each[each.size() == 1 ? 0 : tuple]);
  double energy = 0.0, rate = 0.0, slope2 = 0.0;
  potential.kernel.evaluate(potential.kernel.context.get(), {.count = 1,
                                                             .t = t,
                                                             .r = r.data(),
                                                             .constants = constants.data(),
                                                             .energy = &energy,
                                                             .gradient = gradient.data(),
                                                             .rate = &rate});
  for (std::size_t i = 0; i < r.size(); ++i) {
    rate += gradient[i] * v[i];
    slope2 += gradient[i] * gradient[i];
  }
  return rate / std::sqrt(slope2);
}

}  // namespace tanor::detail
