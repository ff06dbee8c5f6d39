#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>

#include <tanor/dynamics.hpp>

#include "cli/command_line.hpp"
#include "cli/cost.hpp"
#include "cli/messages.hpp"
#include "report/friction_parts.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

/// "rods (rod), rail (line)"
template <class Entries>
std::string list_entries(const Entries& entries) {
  std::string list;
  for (const auto& entry : entries) {
    const std::string name = std::visit([](const auto& group) { return group.name; }, entry);
    list += list.empty() ? "" : ", ";
    list += name.empty() ? std::string(kind_name(entry)) : fmt::format("{} ({})", name, kind_name(entry));
  }
  return list.empty() ? "none" : list;
}

std::string describe_bytes(double bytes) {
  constexpr std::array units{"B", "kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  for (; bytes >= 1000.0 && unit + 1 < units.size(); ++unit) bytes /= 1000.0;
  return fmt::format("{:.3g} {}", bytes, units[unit]);
}

/// "tangent: 1.2e+03 flops an instant; normal 4.5e+06"
std::string describe_form(const PlanSummary& plan, Form wanted) {
  const bool is_tangent = plan.form == Form::Tangent;
  const double own = is_tangent ? plan.tangent_flops : plan.normal_flops;
  const double other = is_tangent ? plan.normal_flops : plan.tangent_flops;
  const std::string form = fmt::format("{}: {:.3g} flops an instant", is_tangent ? "tangent" : "normal", own);
  if (plan.equations == 0) return form + (is_tangent ? "; no constraints are given" : "");
  if (plan.coordinates == 0) return form + "; no coordinates are given";
  return form + fmt::format("; {} {:.3g}, {}", is_tangent ? "normal" : "tangent", other,
                            wanted == Form::Auto || wanted == Form::Both ? "the cheaper one is taken" : "asked for");
}

std::string describe_motion(const scene::Scene& scene, const ChosenMethod& chosen) {
  const std::string end = scene.t_end > 0.0 ? fmt::format(" to t = {} s", scene.t_end) : "; no t_end";
  const bool has_step = scene.motion.step > 0.0, has_atol = scene.motion.atol > 0.0;
  const std::string step = has_step   ? fmt::format("step {} s", scene.motion.step)
                           : has_atol ? fmt::format("rtol {}, atol {}", scene.motion.rtol, scene.motion.atol)
                                      : fmt::format("rtol {}, atol 1e-10 of the size", scene.motion.rtol);
  const std::string reason = chosen.reason.empty() ? "" : fmt::format(" ({})", chosen.reason);
  return fmt::format("{}{}, {}{}", name_of(chosen.method), reason, step, end);
}

std::string describe_step(const RunCost& cost) {
  return fmt::format("{} solves, {} factorizations, about {:.2g} s on one thread", cost.solves, cost.factorizations,
                     cost.seconds);
}

}  // namespace

ExitCode execute(const InfoOptions& options) {
  scene::Scene scene = prepare(scene::load_scene(options.scene));
  const std::string constraints = list_entries(scene.system.constraints);
  const std::string coordinates = list_entries(scene.system.coordinates);
  const std::string forces = list_entries(scene.system.forces);
  const Form wanted = scene.solver.form;
  const Dynamics dynamics = naming_file(options.scene, [&] { return Dynamics(std::move(scene.system), scene.solver); });
  const PlanSummary& plan = dynamics.plan();
  const std::size_t num_points = dynamics.num_points();
  const ChosenMethod chosen = choose_method(scene.motion, dynamics);
  const bool is_certified = scene.certificate.when != scene::CertificatePolicy::When::Off;
  const PlannedRun run{plan, num_points, is_certified, scene.motion};
  const RunCost cost = predict_run(run, chosen.method);

  print("scene", scene.name);
  print("source", scene.source);
  print("points", fmt::format("{}", num_points));
  print("supports", fmt::format("{}", plan.supports));
  print("equations", fmt::format("{}", plan.equations));
  if (plan.coordinates > 0) {
    print("degrees of freedom", fmt::format("{}, as many as coordinates", plan.coordinates));
  } else {
    print("degrees of freedom", fmt::format("{}, if all equations are independent",
                                            3 * static_cast<std::ptrdiff_t>(num_points - plan.supports) -
                                                static_cast<std::ptrdiff_t>(plan.equations)));
  }
  print("constraints", constraints);
  if (plan.coordinates > 0) print("coordinates", coordinates);
  print("forces", forces);
  print("friction", report::describe_friction(dynamics.system()));
  print("islands", fmt::format("{}, in {} part{}", plan.islands, plan.parts, plan.parts == 1 ? "" : "s"));
  print("form", describe_form(plan, wanted));
  print("linear solver", plan.linear_solver_reason.empty()
                             ? plan.linear_solver()
                             : fmt::format("{} ({})", plan.linear_solver(), plan.linear_solver_reason));
  print("ordering", plan.ordering());
  print("factorization", plan.factorization());
  print("nonzeros", fmt::format("{} in {}, {} in L", plan.pattern_nonzeros, plan.form == Form::Tangent ? "H" : "S",
                                plan.factor_nonzeros));
  print("motion", describe_motion(scene, chosen));
  print("predicted factorization", fmt::format("{:.3g} flops", plan.factor_flops));
  print("predicted memory", describe_bytes(cost.bytes));
  print("predicted step", describe_step(cost));
  for (const MethodTraits& each : methods()) {
    if (each.method == Method::Auto || each.method == chosen.method) continue;
    const RunCost other = predict_run(run, each.method);
    print(fmt::format("predicted {}", each.name),
          fmt::format("{}, {}", describe_step(other), describe_bytes(other.bytes)));
  }
  for (const std::string& what : plan.left_out) print("left out", what);
  return ExitCode::Done;
}

}  // namespace tanor::cli
