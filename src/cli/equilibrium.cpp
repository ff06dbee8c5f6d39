#include <fmt/format.h>

#include <cmath>
#include <string>

#include <tanor/equilibrium.hpp>

#include "cli/command_line.hpp"
#include "cli/folder_lock.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "report/equilibrium.hpp"
#include "report/output_file.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

/// "stable after 7 iterations, residual 3e-15 N (6e-16 of the largest force)"
std::string describe(const EquilibriumResult& found) {
  const double relative = found.largest_force > 0.0 ? found.residual_force / found.largest_force : 0.0;
  std::string line = fmt::format("{} after {} iterations, residual {:.1e} N ({:.1e} of the largest force)",
                                 report::name_of(found.status), found.iterations, found.residual_force, relative);
  if (found.lowest_omega2 > 0.0) line += fmt::format(", lowest omega {:.6g} rad/s", std::sqrt(found.lowest_omega2));
  if (found.zero_modes > 0)
    line += fmt::format(", {} zero modes, {} of them rigid", found.zero_modes, found.rigid_zero_modes);
  if (found.self_stress_states > 0) line += fmt::format(", {} states of self-stress", found.self_stress_states);
  return line;
}

}  // namespace

ExitCode execute(const EquilibriumCommand& command) {
  const scene::Scene scene = prepare(scene::load_scene(command.scene));
  EquilibriumOptions options = scene.equilibrium;
  options.solver = scene.solver;
  const EquilibriumResult found = naming_file(command.scene, [&] { return find_equilibrium(scene.system, options); });

  const std::filesystem::path directory = choose_folder(command.out, scene);
  report::make_folder(directory);
  const FolderLock lock(directory, "equilibrium");
  report::write_equilibrium(directory, scene, found);
  if (command.json) print_json_file(directory / "summary.json");
  if (!found.outcome.ok()) return tell(command.scene, found.outcome.what);
  if (!command.json) fmt::print("{}; results in {}\n", describe(found), directory.string());
  return ExitCode::Done;
}

}  // namespace tanor::cli
