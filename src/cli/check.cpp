#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "report/friction_parts.hpp"
#include "report/words.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

using report::in_words;

void print_start(Dynamics* dynamics, const std::vector<double>& positions, const std::vector<double>& velocities) {
  print("positions violate",
        fmt::format("{} (largest |xi|/|gradient|/length)",
                    in_words(dynamics->position_violation({.time = 0.0, .positions = positions}), "{:.2e}")));
  print("velocities violate",
        fmt::format(
            "{} (largest |K'v + xi_t|/|gradient| over the velocity scale)",
            in_words(dynamics->velocity_violation({.time = 0.0, .positions = positions, .velocities = velocities}),
                     "{:.2e}")));
}

void print_rank(const RankReport& rank, std::size_t num_equations) {
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
          fmt::format(
              "{} points are held rigid by prestress, by rods under tension between supports; a run lets them stand",
              rank.prestress_rigid_points.size()));
}

void print_certificate(const Certificate& certificate) {
  for (const CertificateCheck& check : certificate.checks) {
    print("identity", fmt::format("{:<40} {} (rounding explains {}){}", check.identity, in_words(check.error, "{:.1e}"),
                                  in_words(check.allowed, "{:.1e}"),
                                  check.error <= check.allowed ? "" : " FAILS at " + check.where));
  }
  for (const std::string& what : certificate.left_out) print("left out", what);
  print("certificate", certificate.line());
}

}  // namespace

ExitCode execute(const CheckOptions& options) {
  scene::Scene scene = prepare(scene::load_scene(options.scene));
  std::vector<double> positions = scene.system.positions;
  std::vector<double> velocities = scene.system.velocities;
  velocities.resize(positions.size(), 0.0);
  Dynamics dynamics = naming_file(options.scene, [&] { return Dynamics(std::move(scene.system), scene.solver); });
  print("scene", scene.name);
  const bool has_friction = !dynamics.system().friction.empty();
  if (has_friction) print("friction", report::describe_friction(dynamics.system()));
  print_start(&dynamics, positions, velocities);
  const StartReport start = naming_file(options.scene, [&] {
    return dynamics.start({.time = 0.0, .positions = positions, .velocities = velocities}, scene.motion.start);
  });
  const auto fail = [&](const Outcome& outcome) {
    print("result", outcome.what);
    return tell(options.scene, outcome.what);
  };
  if (!start.outcome.ok()) return fail(start.outcome);
  print("start", fmt::format("corrected by {} m and {} m/s", in_words(start.position_correction, "{:.2g}"),
                             in_words(start.velocity_correction, "{:.2g}")));

  const StateView state{.time = 0.0, .positions = positions, .velocities = velocities};
  const SolveReport solved = dynamics.solve(state);
  if (!solved.outcome.ok()) return fail(solved.outcome);
  print_rank(dynamics.rank(state, true), dynamics.num_equations());
  print("reciprocal condition", fmt::format("{} (of the scaled {})", in_words(solved.reciprocal_condition, "{:.2e}"),
                                            dynamics.plan().form == Form::Tangent ? "H = A'MA" : "S = K'M^-1K"));
  if (has_friction) print("friction found", report::describe_friction(solved.friction));
  print("residual", fmt::format("{} ({} refinements)", in_words(solved.residual, "{:.1e}"), solved.refinements));
  const Certificate certificate = dynamics.certify(state);
  print_certificate(certificate);
  if (certificate.passed()) return ExitCode::Done;
  return tell(options.scene, certificate.line());
}

}  // namespace tanor::cli
