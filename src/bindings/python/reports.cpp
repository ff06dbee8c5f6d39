#include <tanor/certificate.hpp>
#include <tanor/constrainer.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/motion.hpp>

#include "python/bindings.hpp"
#include "python/records.hpp"

namespace tanor::python {
namespace {

void bind_solutions(py::module_& module) {
  using S = Solution;
  Record<S>(module)
      .fields<&S::outcome, &S::time>()
      .points<&S::positions, &S::velocities, &S::accelerations>()
      .fields<&S::multipliers>()
      .points<&S::reactions, &S::support_forces>()
      .fields<&S::coordinates, &S::coordinate_rates, &S::position_violation>()
      .method(
          "multiplier",
          [](const S& self, std::size_t group, std::size_t number, std::size_t k) {
            return self.multiplier({group, number}, k);
          },
          "lambda of a member of System.constraints[group], of its k-th equation. Raises InputError where there is "
          "none.",
          py::arg("group"), py::arg("number"), py::arg("k") = 0)
      .method(
          "tension",
          [](const S& self, std::size_t group, std::size_t number) {
            return self.tension({group, number});
          },
          "N: what a rod of System.constraints[group] pulls with; negative where it pushes.", py::arg("group"),
          py::arg("number"));
  Record<Split>(module)
      .fields<&Split::outcome>()
      .points<&Split::tangent_accelerations, &Split::normal_accelerations, &Split::tangent_forces,
              &Split::normal_forces, &Split::tangent_friction, &Split::normal_friction>()
      .fields<&Split::mass_coupling>();
  Record<ReactionPart>(module)
      .fields<&ReactionPart::cause, &ReactionPart::multipliers>()
      .points<&ReactionPart::reactions>();
  Record<ReactionsByCause>(module, "Reactions by what causes them.")
      .fields<&ReactionsByCause::outcome, &ReactionsByCause::parts>();
  using Blocks = FrictionBlocks;
  Record<Blocks>(module)
      .fields<&Blocks::outcome, &Blocks::multipliers>()
      .points<&Blocks::friction>()
      .fields<&Blocks::iterations, &Blocks::tangent_block_left_out>();
}

void bind_motion_forces(py::module_& module) {
  Record<Violation>(module).fields<&Violation::largest, &Violation::where>();
  using M = MotionForces;
  Record<M>(module)
      .fields<&M::outcome, &M::position, &M::velocity, &M::acceleration, &M::multipliers>()
      .points<&M::friction, &M::reactions, &M::control_forces, &M::support_forces>()
      .fields<&M::largest_control, &M::controlled_point>();
}

void bind_motion_report(py::module_& module) {
  Record<Extreme>(module).table();
  Record<Observed>(module).table().property("columns", &column_names, "list");
  Record<Passage>(module)
      .fields<&Passage::event, &Passage::time, &Passage::rises, &Passage::name, &Passage::member, &Passage::energy_lost,
              &Passage::rest, &Passage::action>();
  using E = EnergyReport;
  Record<E>(module)
      .fields<&E::start, &E::now, &E::work_of_supports, &E::kinetic, &E::potential, &E::work_of_forces,
              &E::work_of_potentials, &E::work_of_friction, &E::scale, &E::largest_drift, &E::largest_drift_time>()
      .property("drift_relative", &E::drift_relative, "float");
  using F = FrictionSummary;
  Record<F>(module)
      .fields<&F::solves, &F::iterations_mean, &F::iterations_max, &F::contraction_max, &F::error_bound, &F::uniqueness,
              &F::uniqueness_reason, &F::method_used, &F::residual_max, &F::several, &F::first_several>();
  Record<RankChange>(module).fields<&RankChange::time, &RankChange::rank>();
  Record<RankChanges>(module, "The rank of K along a motion.")
      .fields<&RankChanges::start, &RankChanges::now, &RankChanges::first, &RankChanges::count>();
  Record<SingularPassage>(module).fields<&SingularPassage::time, &SingularPassage::reciprocal_condition>();
  Record<SingularPassages>(module, "Where a motion passed singular configurations.")
      .fields<&SingularPassages::first, &SingularPassages::count>();
  using M = MotionReport;
  using V = Violations;
  using Nearest = NearestToSingular;
  Record<M>(module)
      .fields<&M::method, &M::method_reason, &M::time, &M::steps, &M::rejected, &M::last_step, &M::accuracy_warning,
              &M::events, &M::last_event, &M::events_may_be_missed, &M::start>()
      .parts<&M::violation, &V::position, &V::velocity, &V::acceleration>("", "_violation")
      .parts<&M::last_violation, &V::position, &V::velocity, &V::acceleration>("last_", "_violation")
      .parts<&M::nearest_to_singular, &Nearest::reciprocal_condition>()
      .parts<&M::nearest_to_singular, &Nearest::time>("reciprocal_condition_")
      .fields<&M::last_reciprocal_condition, &M::rank_changes, &M::singular_passages, &M::energy, &M::friction,
              &M::counters>();
}

}  // namespace

void bind_reports(py::module_& module) {
  Record<Outcome>(module).property("ok", &Outcome::ok, "bool").fields<&Outcome::status, &Outcome::what>();
  using P = PlanSummary;
  Record<P>(module)
      .fields<&P::form, &P::points, &P::supports, &P::equations, &P::coordinates, &P::islands, &P::parts,
              &P::pattern_nonzeros, &P::factor_nonzeros, &P::factor_flops>()
      .field<&P::linear_solvers>("linear_solver")
      .fields<&P::linear_solver_reason>()
      .field<&P::orderings>("ordering")
      .field<&P::factorizations>("factorization")
      .fields<&P::left_out, &P::prestress_rigid_points, &P::idle_equations>();
  using C = Counters;
  Record<C>(module)
      .fields<&C::evaluations, &C::factorizations, &C::solves, &C::iterations, &C::rank_decisions, &C::friction_solves,
              &C::friction_iterations>();
  using Host = ConstraintReport;
  Record<Host>(module)
      .fields<&Host::outcome, &Host::iterations, &Host::violation, &Host::correction, &Host::worst_row,
              &Host::largest_turn, &Host::work, &Host::virial>();
  Record<LogDeterminant>(module).fields<&LogDeterminant::outcome, &LogDeterminant::value>();
  Record<RowDependence>(module).fields<&RowDependence::row, &RowDependence::what>();
  using R = RankReport;
  Record<R>(module)
      .fields<&R::is_known, &R::rank, &R::degrees_of_freedom, &R::dependences, &R::multipliers_unique,
              &R::prestress_rigid_points, &R::smallest_singular_value>();
  using F = FrictionReport;
  Record<F>(module)
      .fields<&F::contacts, &F::sticking, &F::iterations, &F::contraction, &F::residual, &F::error_bound,
              &F::uniqueness, &F::uniqueness_reason, &F::sticking_is_indeterminate, &F::method_used>();
  using S = SolveReport;
  Record<S>(module)
      .fields<&S::outcome, &S::residual, &S::reciprocal_condition, &S::refinements, &S::forms_disagreement,
              &S::friction>();
  using Projection = ProjectionReport;
  Record<Projection>(module, "How a projection ended.")
      .fields<&Projection::outcome, &Projection::correction, &Projection::violation, &Projection::iterations>();
  using Start = StartReport;
  Record<Start>(module, "How a consistent start was found.")
      .fields<&Start::outcome, &Start::position_correction, &Start::velocity_correction, &Start::relative>();
  bind_solutions(module);
  using Check = CertificateCheck;
  Record<Check>(module).fields<&Check::identity, &Check::words, &Check::error, &Check::allowed, &Check::where>();
  Record<Certificate>(module)
      .property("passed", &Certificate::passed, "bool")
      .property("certified_to", &Certificate::certified_to, "float")
      .property("line", &Certificate::line, "str")
      .fields<&Certificate::checks, &Certificate::left_out>();
  bind_motion_forces(module);
  bind_motion_report(module);
}

}  // namespace tanor::python
