#include "cli/cost.hpp"

namespace tanor::cli {

namespace {

// One thread of a 2.6 GHz EPYC, bench/phases, minima over chains of 1e4 and 3e5 rods and nets of 30^2 to 300^2 beads:
// evaluate, assemble and reactions take 15 to 25 ns an equation; the formula gives 0.6 to 1.1 of a factorization and
// 0.8 (chains) to 3.4 (small nets) of a solve. The time per point is from whole runs: of steps of chains, nets and a
// melt, each method, the formula gives 0.8 to 1.6.
constexpr double seconds_per_point = 15e-9;  // forces, sums of vectors
constexpr double seconds_per_equation = 20e-9;
constexpr double factor_seconds_per_nonzero = 10e-9;
constexpr double factor_flops = 5e9;
constexpr double solve_seconds_per_nonzero = 5e-9;

int count_solves(Method method) {
  switch (method) {
    case Method::Rk4:
      return 4;
    case Method::Rattle:
      return 1;
    case Method::Rattle4:
      return 5;
    case Method::Rattle6:
      return 9;
    case Method::Dopri5:
      return 6;  // the seventh stage is the first one of the next step
    case Method::Taylor:
      return 14;  // with the usual tolerances; but one factorization
    case Method::Radau5:
      return 10;
    case Method::GeneralizedAlpha:
      return 3;
    case Method::Auto:
    case Method::Dop853:
      break;
  }
  return 12;  // likewise
}

}  // namespace

StepCost predict_step(const PlanSummary& plan, std::size_t num_points, Method method) {
  const double points = static_cast<double>(num_points),
               equations = static_cast<double>(plan.form == Form::Tangent ? plan.coordinates : plan.equations);
  const double factor_nonzeros = static_cast<double>(plan.factor_nonzeros);

  StepCost cost;
  cost.solves = count_solves(method);
  // One pass over points and equations, one factorization, one forward and one back substitution.
  const int factorizations = method == Method::Taylor ? 1 : cost.solves;
  cost.seconds = cost.solves * (points * seconds_per_point + equations * seconds_per_equation +
                                factor_nonzeros * solve_seconds_per_nonzero) +
                 factorizations * (plan.factor_flops / factor_flops + factor_nonzeros * factor_seconds_per_nonzero);
  // L and S with 4-byte indices; about 20 state vectors of 3n.
  cost.bytes = 12.0 * (factor_nonzeros + static_cast<double>(plan.pattern_nonzeros)) + 20.0 * 24.0 * points;
  return cost;
}

}  // namespace tanor::cli
