#include "cli/cost.hpp"

#include <algorithm>
#include <cmath>

namespace tanor::cli {

namespace {

// The constants are measured on one thread of a 2.6 GHz EPYC, bench/phases, as minima over chains of 1e4 and 3e5 rods
// and nets of 30^2 to 300^2 beads. Evaluation, assembly and reactions take 15 to 25 ns an equation; the formula gives
// 0.6 to 1.1 of a factorization and 0.8 (chains) to 3.4 (small nets) of a solve. The time per point is from whole runs:
// for steps of chains, nets and a melt, with each method, the formula gives 0.8 to 1.6 of the time.
constexpr double seconds_per_point = 15e-9;  // forces, sums of vectors
constexpr double seconds_per_equation = 20e-9;
constexpr double factor_seconds_per_nonzero = 10e-9;
constexpr double factor_flops = 5e9;
constexpr double solve_seconds_per_nonzero = 5e-9;

// The bytes are the largest resident memory of runs on one thread: chains and trees of 1e4 and 1e5 rods, 1e4 clusters
// of 10, nets of 30^2 to 300^2, lattices of 10^3 and 16^3, each method. The formula gives 0.8 to 1.4 of them.
constexpr double program_bytes = 14e6;
constexpr double bytes_per_point = 475.0, bytes_per_equation = 475.0, bytes_per_nonzero = 12.0;

/// Returns the number of terms that src/core/motion/taylor.cpp chooses.
double count_terms(const MotionOptions& motion, std::size_t num_points) {
  if (motion.order > 0) return motion.order;
  const bool is_large = 3 * num_points >= 50000;
  const double order = is_large ? 3.0 - 0.5 * std::log(motion.rtol) : 4.0 - 0.7 * std::log(motion.rtol);
  return std::clamp(std::round(order), 6.0, 24.0);
}

bool is_general(const PlanSummary& plan) {
  const LinearSolver first = plan.linear_solvers.front();
  return first == LinearSolver::General || first == LinearSolver::Cholmod;
}

/// Counts the solves of stages or terms, and those of projections onto the constraints. Solvers of one structure do
/// some of the latter in a fused pass, which is not counted.
void count_solves(const PlannedRun& run, Method method, RunCost* cost) {
  const MethodCost& step = traits_of(method).cost;
  const bool projects = run.plan.form == Form::Normal && run.plan.equations > 0;
  const double after = !projects ? 0.0 : is_general(run.plan) ? 6.0 : 1.0;
  const double terms = method == Method::Taylor ? count_terms(run.motion, run.num_points) : 1.0;
  cost->solves = step.solves * terms + std::min(step.projections, after);
  cost->factorizations = step.factorizations;
}

/// Returns the bytes that a method keeps beside the state: stages, terms of series, Newton's matrix with its factor.
double count_bytes(const PlannedRun& run, Method method, double equations) {
  const MethodCost& step = traits_of(method).cost;
  const double terms = method == Method::Taylor ? count_terms(run.motion, run.num_points) + 1.0 : 1.0;
  return terms * (step.bytes_a_point * static_cast<double>(run.num_points) + step.bytes_an_equation * equations +
                  step.bytes_a_nonzero * static_cast<double>(run.plan.factor_nonzeros));
}

/// Returns the bytes of the certificate: QR of M^-1/2 K, or another Cholesky factor if that is too large, and vectors.
double count_certificate(const PlannedRun& run, double equations) {
  constexpr double most_rows_of_qr = 200000;
  if (!run.is_certified || run.plan.equations == 0) return 0.0;
  const double nonzeros = is_general(run.plan) ? static_cast<double>(run.plan.factor_nonzeros) : 0.0;
  return 350.0 * equations + (equations <= most_rows_of_qr ? 50.0 : 24.0) * nonzeros;
}

}  // namespace

RunCost predict_run(const PlannedRun& run, Method method) {
  const PlanSummary& plan = run.plan;
  const auto points = static_cast<double>(run.num_points);
  const auto equations = static_cast<double>(plan.form == Form::Tangent ? plan.coordinates : plan.equations);
  const auto nonzeros = static_cast<double>(plan.factor_nonzeros);

  RunCost cost;
  count_solves(run, method, &cost);
  cost.seconds = cost.solves * (points * seconds_per_point + equations * seconds_per_equation +
                                nonzeros * solve_seconds_per_nonzero) +
                 cost.factorizations * (plan.factor_flops / factor_flops + nonzeros * factor_seconds_per_nonzero);
  cost.bytes = program_bytes + bytes_per_point * points + bytes_per_equation * equations +
               bytes_per_nonzero * nonzeros + count_bytes(run, method, equations) + count_certificate(run, equations);
  return cost;
}

}  // namespace tanor::cli
