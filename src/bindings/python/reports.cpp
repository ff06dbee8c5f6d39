#include <tanor/certificate.hpp>
#include <tanor/constrainer.hpp>
#include <tanor/inverse_dynamics.hpp>
#include <tanor/motion.hpp>

#include <string>
#include <unordered_set>
#include <variant>

#include "python/bindings.hpp"
#include "python/records.hpp"
#include "system/members.hpp"

namespace tanor::python {
namespace {

template <class... Reports>
void bind_tables(py::module_& module) {
  (Record<Reports>(module).table(), ...);
}

}  // namespace

py::dict list_groups(const System& system) {
  py::dict groups;
  std::size_t row = 0;
  for (std::size_t k = 0; k < system.constraints.size(); ++k) {
    const auto [members, rows] = detail::shape_of(system.constraints[k]);
    groups[py::str(constraint_name(system, k))] = py::make_tuple(row, members, rows);
    row += members * rows;
  }
  std::unordered_set<std::string> pulling;
  for (const Observable& each : tensions_of_groups(system)) pulling.insert(each.name);
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const py::str name(force_name(system, k));
    if (!pulling.contains(name) || groups.contains(name)) continue;
    std::visit(
        [&](const auto& group) {
          if constexpr (requires { group.pairs; }) groups[name] = py::make_tuple(0, group.pairs.size(), 0);
        },
        system.forces[k]);
  }
  return groups;
}

py::dict tensions_from(const std::vector<Observed>& of_groups) {
  py::dict tensions;
  for (const Observed& each : of_groups) tensions[py::str(each.name)] = copy(each.values, 0);
  return tensions;
}

void bind_reports(py::module_& module) {
  bind_tables<Outcome, PlanSummary, Counters, PhaseTimes, ConstraintReport, LogDeterminant, RowDependence, RankReport,
              FrictionReport, SolveReport, Split, ReactionPart, FrictionBlocks, CertificateCheck, Certificate,
              Violation, MotionForces, Extreme, Passage, ContactEvent, EnergyReport, FrictionSummary, RankChange,
              SingularPassage, Violations, NearestToSingular>(module);
  Record<ProjectionReport>(module, "How a projection ended.").table();
  Record<StartReport>(module, "How a consistent start was found.").table();
  Record<ReactionsByCause>(module, "Reactions by what causes them.").table();
  Record<RankChanges>(module, "The rank of K along a motion.").table();
  Record<SingularPassages>(module, "Where a motion passed singular configurations.").table();
  Record<Observed>(module).table().property("columns", &column_names, "list");
  using S = Solution;
  Record<S>(module)
      .table()
      .kept("groups", "dict", groups_doc)
      .kept("tensions", "dict", tensions_doc)
      .kept("system", "System | Scene", "as it was given");
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
