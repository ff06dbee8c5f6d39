#include <tanor/build_info.hpp>
#include <tanor/constrainer.hpp>

#include "python/bindings.hpp"
#include "python/records.hpp"

namespace tanor::python {

// NOLINTNEXTLINE(readability-function-size): a list
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
  Record<FrictionReport>(module, "FrictionReport")
      .field("contacts", &FrictionReport::contacts)
      .field("sticking", &FrictionReport::sticking)
      .field("iterations", &FrictionReport::iterations)
      .field("contraction", &FrictionReport::contraction)
      .field("residual", &FrictionReport::residual)
      .field("error_bound", &FrictionReport::error_bound)
      .field("uniqueness", &FrictionReport::uniqueness)
      .field("uniqueness_reason", &FrictionReport::uniqueness_reason)
      .field("sticking_is_indeterminate", &FrictionReport::sticking_is_indeterminate)
      .field("method_used", &FrictionReport::method_used);
  Record<SolveReport>(module, "SolveReport")
      .property("ok", &is_ok<SolveReport>, "bool")
      .field("outcome", &SolveReport::outcome)
      .field("residual", &SolveReport::residual)
      .field("reciprocal_condition", &SolveReport::reciprocal_condition)
      .field("refinements", &SolveReport::refinements)
      .field("forms_disagreement", &SolveReport::forms_disagreement)
      .field("friction", &SolveReport::friction);
  Record<ProjectionReport>(module, "ProjectionReport", "How a projection ended.")
      .property("ok", &is_ok<ProjectionReport>, "bool")
      .field("outcome", &ProjectionReport::outcome)
      .field("correction", &ProjectionReport::correction)
      .field("violation", &ProjectionReport::violation)
      .field("iterations", &ProjectionReport::iterations);
  Record<StartReport>(module, "StartReport", "How a consistent start was found.")
      .property("ok", &is_ok<StartReport>, "bool")
      .field("outcome", &StartReport::outcome)
      .field("position_correction", &StartReport::position_correction)
      .field("velocity_correction", &StartReport::velocity_correction)
      .field("relative", &StartReport::relative);
  Record<Solution>(module, "Solution")
      .property("ok", &is_ok<Solution>, "bool")
      .field("outcome", &Solution::outcome)
      .field("time", &Solution::time)
      .field("positions", &Solution::positions, 3)
      .field("velocities", &Solution::velocities, 3)
      .field("accelerations", &Solution::accelerations, 3)
      .field("multipliers", &Solution::multipliers)
      .field("reactions", &Solution::reactions, 3)
      .field("support_forces", &Solution::support_forces, 3)
      .field("coordinates", &Solution::coordinates)
      .field("coordinate_rates", &Solution::coordinate_rates)
      .field("position_violation", &Solution::position_violation)
      .method(
          "multiplier",
          [](const Solution& self, std::size_t group, std::size_t number, std::size_t k) {
            return self.multiplier({group, number}, k);
          },
          "lambda of a member of System.constraints[group], of its k-th equation. Raises InputError where there is "
          "none.",
          py::arg("group"), py::arg("number"), py::arg("k") = 0)
      .method(
          "tension",
          [](const Solution& self, std::size_t group, std::size_t number) {
            return self.tension({group, number});
          },
          "N: what a rod of System.constraints[group] pulls with; negative where it pushes.", py::arg("group"),
          py::arg("number"));
  Record<Split>(module, "Split")
      .property("ok", &is_ok<Split>, "bool")
      .field("outcome", &Split::outcome)
      .field("tangent_accelerations", &Split::tangent_accelerations, 3)
      .field("normal_accelerations", &Split::normal_accelerations, 3)
      .field("tangent_forces", &Split::tangent_forces, 3)
      .field("normal_forces", &Split::normal_forces, 3)
      .field("tangent_friction", &Split::tangent_friction, 3)
      .field("normal_friction", &Split::normal_friction, 3)
      .field("mass_coupling", &Split::mass_coupling);
  Record<ReactionPart>(module, "ReactionPart")
      .field("cause", &ReactionPart::cause)
      .field("multipliers", &ReactionPart::multipliers)
      .field("reactions", &ReactionPart::reactions, 3);
  Record<ReactionsByCause>(module, "ReactionsByCause", "Reactions by what causes them.")
      .property("ok", &is_ok<ReactionsByCause>, "bool")
      .field("outcome", &ReactionsByCause::outcome)
      .field("parts", &ReactionsByCause::parts);
  Record<FrictionBlocks>(module, "FrictionBlocks")
      .property("ok", &is_ok<FrictionBlocks>, "bool")
      .field("outcome", &FrictionBlocks::outcome)
      .field("multipliers", &FrictionBlocks::multipliers)
      .field("friction", &FrictionBlocks::friction, 3)
      .field("iterations", &FrictionBlocks::iterations)
      .field("tangent_block_left_out", &FrictionBlocks::tangent_block_left_out);
}

}  // namespace tanor::python
