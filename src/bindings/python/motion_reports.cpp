#include <tanor/certificate.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/motion.hpp>

#include "python/bindings.hpp"
#include "python/records.hpp"

namespace tanor::python {
namespace {

void bind_certificate(py::module_& module) {
  Record<CertificateCheck>(module, "CertificateCheck")
      .field("identity", &CertificateCheck::identity)
      .field("words", &CertificateCheck::words)
      .field("error", &CertificateCheck::error)
      .field("allowed", &CertificateCheck::allowed)
      .field("where", &CertificateCheck::where);
  Record<Certificate>(module, "Certificate")
      .property("passed", &Certificate::passed, "bool")
      .property("certified_to", &Certificate::certified_to, "float")
      .property("line", &Certificate::line, "str")
      .field("checks", &Certificate::checks)
      .field("left_out", &Certificate::left_out);
}

void bind_motion_forces(py::module_& module) {
  Record<Violation>(module, "Violation").field("largest", &Violation::largest).field("where", &Violation::where);
  Record<MotionForces>(module, "MotionForces")
      .property(
          "ok", [](const MotionForces& self) { return self.outcome.ok(); }, "bool")
      .field("outcome", &MotionForces::outcome)
      .field("position", &MotionForces::position)
      .field("velocity", &MotionForces::velocity)
      .field("acceleration", &MotionForces::acceleration)
      .field("multipliers", &MotionForces::multipliers)
      .field("friction", &MotionForces::friction, 3)
      .field("reactions", &MotionForces::reactions, 3)
      .field("control_forces", &MotionForces::control_forces, 3)
      .field("support_forces", &MotionForces::support_forces, 3)
      .field("largest_control", &MotionForces::largest_control)
      .field("controlled_point", &MotionForces::controlled_point);
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a list
void bind_motion_reports(py::module_& module) {
  bind_certificate(module);
  bind_motion_forces(module);
  Record<Extreme>(module, "Extreme").fields();
  Record<Observed>(module, "Observed").fields().property("columns", &column_names, "list");
  Record<Passage>(module, "Passage")
      .field("event", &Passage::event)
      .field("time", &Passage::time)
      .field("rises", &Passage::rises)
      .field("name", &Passage::name)
      .field("member", &Passage::member)
      .field("energy_lost", &Passage::energy_lost)
      .field("rest", &Passage::rest);
  Record<EnergyReport>(module, "EnergyReport")
      .field("start", &EnergyReport::start)
      .field("now", &EnergyReport::now)
      .field("work_of_supports", &EnergyReport::work_of_supports)
      .field("kinetic", &EnergyReport::kinetic)
      .field("potential", &EnergyReport::potential)
      .field("work_of_forces", &EnergyReport::work_of_forces)
      .field("work_of_potentials", &EnergyReport::work_of_potentials)
      .field("work_of_friction", &EnergyReport::work_of_friction)
      .field("scale", &EnergyReport::scale)
      .field("largest_drift", &EnergyReport::largest_drift)
      .field("largest_drift_time", &EnergyReport::largest_drift_time)
      .property("drift_relative", &EnergyReport::drift_relative, "float");
  Record<FrictionSummary>(module, "FrictionSummary")
      .field("solves", &FrictionSummary::solves)
      .field("iterations_mean", &FrictionSummary::iterations_mean)
      .field("iterations_max", &FrictionSummary::iterations_max)
      .field("contraction_max", &FrictionSummary::contraction_max)
      .field("error_bound", &FrictionSummary::error_bound)
      .field("uniqueness", &FrictionSummary::uniqueness)
      .field("uniqueness_reason", &FrictionSummary::uniqueness_reason)
      .field("method_used", &FrictionSummary::method_used)
      .field("residual_max", &FrictionSummary::residual_max)
      .field("several", &FrictionSummary::several)
      .field("first_several", &FrictionSummary::first_several);
  Record<RankChange>(module, "RankChange").field("time", &RankChange::time).field("rank", &RankChange::rank);
  Record<RankChanges>(module, "RankChanges", "The rank of K along a motion.")
      .field("start", &RankChanges::start)
      .field("now", &RankChanges::now)
      .field("first", &RankChanges::first)
      .field("count", &RankChanges::count);
  Record<SingularPassage>(module, "SingularPassage")
      .field("time", &SingularPassage::time)
      .field("reciprocal_condition", &SingularPassage::reciprocal_condition);
  Record<SingularPassages>(module, "SingularPassages", "Where a motion passed singular configurations.")
      .field("first", &SingularPassages::first)
      .field("count", &SingularPassages::count);
  Record<MotionReport>(module, "MotionReport")
      .field("method", &MotionReport::method)
      .field("method_reason", &MotionReport::method_reason)
      .field("time", &MotionReport::time)
      .field("steps", &MotionReport::steps)
      .field("rejected", &MotionReport::rejected)
      .field("last_step", &MotionReport::last_step)
      .field("accuracy_warning", &MotionReport::accuracy_warning)
      .field("events", "EventReport.events", &EventReport::events)
      .field("last_event", "EventReport.last_event", &EventReport::last_event)
      .field("events_may_be_missed", "EventReport.events_may_be_missed", &EventReport::events_may_be_missed)
      .field("start", &MotionReport::start)
      .field("position_violation", "Violations.position", &MotionReport::violation, &Violations::position)
      .field("velocity_violation", "Violations.velocity", &MotionReport::violation, &Violations::velocity)
      .field("acceleration_violation", "Violations.acceleration", &MotionReport::violation, &Violations::acceleration)
      .field("last_position_violation", "Violations.position", &MotionReport::last_violation, &Violations::position)
      .field("last_velocity_violation", "Violations.velocity", &MotionReport::last_violation, &Violations::velocity)
      .field("last_acceleration_violation", "Violations.acceleration", &MotionReport::last_violation,
             &Violations::acceleration)
      .field("reciprocal_condition", "NearestToSingular.reciprocal_condition", &MotionReport::nearest_to_singular,
             &NearestToSingular::reciprocal_condition)
      .field("reciprocal_condition_time", "NearestToSingular.time", &MotionReport::nearest_to_singular,
             &NearestToSingular::time)
      .field("last_reciprocal_condition", &MotionReport::last_reciprocal_condition)
      .field("rank_changes", &MotionReport::rank_changes)
      .field("singular_passages", &MotionReport::singular_passages)
      .field("energy", &MotionReport::energy)
      .field("friction", &MotionReport::friction)
      .field("counters", &MotionReport::counters);
}

}  // namespace tanor::python
