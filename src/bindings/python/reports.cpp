#include <tanor/certificate.hpp>
#include <tanor/constrainer.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/motion.hpp>

#include "python/bindings.hpp"
#include "python/records.hpp"

namespace tanor::python {
namespace {

template <class... Reports>
void bind_tables(py::module_& module) {
  (Record<Reports>(module).table(), ...);
}

}  // namespace

void bind_reports(py::module_& module) {
  bind_tables<Outcome, PlanSummary, Counters, PhaseTimes, ConstraintReport, LogDeterminant, RowDependence, RankReport,
              FrictionReport, SolveReport, Split, ReactionPart, FrictionBlocks, CertificateCheck, Certificate,
              Violation, MotionForces, Extreme, Passage, EnergyReport, FrictionSummary, RankChange, SingularPassage,
              Violations, NearestToSingular>(module);
  Record<ProjectionReport>(module, "How a projection ended.").table();
  Record<StartReport>(module, "How a consistent start was found.").table();
  Record<ReactionsByCause>(module, "Reactions by what causes them.").table();
  Record<RankChanges>(module, "The rank of K along a motion.").table();
  Record<SingularPassages>(module, "Where a motion passed singular configurations.").table();
  Record<Observed>(module).table().property("columns", &column_names, "list");
  using S = Solution;
  Record<S>(module).table().kept("groups", "dict", groups_doc).kept("system", "System | Scene", "as it was given");
  using M = MotionReport;
  using V = Violations;
  using Nearest = NearestToSingular;
  Record<M>(module)
      .table()
      .parts<&M::violation, &V::position, &V::velocity, &V::acceleration>("", "_violation")
      .parts<&M::last_violation, &V::position, &V::velocity, &V::acceleration>("last_", "_violation")
      .parts<&M::nearest_to_singular, &Nearest::reciprocal_condition>()
      .parts<&M::nearest_to_singular, &Nearest::time>("reciprocal_condition_");
}

}  // namespace tanor::python
