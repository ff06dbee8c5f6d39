#pragma once

/// \file
/// The fields of each report, named once. JSON, Python and archives are loops over them.

#include <cstddef>
#include <functional>
#include <string_view>
#include <type_traits>

#include <tanor/certificate.hpp>
#include <tanor/constrainer.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>

namespace tanor {

/// A key as an argument of templates.
template <std::size_t size>
struct ReportKey {
  char letters[size]{};
  constexpr ReportKey(const char (&text)[size]) {
    for (std::size_t k = 0; k < size; ++k) letters[k] = text[k];
  }
};

/// A member of a report, or a function that it has. Its key in files is its own name if `letters` are none; in Python
/// it always has its own name. Arrays of points have rows of three numbers.
template <auto its_member, ReportKey letters = "", int num_columns = 0>
struct ReportField {
  static constexpr auto member = its_member;
  static constexpr std::string_view key = letters.letters;
  static constexpr int columns = num_columns;
};
template <ReportKey key, auto member>
inline constexpr ReportField<member, key> keyed{};
template <auto member>
inline constexpr ReportField<member, "", 3> rows_of_points{};

/// A table of fields: pointers to members, `keyed` or `rows_of_points`.
template <auto... fields>
struct ReportFields {
  template <auto field>
  static constexpr auto as_field() {
    if constexpr (std::is_member_pointer_v<decltype(field)>)
      return ReportField<field>{};
    else
      return field;
  }
  template <class Visit>
  static constexpr void for_each(const Visit& visit) {
    (visit(as_field<fields>()), ...);
  }
};

/// The table of a report; what has an empty one is no report.
template <class Report>
inline constexpr ReportFields<> fields_of{};

template <class Report>
concept HasReportFields = !std::is_same_v<decltype(fields_of<Report>), const ReportFields<>>;

/// Visits the members of a report, to write and to read them (base/archive.hpp).
template <class Report, class Visit>
void visit_parts(Report& report, Visit& visit) requires HasReportFields<std::remove_const_t<Report>> {
  fields_of<std::remove_const_t<Report>>.for_each([&](auto field) {
    if constexpr (std::is_member_object_pointer_v<decltype(field.member)>) visit(report.*field.member);
  });
}

template <>
inline constexpr ReportFields<&Outcome::ok, &Outcome::status, &Outcome::what> fields_of<Outcome>{};
template <>
inline constexpr ReportFields<&PlanSummary::form, &PlanSummary::points, &PlanSummary::supports, &PlanSummary::equations,
                              &PlanSummary::coordinates, &PlanSummary::islands, &PlanSummary::parts,
                              &PlanSummary::pattern_nonzeros, &PlanSummary::factor_nonzeros, &PlanSummary::factor_flops,
                              &PlanSummary::linear_solver, &PlanSummary::linear_solver_reason, &PlanSummary::ordering,
                              &PlanSummary::factorization, &PlanSummary::left_out, &PlanSummary::prestress_rigid_points,
                              &PlanSummary::idle_equations>
    fields_of<PlanSummary>{};
template <>
inline constexpr ReportFields<&Units::name, &Units::length, &Units::mass, &Units::time, &Units::force, &Units::energy,
                              &Units::temperature, &Units::pressure, &Units::boltzmann>
    fields_of<Units>{};
template <>
inline constexpr ReportFields<&Counters::evaluations, &Counters::factorizations, &Counters::solves,
                              &Counters::iterations, &Counters::split_factorizations, &Counters::rank_decisions,
                              &Counters::friction_solves, &Counters::friction_iterations>
    fields_of<Counters>{};
template <>
inline constexpr ReportFields<&ConstraintReport::outcome, &ConstraintReport::iterations, &ConstraintReport::violation,
                              &ConstraintReport::correction, &ConstraintReport::worst_row,
                              &ConstraintReport::largest_turn, &ConstraintReport::work, &ConstraintReport::virial>
    fields_of<ConstraintReport>{};
template <>
inline constexpr ReportFields<&LogDeterminant::outcome, &LogDeterminant::value> fields_of<LogDeterminant>{};
template <>
inline constexpr ReportFields<&RowDependence::row, &RowDependence::what> fields_of<RowDependence>{};
template <>
inline constexpr ReportFields<&RankReport::is_known, &RankReport::rank, &RankReport::degrees_of_freedom,
                              &RankReport::dependences, &RankReport::multipliers_unique,
                              &RankReport::prestress_rigid_points, &RankReport::smallest_singular_value>
    fields_of<RankReport>{};
template <>
inline constexpr ReportFields<
    &FrictionReport::contacts, &FrictionReport::sticking, &FrictionReport::sticking_is_indeterminate,
    &FrictionReport::iterations, &FrictionReport::contraction, &FrictionReport::residual, &FrictionReport::error_bound,
    &FrictionReport::uniqueness, &FrictionReport::uniqueness_reason, &FrictionReport::method_used>
    fields_of<FrictionReport>{};
template <>
inline constexpr ReportFields<&SolveReport::outcome, &SolveReport::residual, &SolveReport::reciprocal_condition,
                              &SolveReport::refinements, &SolveReport::forms_disagreement, &SolveReport::friction>
    fields_of<SolveReport>{};
template <>
inline constexpr ReportFields<&ProjectionReport::outcome, &ProjectionReport::correction, &ProjectionReport::violation,
                              &ProjectionReport::iterations>
    fields_of<ProjectionReport>{};
template <>
inline constexpr ReportFields<&StartReport::outcome, &StartReport::position_correction,
                              &StartReport::velocity_correction, &StartReport::relative>
    fields_of<StartReport>{};
template <>
inline constexpr ReportFields<&ReactionPart::cause, &ReactionPart::multipliers,
                              rows_of_points<&ReactionPart::reactions>>
    fields_of<ReactionPart>{};
template <>
inline constexpr ReportFields<&ReactionsByCause::outcome, &ReactionsByCause::parts> fields_of<ReactionsByCause>{};
template <>
inline constexpr ReportFields<&FrictionBlocks::outcome, &FrictionBlocks::multipliers,
                              rows_of_points<&FrictionBlocks::friction>, &FrictionBlocks::iterations,
                              &FrictionBlocks::tangent_block_left_out>
    fields_of<FrictionBlocks>{};
template <>
inline constexpr ReportFields<&CertificateCheck::words, &CertificateCheck::identity, &CertificateCheck::error,
                              &CertificateCheck::allowed, &CertificateCheck::where>
    fields_of<CertificateCheck>{};
template <>
inline constexpr ReportFields<&Violation::largest, &Violation::where> fields_of<Violation>{};
template <>
inline constexpr ReportFields<&Extreme::value, keyed<"t", &Extreme::time>, &Extreme::member> fields_of<Extreme>{};
template <>
inline constexpr ReportFields<&Observed::name, keyed<"observable", &Observed::text>, &Observed::unit, &Observed::parts,
                              &Observed::members, &Observed::values, &Observed::unknown, &Observed::member,
                              &Observed::least, &Observed::largest>
    fields_of<Observed>{};
template <>
inline constexpr ReportFields<keyed<"event", &Passage::name>, keyed<"number", &Passage::event>,
                              keyed<"t", &Passage::time>, &Passage::rises, keyed<"do", &Passage::action>,
                              &Passage::member, &Passage::taken, &Passage::energy_lost, &Passage::rest>
    fields_of<Passage>{};
template <>
inline constexpr ReportFields<keyed<"t", &ContactEvent::time>, keyed<"kind", &ContactEvent::change>,
                              &ContactEvent::equations, &ContactEvent::impulses, &ContactEvent::rates_before,
                              &ContactEvent::energy_lost, &ContactEvent::restitution_capped>
    fields_of<ContactEvent>{};
template <>
inline constexpr ReportFields<&EnergyReport::start, keyed<"end", &EnergyReport::now>, &EnergyReport::kinetic,
                              &EnergyReport::potential, &EnergyReport::drift_relative, &EnergyReport::work_of_friction,
                              &EnergyReport::work_of_impacts, &EnergyReport::work_of_supports,
                              &EnergyReport::work_of_forces, &EnergyReport::work_of_potentials,
                              &EnergyReport::potential_at_start, &EnergyReport::scale, &EnergyReport::largest_drift,
                              &EnergyReport::largest_drift_time>
    fields_of<EnergyReport>{};
template <>
inline constexpr ReportFields<&FrictionSummary::solves, &FrictionSummary::iterations_mean,
                              &FrictionSummary::iterations_max, &FrictionSummary::contraction_max,
                              &FrictionSummary::residual_max, &FrictionSummary::error_bound,
                              &FrictionSummary::uniqueness, &FrictionSummary::uniqueness_reason,
                              &FrictionSummary::several, &FrictionSummary::first_several, &FrictionSummary::method_used>
    fields_of<FrictionSummary>{};
template <>
inline constexpr ReportFields<keyed<"t", &RankChange::time>, &RankChange::rank> fields_of<RankChange>{};
template <>
inline constexpr ReportFields<&RankChanges::start, &RankChanges::now, &RankChanges::count, &RankChanges::first>
    fields_of<RankChanges>{};
template <>
inline constexpr ReportFields<keyed<"t", &SingularPassage::time>, &SingularPassage::reciprocal_condition>
    fields_of<SingularPassage>{};
template <>
inline constexpr ReportFields<&SingularPassages::count, &SingularPassages::first> fields_of<SingularPassages>{};
template <>
inline constexpr ReportFields<keyed<"t", &NearestToSingular::time>, &NearestToSingular::reciprocal_condition>
    fields_of<NearestToSingular>{};
template <>
inline constexpr ReportFields<keyed<"position_max", &Violations::position>,
                              keyed<"velocity_max", &Violations::velocity>,
                              keyed<"acceleration_max", &Violations::acceleration>>
    fields_of<Violations>{};
template <>
inline constexpr ReportFields<&PhaseTimes::evaluate, &PhaseTimes::assemble, &PhaseTimes::factor, &PhaseTimes::solve,
                              &PhaseTimes::friction>
    fields_of<PhaseTimes>{};
template <>
inline constexpr ReportFields<
    &Solution::outcome, &Solution::time, rows_of_points<&Solution::positions>, rows_of_points<&Solution::velocities>,
    rows_of_points<&Solution::accelerations>, &Solution::multipliers, rows_of_points<&Solution::reactions>,
    rows_of_points<&Solution::support_forces>, &Solution::coordinates, &Solution::coordinate_rates,
    &Solution::position_violation, &Solution::degrees_of_freedom, &Solution::self_stress, &Solution::has_prestress>
    fields_of<Solution>{};
template <>
inline constexpr ReportFields<&Split::outcome, rows_of_points<&Split::tangent_accelerations>,
                              rows_of_points<&Split::normal_accelerations>, rows_of_points<&Split::tangent_forces>,
                              rows_of_points<&Split::normal_forces>, rows_of_points<&Split::tangent_friction>,
                              rows_of_points<&Split::normal_friction>, &Split::mass_coupling>
    fields_of<Split>{};
template <>
inline constexpr ReportFields<
    &Certificate::normal_identity, &Certificate::tangent_identity, &Certificate::bases_orthogonal,
    &Certificate::orthogonality, &Certificate::residual, &Certificate::forms_agree, &Certificate::second_factorization,
    &Certificate::power_balance, &Certificate::friction, &Certificate::reciprocal_condition, &Certificate::passed,
    &Certificate::certified_to, keyed<"verdict", &Certificate::line>, &Certificate::checks, &Certificate::left_out>
    fields_of<Certificate>{};
template <>
inline constexpr ReportFields<
    &MotionForces::outcome, &MotionForces::position, &MotionForces::velocity, &MotionForces::acceleration,
    &MotionForces::multipliers, rows_of_points<&MotionForces::friction>, rows_of_points<&MotionForces::reactions>,
    rows_of_points<&MotionForces::control_forces>, rows_of_points<&MotionForces::support_forces>,
    &MotionForces::largest_control, &MotionForces::controlled_point>
    fields_of<MotionForces>{};
template <>
inline constexpr ReportFields<
    &MotionReport::method, &MotionReport::method_reason, &MotionReport::time, &MotionReport::steps,
    &MotionReport::rejected, &MotionReport::last_step, &MotionReport::accuracy_warning, &MotionReport::events,
    &MotionReport::last_event, &MotionReport::last_change, &MotionReport::events_may_be_missed,
    &MotionReport::contact_events, &MotionReport::start, &MotionReport::violation, &MotionReport::last_violation,
    &MotionReport::nearest_to_singular, &MotionReport::last_reciprocal_condition, &MotionReport::rank_changes,
    &MotionReport::singular_passages, &MotionReport::energy, &MotionReport::friction, &MotionReport::counters,
    &MotionReport::times>
    fields_of<MotionReport>{};
template <>
inline constexpr ReportFields<&StabilityReport::status, &StabilityReport::unstable_directions,
                              &StabilityReport::zero_modes, &StabilityReport::rigid_zero_modes,
                              &StabilityReport::lowest_omega2, rows_of_points<&StabilityReport::lowest_shape>>
    fields_of<StabilityReport>{};
template <>
inline constexpr ReportFields<&EquilibriumSearch::method_used, &EquilibriumSearch::iterations,
                              &EquilibriumSearch::factorizations, &EquilibriumSearch::residuals>
    fields_of<EquilibriumSearch>{};
template <>
inline constexpr ReportFields<&Buckling::outcome, &Buckling::load_factor, rows_of_points<&Buckling::shape>>
    fields_of<Buckling>{};

// Not a report, but listed likewise.
template <>
inline constexpr ReportFields<&MotionOptions::method, &MotionOptions::step, &MotionOptions::max_step,
                              &MotionOptions::rtol, &MotionOptions::atol, &MotionOptions::stabilisation,
                              &MotionOptions::start, &MotionOptions::order, &MotionOptions::spectral_radius>
    fields_of<MotionOptions>{};

}  // namespace tanor
