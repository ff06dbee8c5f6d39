#include "cli/cost.hpp"

namespace tanor::cli {

namespace {

// Measured on chains and nets of 1e4 to 1e6 rods, one thread (bench/): passes over points and rods, and the speed of
// CHOLMOD's numeric factorization.
constexpr double seconds_per_point = 40e-9;
constexpr double seconds_per_equation = 60e-9;
constexpr double simplicial_flops = 0.6e9;
constexpr double supernodal_flops = 10e9;

int count_solves(Method method) {
  switch (method) {
    case Method::Rk4:
      return 4;
    case Method::Rattle:
      return 1;
    case Method::Auto:
    case Method::Dopri5:
      break;
  }
  return 6;  // the seventh stage is the first one of the next step
}

}  // namespace

Method choose_method(const MotionOptions& motion) {
  if (motion.method != Method::Auto) return motion.method;
  return motion.step > 0.0 ? Method::Rk4 : Method::Dopri5;
}

StepCost predict_step(const PlanSummary& plan, std::size_t num_points, Method method) {
  const double speed = plan.factorization.find("supernodal") != std::string::npos ? supernodal_flops : simplicial_flops;
  const double points = static_cast<double>(num_points), equations = static_cast<double>(plan.equations);
  const double factor_nonzeros = static_cast<double>(plan.factor_nonzeros);

  StepCost cost;
  cost.solves = count_solves(method);
  // One pass over the points and rows, one factorization, one forward and one back substitution (4 flops a nonzero).
  const double pass = points * seconds_per_point + equations * seconds_per_equation;
  cost.seconds = cost.solves * (pass + (plan.factor_flops + 4.0 * factor_nonzeros) / speed);
  // L and S with 4-byte indices; about 20 state vectors of 3n.
  cost.bytes = 12.0 * (factor_nonzeros + static_cast<double>(plan.pattern_nonzeros)) + 20.0 * 24.0 * points;
  return cost;
}

}  // namespace tanor::cli
