#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>
#include <tanor/enum_names.hpp>

#include "base/text.hpp"
#include "cli/command_line.hpp"
#include "cli/cost.hpp"
#include "cli/messages.hpp"
#include "report/field_json.hpp"
#include "report/shared_parts.hpp"
#include "report/terminal.hpp"
#include "report/words.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {
using namespace detail;

namespace {

using report::Json;

/// The predicted cost of a method.
struct Prediction {
  std::string_view method;
  RunCost cost;
};

/// The facts about a scene that was planned.
struct Needs {
  const scene::Scene& scene;  ///< without its system
  const System& system;
  const PlanSummary& plan;
  ChosenMethod chosen;
  std::vector<Prediction> predictions;  ///< the chosen method first

  std::ptrdiff_t degrees_of_freedom() const {
    if (plan.coordinates > 0) return static_cast<std::ptrdiff_t>(plan.coordinates);
    return 3 * static_cast<std::ptrdiff_t>(plan.points - plan.supports) - static_cast<std::ptrdiff_t>(plan.equations);
  }
};

/// Returns "rods (rod), rail (line)" or the like.
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

/// Returns "1.2 ms" or the like: three digits and a unit that keeps them short.
std::string with_unit(double number, double step, std::span<const char* const> units) {
  std::size_t unit = 0;
  for (; number >= step && unit + 1 < units.size(); ++unit) number /= step;
  return fmt::format("{:.3g} {}", number, units[unit]);
}

std::string describe_bytes(double bytes) {
  static constexpr std::array units{"B", "kB", "MB", "GB", "TB"};
  return with_unit(bytes, 1000.0, units);
}

std::string describe_seconds(double seconds) {
  static constexpr std::array units{"ns", "us", "ms"};
  return seconds < 1.0 ? with_unit(1e9 * seconds, 1000.0, units) : fmt::format("{:.3g} s", seconds);
}

/// Returns "tangent: 1.2e+03 flops an instant; normal 4.5e+06" or the like.
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

std::string describe_motion(const scene::Scene& scene, const ChosenMethod& chosen, const std::string& unit) {
  const std::string end =
      scene.has_end() ? " to t = " + report::with_unit(detail::text(scene.t_end), unit) : "; no t_end";
  const bool has_step = scene.motion.step > 0.0, has_atol = scene.motion.atol > 0.0;
  const std::string step =
      has_step   ? "step " + report::with_unit(detail::text(scene.motion.step), unit)
      : has_atol ? fmt::format("rtol {}, atol {}", detail::text(scene.motion.rtol), detail::text(scene.motion.atol))
                 : fmt::format("rtol {}, atol 1e-10 of the size", detail::text(scene.motion.rtol));
  const std::string reason = chosen.reason.empty() ? "" : fmt::format(" ({})", chosen.reason);
  return fmt::format("{}{}, {}{}", name_of(chosen.method), reason, step, end);
}

std::vector<Prediction> predict(const scene::Scene& scene, const PlanSummary& plan, std::size_t num_points,
                                Method chosen) {
  const bool is_certified = scene.certificate.when != scene::CertificatePolicy::When::Off;
  const PlannedRun run{plan, num_points, is_certified, scene.motion};
  std::vector<Prediction> predictions{{name_of(chosen), predict_run(run, chosen)}};
  for (const MethodTraits& each : methods()) {
    if (each.method != Method::Auto && each.method != chosen)
      predictions.push_back({each.name, predict_run(run, each.method)});
  }
  return predictions;
}

void print_system(const Needs& needs) {
  const PlanSummary& plan = needs.plan;
  print_heading("System");
  print("points", fmt::format("{}", plan.points));
  print("supports", fmt::format("{}", plan.supports));
  print("equations", fmt::format("{}", plan.equations));
  print("degrees of freedom",
        fmt::format("{}, {}", needs.degrees_of_freedom(),
                    plan.coordinates > 0 ? "as many as coordinates" : "if all equations are independent"));
  print("constraints", list_entries(needs.system.constraints));
  if (plan.coordinates > 0) print("coordinates", list_entries(needs.system.coordinates));
  print("forces", list_entries(needs.system.forces));
  print("friction", report::describe_friction(needs.system));
  print("islands", fmt::format("{}, in {}", plan.islands, report::count_in_words(plan.parts, "part")));
}

void print_solution(const Needs& needs) {
  const PlanSummary& plan = needs.plan;
  print_heading("How it is solved");
  print("form", describe_form(plan, needs.scene.solver.form));
  print("linear solver", plan.linear_solver_reason.empty()
                             ? plan.linear_solver()
                             : fmt::format("{} ({})", plan.linear_solver(), plan.linear_solver_reason));
  print("ordering", plan.ordering());
  print("factorization", fmt::format("{}, {:.3g} flops", plan.factorization(), plan.factor_flops));
  print("nonzeros", fmt::format("{} in {}, {} in L", plan.pattern_nonzeros, plan.form == Form::Tangent ? "H" : "S",
                                plan.factor_nonzeros));
  print("motion", describe_motion(needs.scene, needs.chosen, needs.system.units.time));
}

void print_costs(const Needs& needs) {
  const report::Terminal terminal = report::Terminal::of(stdout);
  print_heading("What it will cost");
  fmt::print("{}\n", terminal.dim("within a factor of 2, on one thread of a 2.6 GHz machine"));
  fmt::print("{:<18}{:>9}{:>8}{:>9}{:>10}\n", "method", "a step", "solves", "factors", "memory");
  for (const auto& [method, cost] : needs.predictions) {
    const bool is_chosen = &cost == &needs.predictions[0].cost;
    const std::string row = fmt::format("{:<18}{:>9}{:>8}{:>9}{:>10}", method, describe_seconds(cost.seconds),
                                        cost.solves, cost.factorizations, describe_bytes(cost.bytes));
    fmt::print("{}{}\n", is_chosen ? terminal.bold(row) : row, is_chosen ? "  this run" : "");
  }
}

Json as_json(const Needs& needs) {
  const PlanSummary& plan = needs.plan;
  Json predicted = Json::object();
  for (const auto& [method, cost] : needs.predictions) {
    predicted[std::string(method)] =
        report::json_of_members<&RunCost::solves, &RunCost::factorizations, &RunCost::seconds, &RunCost::bytes>(cost);
  }
  Json json{{"scene", needs.scene.name}, {"source", needs.scene.source}};
  json.update(report::json_of(plan));
  json.update({{"degrees_of_freedom", needs.degrees_of_freedom()},
               {"constraints", list_entries(needs.system.constraints)},
               {"forces", list_entries(needs.system.forces)},
               {"friction", report::describe_friction(needs.system)},
               {"method", name_of(needs.chosen.method)},
               {"method_reason", report::json_or_null(needs.chosen.reason)},
               {"t_end", needs.scene.has_end() ? Json(needs.scene.t_end) : Json()},
               {"predicted", predicted},
               {"left_out", report::list_left_out(needs.scene.left_out, plan.left_out)}});
  return json;
}

}  // namespace

ExitCode execute_info(const Options& options) {
  scene::Scene scene = prepare(scene::load_scene(options.scene));
  const Dynamics dynamics = naming_file(options.scene, [&] { return Dynamics(std::move(scene.system), scene.solver); });
  const ChosenMethod chosen = choose_method(scene.motion, dynamics);
  const Needs needs{.scene = scene,
                    .system = dynamics.system(),
                    .plan = dynamics.plan(),
                    .chosen = chosen,
                    .predictions = predict(scene, dynamics.plan(), dynamics.num_points(), chosen.method)};
  if (options.json) {
    print_json(as_json(needs));
    return ExitCode::Done;
  }
  print("scene", scene.name);
  print("source", scene.source);
  print_system(needs);
  print_solution(needs);
  print_costs(needs);
  const std::vector<std::string> left_out = report::list_left_out(scene.left_out, needs.plan.left_out);
  if (!left_out.empty()) print_heading("What this scene does not need");
  for (const std::string& what : left_out) print("left out", what);
  return ExitCode::Done;
}

}  // namespace tanor::cli
