#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/text.hpp"
#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "report/shared_parts.hpp"
#include "report/terminal.hpp"
#include "report/words.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

using report::in_words;
using report::Json;
using report::with_unit;

/// The findings until something failed, if something did.
struct Findings {
  std::string scene, friction;  ///< friction is empty if there is none
  Units units;
  double time = 0.0;
  Form form = Form::Normal;
  std::size_t equations = 0;
  double position_violation = 0.0, velocity_violation = 0.0;
  std::optional<StartReport> start;
  std::optional<SolveReport> solved;
  std::optional<RankReport> rank;
  std::optional<Certificate> certificate;
  std::string trouble;  ///< why there is no complete answer
};

Findings find(scene::Scene* scene) {
  Findings found;
  found.scene = scene->name;
  found.units = scene->system.units;
  found.time = scene->t_start;
  std::vector<double> positions = scene->system.positions, velocities = scene->system.velocities;
  velocities.resize(positions.size(), 0.0);
  Dynamics dynamics(std::move(scene->system), scene->solver);
  if (!dynamics.system().friction.empty()) found.friction = report::describe_friction(dynamics.system());
  found.form = dynamics.plan().form;
  found.equations = dynamics.num_equations();
  found.position_violation = dynamics.position_violation({.time = scene->t_start, .positions = positions});
  found.velocity_violation =
      dynamics.velocity_violation({.time = scene->t_start, .positions = positions, .velocities = velocities});

  const StartReport start =
      dynamics.start({.time = scene->t_start, .positions = positions, .velocities = velocities}, scene->motion.start);
  found.trouble = start.outcome.what;
  if (!start.outcome.ok()) return found;
  found.start = start;
  const StateView state{.time = scene->t_start, .positions = positions, .velocities = velocities};
  const SolveReport solved = dynamics.solve(state);
  found.trouble = solved.outcome.what;
  if (!solved.outcome.ok()) return found;
  found.solved = solved;
  found.rank = dynamics.rank(state, true);
  found.certificate = dynamics.certify(state);
  if (!found.certificate->passed()) found.trouble = found.certificate->line();
  return found;
}

void print_start(const Findings& found, bool is_verbose) {
  print_heading("Start");
  print("positions violate",
        fmt::format("{} ({})", in_words(found.position_violation, "{:.2e}"),
                    is_verbose ? "largest |xi|/|gradient|/length" : "largest, relative to lengths"));
  print("velocities violate", fmt::format("{} ({})", in_words(found.velocity_violation, "{:.2e}"),
                                          is_verbose ? "largest |K'v + xi_t|/|gradient| over the velocity scale"
                                                     : "largest, relative to the speed of the scene"));
  if (!found.start) return;
  print("start", fmt::format("corrected by {} and {}",
                             with_unit(in_words(found.start->position_correction, "{:.2g}"), found.units.length),
                             with_unit(in_words(found.start->velocity_correction, "{:.2g}"),
                                       found.units.letters(Dimension::Velocity))));
}

void print_rank(const RankReport& rank, std::size_t num_equations) {
  print_heading("Rank");
  if (rank.is_known) print("rank", fmt::format("{} of {} equations", rank.rank, num_equations));
  print("degrees of freedom", fmt::format("{}", rank.degrees_of_freedom));
  if (rank.smallest_singular_value > 0.0)
    print("smallest singular value",
          fmt::format("{:.3g} (of the independent unit gradients)", rank.smallest_singular_value));
  for (const RowDependence& dependence : rank.dependences) {
    std::string line = dependence.what;
    if (!dependence.terms.empty() && dependence.terms.size() <= 6) {
      line += " with";
      for (const RowDependence::Term& term : dependence.terms) line += fmt::format(" {:+.4g}", term.coefficient);
    }
    print("redundant", line);
  }
  if (!rank.prestress_rigid_points.empty())
    print("rigid",
          fmt::format("{} held rigid by prestress, by rods under tension between supports, which stand in a run",
                      report::count_in_words(rank.prestress_rigid_points.size(), "point")));
}

void print_answer(const Findings& found, bool is_verbose) {
  print_heading("Answer at t = " + with_unit(detail::text(found.time), found.units.time));
  const char* const matrix = found.form == Form::Tangent ? " (of the scaled H = A'MA)" : " (of the scaled S = K'M^-1K)";
  print("reciprocal condition",
        in_words(found.solved->reciprocal_condition, "{:.2e}") + (is_verbose ? matrix : " (0: singular)"));
  if (!found.friction.empty()) print("friction found", report::describe_friction(found.solved->friction));
  print("residual",
        fmt::format("{} ({} refinements)", in_words(found.solved->residual, "{:.1e}"), found.solved->refinements));
}

void print_certificate(const Certificate& certificate, bool is_verbose) {
  print_heading("Certificate");
  print_checks(certificate, is_verbose);
  for (const std::string& what : certificate.left_out) print("left out", what);
  print("certificate", certificate.line());
}

Json describe(const RankReport& rank) {
  Json json = report::describe_rank(rank);
  json["smallest_singular_value"] = rank.smallest_singular_value > 0.0 ? Json(rank.smallest_singular_value) : Json();
  json["prestress_rigid_points"] = rank.prestress_rigid_points;
  return json;
}

Json describe(const Findings& found) {
  const auto solved = [&](auto number) { return found.solved ? Json((*found.solved).*number) : Json(); };
  const auto start = [&](auto number) { return found.start ? Json((*found.start).*number) : Json(); };
  Json json{{"scene", found.scene},
            {"friction", report::json_or_null(found.friction)},
            {"equations", found.equations},
            {"start",
             {{"position_violation", found.position_violation},
              {"velocity_violation", found.velocity_violation},
              {"position_correction", start(&StartReport::position_correction)},
              {"velocity_correction", start(&StartReport::velocity_correction)}}}};
  json["rank"] = found.rank ? describe(*found.rank) : Json();
  json["reciprocal_condition"] = solved(&SolveReport::reciprocal_condition);
  json["residual"] = solved(&SolveReport::residual);
  json["refinements"] = solved(&SolveReport::refinements);
  json["friction_report"] = report::describe_friction_report(
      found.solved && !found.friction.empty() ? std::optional(found.solved->friction) : std::nullopt);
  json["certificate"] = report::describe_certificate(found.certificate);
  json["trouble"] = report::json_or_null(found.trouble);
  return json;
}

void print_findings(const Findings& found, bool is_verbose) {
  print("scene", found.scene);
  if (!found.friction.empty()) print("friction", found.friction);
  print_start(found, is_verbose);
  if (found.rank) print_rank(*found.rank, found.equations);
  if (found.solved) print_answer(found, is_verbose);
  if (found.certificate) print_certificate(*found.certificate, is_verbose);
  if (!found.certificate && !found.trouble.empty()) print("result", found.trouble);
}

}  // namespace

ExitCode execute_check(const Options& options) {
  scene::Scene scene = prepare(scene::load_scene(options.scene));
  const Findings found = naming_file(options.scene, [&] { return find(&scene); });
  options.json ? print_json(describe(found)) : print_findings(found, options.verbose);
  return found.trouble.empty() ? ExitCode::Done : tell(options.scene, found.trouble);
}

}  // namespace tanor::cli
