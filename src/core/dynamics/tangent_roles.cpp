#include "dynamics/tangent_roles.hpp"

namespace tanor::detail {

Kinematics TangentFeatures::find_points(const Kinematics& at, double* r, double* v) {
  const double t_before = work_.time();
  work_.set_time(at.t);
  work_.prescribe_all(at.t, r, v);
  work_.coordinates.evaluate(work_.model().parallel, at.x, at.v, r, v, nullptr, nullptr);
  work_.set_time(t_before);
  return {at.t, r, v};
}

// ---- events ----

void TangentEvents::evaluate_events(const Kinematics& at, const Reactions& found, double* values) {
  others().evaluate_events({at.t, linearization_.r().data(), linearization_.v().data()}, found, values);
}

Outcome TangentEvents::switch_equations(double t, const double* q, double* q_dot, std::span<const std::size_t> which,
                                        const Request& request, const AccelerationOutput& to) {
  linearization_.evaluate(t, q, q_dot, false);
  std::vector<double> v = linearization_.v(), w(v.size());
  Outcome outcome =
      others().switch_equations(t, linearization_.r().data(), v.data(), which, request, {w.data(), nullptr, to.report});
  if (outcome.ok()) outcome = linearization_.find_rates(t, v.data(), q, q_dot);
  return outcome.ok() ? dynamics_.solve({t, q, q_dot}, request, to) : outcome;
}

}  // namespace tanor::detail
