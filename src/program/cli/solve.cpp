#include <utility>
#include <vector>

#include <tanor/enum_names.hpp>

#include "cli/command_line.hpp"
#include "cli/folder_lock.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "report/shared_parts.hpp"
#include "report/solution.hpp"
#include "report/words.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

namespace {

void write(const Options& options, const report::Solution& solution) {
  if (options.out) report::write_solution(*options.out, solution);
  if (!options.out || options.json) report::print_solution(solution);
}

report::Solution describe_problem(const scene::Scene& scene, const Dynamics& dynamics) {
  report::Solution solution;
  solution.num_points = dynamics.num_points();
  solution.left_out = report::list_left_out(scene.left_out, dynamics.plan().left_out);
  solution.units = dynamics.system().units;
  solution.groups = report::list_groups(dynamics.system());
  solution.form = name_of(dynamics.plan().form);
  return solution;
}

}  // namespace

ExitCode execute_solve(const Options& options) {
  scene::Scene scene = prepare(scene::load_scene(options.scene));
  if (options.out) {
    require_free(fs::absolute(*options.out).parent_path());
    require_not_read(*options.out, scene.files);
  }
  std::vector<double> positions = scene.system.positions;
  std::vector<double> velocities = scene.system.velocities;
  velocities.resize(positions.size(), 0.0);
  Dynamics dynamics = naming_file(options.scene, [&] { return Dynamics(std::move(scene.system), scene.solver); });

  report::Solution solution = describe_problem(scene, dynamics);
  const StartReport start = naming_file(options.scene, [&] {
    return dynamics.start({.time = scene.t_start, .positions = positions, .velocities = velocities},
                          scene.motion.start);
  });
  // An incomplete answer has null in place of what was not found.
  if (!start.outcome.ok()) {
    write(options, solution);
    return tell(options.scene, start.outcome.what);
  }
  solution.positions = positions;
  solution.velocities = velocities;

  const std::size_t size = positions.size();
  const bool has_friction = !dynamics.system().friction.empty();
  std::vector<double> friction(has_friction ? size : 0);
  const StateView state{.time = scene.t_start, .positions = positions, .velocities = velocities};
  const SolveReport report = dynamics.solve(state, {.friction_forces = friction});
  if (has_friction) solution.friction_report = report.friction;
  if (!report.outcome.ok()) {
    write(options, solution);
    return tell(options.scene, report.outcome.what);
  }
  tanor::Solution found = dynamics.solution(state);
  solution.accelerations = found.accelerations;
  if (report::has_multipliers(dynamics.plan())) solution.multipliers = found.multipliers;
  solution.rank = dynamics.rank(state);
  if (const std::string redundancy = report::describe_redundancy(*solution.rank); !redundancy.empty() && !options.quiet)
    print_message(options.scene.string() + ": " + redundancy);
  solution.reactions = found.reactions;
  solution.support_forces = found.support_forces;
  if (has_friction) solution.friction = friction;
  if (!found.self_stress.empty()) solution.self_stress = found.self_stress;
  solution.observed = observe(dynamics.system(), scene.observables, found, friction);
  // A certificate needs the memory.
  for (std::vector<double>* const array : {&found.positions, &found.velocities}) *array = std::vector<double>();
  if (scene.certificate.when != scene::CertificatePolicy::When::Off) solution.certificate = dynamics.certify(state);

  const Split split = dynamics.split(state);
  if (split.outcome.ok()) solution.split = split;
  const ReactionsByCause by_cause = dynamics.reactions_by_cause(state);
  if (by_cause.outcome.ok()) solution.reactions_by_cause = by_cause.parts;
  write(options, solution);
  if (!split.outcome.ok()) return tell(options.scene, split.outcome.what);
  if (!solution.certificate || solution.certificate->passed()) return ExitCode::Done;
  return tell(options.scene, solution.certificate->line());
}

}  // namespace tanor::cli
