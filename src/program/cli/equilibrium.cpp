#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>
#include <tanor/statics_names.hpp>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "report/equilibrium.hpp"
#include "report/html_page.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"
#include "report/words.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

namespace {

using report::with_unit;

/// Returns "stable after 7 iterations, residual 3e-15 N (the largest force is 4.9 N)" or the like.
std::string describe(const EquilibriumResult& found, const Units& units) {
  if (std::isnan(found.largest_force)) return "stable: no point can move";
  std::string line = fmt::format("{} after {}, residual {} (the largest force is {})", name_of(found.stability.status),
                                 report::count_in_words(found.search.iterations, "iteration"),
                                 with_unit(fmt::format("{:.2g}", found.residual_force), units.force),
                                 with_unit(fmt::format("{:.4g}", found.largest_force), units.force));
  if (found.stability.lowest_omega2 > 0.0)
    line += ", lowest omega " + with_unit(fmt::format("{:.4g}", std::sqrt(found.stability.lowest_omega2)),
                                          report::per_time("rad", units.time));
  if (found.stability.zero_modes > 0)
    line += fmt::format(", {}, {} of them rigid", report::count_in_words(found.stability.zero_modes, "zero mode"),
                        found.stability.rigid_zero_modes);
  if (const auto open = std::ranges::count(found.open, true); open > 0)
    line += fmt::format(", {} open", report::count_in_words(open, "one-sided constraint"));
  if (found.self_stress_states > 0)
    line += fmt::format(", self-stress of {}", report::count_in_words(found.self_stress_states, "state"));
  return line;
}

/// Writes the page, and the frame of pictures.
void show(const fs::path& directory, const scene::Scene& scene, const EquilibriumResult& found,
          std::span<const Observed> observed, const std::optional<Modes>& vibrations) {
  report::Rest rest{scene.name, "no equilibrium", {}, found.left_out, scene.system.cell, observed, {}};
  if (found.outcome.ok())
    rest.said = describe(found, scene.system.units);
  else
    rest.warnings.push_back(found.outcome.what);
  if (vibrations && vibrations->outcome.ok()) rest.modes = &*vibrations;
  rest.state = state_at_rest(found, scene.equilibrium.at);
  report::write_frame_at_rest(directory, scene.system, rest.state);
  report::write_rest_page(directory, scene.system, rest);
}

std::vector<double> multipliers_of_closed(const EquilibriumResult& found) {
  std::vector<double> result;
  for (std::size_t row = 0; row < found.multipliers.size(); ++row) {
    if (found.open.empty() || !found.open[row]) result.push_back(found.multipliers[row]);
  }
  return result;
}

}  // namespace

ExitCode execute_equilibrium(const Options& options) {
  const scene::Scene scene = prepare(scene::load_scene(options.scene));
  const EquilibriumOptions search = scene::equilibrium_options(scene);
  const OutputFolder folder(choose_folder(options.out, scene.file, ".equilibrium.out"), "equilibrium");
  const fs::path& directory = folder.path();
  require_no_run(directory, "equilibrium");
  require_results_not_read(directory, scene.files);
  require_not_read(directory / report::scene_at_rest_name, scene.files);
  EquilibriumResult found = naming_file(options.scene, [&] { return find_equilibrium(scene.system, search); });
  found.left_out = list_left_out_at_rest(scene, found.left_out);
  const System held = without_open_constraints(scene.system, found.open);
  std::optional<Modes> vibrations;
  Outcome buckled;
  if (found.outcome.ok()) {
    naming_file(options.scene, [&] {
      if (options.num_modes) {
        ModesOptions wanted = scene::modes_options(scene);
        wanted.count = *options.num_modes;
        const std::vector<double> multipliers = multipliers_of_closed(found);
        // Otherwise modes() says whether they depend on a self-stress.
        const bool are_known = std::ranges::none_of(multipliers, [](double each) { return std::isnan(each); });
        if (found.self_stress_states == 0 && are_known) wanted.multipliers = multipliers;
        vibrations = modes(held, found.positions, wanted);
      }
      if (scene.buckling_loads.empty()) return;
      const Buckling buckling = find_buckling(held, found.positions, scene::buckling_options(scene));
      buckled = buckling.outcome;
      if (buckled.ok()) found.buckling_load_factor = buckling.load_factor;
    });
  }

  std::vector<Observed> observed;
  if (found.outcome.ok())
    observed = observe(scene.system, scene.observables, state_at_rest(found, scene.equilibrium.at));

  remove_results(directory);
  report::remove_file(directory / report::scene_at_rest_name);  // this search may find no state of rest
  report::write_equilibrium(directory, scene, found, observed, vibrations);
  if (!found.positions.empty()) show(directory, scene, found, observed, vibrations);
  if (options.json) print_json_file(directory / "summary.json");
  if (!found.outcome.ok()) return tell(options.scene, found.outcome.what);
  const std::string page =
      report::write_observables_at_rest(directory, scene.name, describe(found, scene.system.units), observed,
                                        scene.system, scene.equilibrium.at, found.left_out);
  if (!options.json)
    print_page(page),
        print_lines(fmt::format("{}; results in {}", describe(found, scene.system.units), typed(directory)));
  if (vibrations && !vibrations->outcome.ok()) return tell(options.scene, vibrations->outcome.what);
  if (!buckled.ok()) return tell(options.scene, buckled.what);
  return ExitCode::Done;
}

}  // namespace tanor::cli
