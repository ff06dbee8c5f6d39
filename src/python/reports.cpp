#include <tanor/build_info.hpp>
#include <tanor/constrainer.hpp>

#include "python/bindings.hpp"
#include "python/records.hpp"

namespace tanor::python {
namespace {

/// Whether a report's outcome is ok.
template <class Report>
bool is_ok(const Report& report) {
  return report.outcome.ok();
}

}  // namespace

void bind_reports(py::module_& module) {
  Record<Outcome>(module, "Outcome")
      .property("ok", &Outcome::ok, "bool")
      .field("status", &Outcome::status)
      .field("what", &Outcome::what);
  Record<PlanSummary>(module, "PlanSummary")
      .field("form", &PlanSummary::form)
      .field("points", &PlanSummary::points)
      .field("supports", &PlanSummary::supports)
      .field("equations", &PlanSummary::equations)
      .field("coordinates", &PlanSummary::coordinates)
      .field("islands", &PlanSummary::islands)
      .field("parts", &PlanSummary::parts)
      .field("pattern_nonzeros", &PlanSummary::pattern_nonzeros)
      .field("factor_nonzeros", &PlanSummary::factor_nonzeros)
      .field("factor_flops", &PlanSummary::factor_flops)
      .field("linear_solver", &PlanSummary::linear_solvers)
      .field("linear_solver_reason", &PlanSummary::linear_solver_reason)
      .field("ordering", &PlanSummary::orderings)
      .field("factorization", &PlanSummary::factorizations)
      .field("left_out", &PlanSummary::left_out)
      .field("prestress_rigid_points", &PlanSummary::prestress_rigid_points)
      .field("idle_equations", &PlanSummary::idle_equations);
  Record<Counters>(module, "Counters")
      .field("evaluations", &Counters::evaluations)
      .field("factorizations", &Counters::factorizations)
      .field("solves", &Counters::solves)
      .field("iterations", &Counters::iterations)
      .field("rank_decisions", &Counters::rank_decisions)
      .field("friction_solves", &Counters::friction_solves)
      .field("friction_iterations", &Counters::friction_iterations);
  Record<ConstraintReport>(module, "ConstraintReport")
      .property("ok", &is_ok<ConstraintReport>, "bool")
      .field("outcome", &ConstraintReport::outcome)
      .field("iterations", &ConstraintReport::iterations)
      .field("violation", &ConstraintReport::violation)
      .field("correction", &ConstraintReport::correction)
      .field("worst_row", &ConstraintReport::worst_row)
      .field("largest_turn", &ConstraintReport::largest_turn)
      .field("work", &ConstraintReport::work)
      .field("virial", &ConstraintReport::virial);
  Record<LogDeterminant>(module, "LogDeterminant")
      .property("ok", &is_ok<LogDeterminant>, "bool")
      .field("outcome", &LogDeterminant::outcome)
      .field("value", &LogDeterminant::value);
  Record<RowDependence>(module, "RowDependence").field("row", &RowDependence::row).field("what", &RowDependence::what);
  Record<RankReport>(module, "RankReport")
      .field("is_known", &RankReport::is_known)
      .field("rank", &RankReport::rank)
      .field("degrees_of_freedom", &RankReport::degrees_of_freedom)
      .field("dependences", &RankReport::dependences)
      .field("multipliers_unique", &RankReport::multipliers_unique)
      .field("prestress_rigid_points", &RankReport::prestress_rigid_points)
      .field("smallest_singular_value", &RankReport::smallest_singular_value);
}

}  // namespace tanor::python
