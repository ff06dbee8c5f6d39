#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <tanor/dynamics.hpp>
#include <tanor/modes.hpp>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "report/equilibrium.hpp"
#include "report/html_page.hpp"
#include "report/modes.hpp"
#include "report/page.hpp"
#include "report/words.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

namespace {

using report::count_in_words, report::with_unit;

/// Returns "lowest modes 0.123, 0.456, … rad/s" or the like.
std::string describe(const Modes& modes, const Units& units) {
  constexpr std::size_t most_shown = 6;
  const std::string rate = report::per_time("1", units.time);
  std::string text;
  for (std::size_t k = 0; k < std::min(most_shown, modes.count()); ++k) {
    text += fmt::format("{}{:.4g}", k == 0 ? "" : ", ", modes.omega[k]);
    if (!modes.decay.empty())
      text += fmt::format(" (decay {})", with_unit(fmt::format("{:.4g}", modes.decay[k]), rate));
  }
  if (modes.count() > most_shown) text += ", …";
  const auto [count, freedoms] = std::pair(modes.count(), modes.degrees_of_freedom);
  std::string line = modes.decay.empty() ? fmt::format("{} of {}", count, count_in_words(freedoms, "mode"))
                                         : count_in_words(count, "damped mode");
  if (count > 0) line += ": omega = " + with_unit(text, report::per_time("rad", units.time));
  if (modes.zero_modes > 0)
    line += fmt::format("; {} {} 0, {} of them rigid", modes.zero_modes, modes.zero_modes == 1 ? "is" : "are",
                        modes.rigid_zero_modes);
  const std::string growing =
      fmt::format("; unstable: {} {}", modes.unstable_directions, modes.unstable_directions == 1 ? "grows" : "grow");
  if (modes.unstable_directions > 0 && modes.decay.empty())
    line += fmt::format("{} (negative: growth rate{})", growing, rate.empty() ? "" : ", " + rate);
  if (modes.unstable_directions > 0 && !modes.decay.empty())
    line += fmt::format("{}, the fastest by {}", growing,
                        with_unit(fmt::format("{:.4g}", -std::ranges::min(modes.decay)), rate));
  return line;
}

/// Returns the state of rest with its forces. `system` is that of the scene without what has no part in modes.
Solution state_of(const scene::Scene& scene, const Modes& found, System* system) {
  *system = scene.system;
  system->friction.clear();
  const auto is_velocity = [](const std::string& what) { return what.starts_with("velocities"); };
  if (std::ranges::any_of(found.left_out, is_velocity)) system->velocities.clear();
  system->velocities.resize(system->positions.size());
  Solution state = Dynamics(*system, scene.solver).solution({scene.modes.time, system->positions, system->velocities});
  if (!found.multipliers.empty()) {
    state.multipliers = found.multipliers;
    state.has_prestress =
        found.outcome.ok() && std::ranges::any_of(state.multipliers, [](double each) { return std::isnan(each); });
    state.reactions = found.reactions;
    state.support_forces = found.support_forces;
  }
  if (!scene.equilibrium.prestress.empty()) state.self_stress.clear();
  return state;
}

/// Writes the page, and the frame of pictures. Their forces are those at rest.
void show(const fs::path& directory, const scene::Scene& scene, const System& system, const Solution& state,
          std::span<const Observed> observed, const Modes& found) {
  report::Rest rest{scene.name, "no modes", {}, found.left_out, scene.system.cell, observed, {}};
  if (found.outcome.ok())
    rest.said = describe(found, scene.system.units);
  else
    rest.warnings.push_back(found.outcome.what);
  if (found.outcome.ok() && found.count() > 0) rest.modes = &found;
  rest.state = state;
  report::write_frame_at_rest(directory, system, rest.state);
  report::write_rest_page(directory, system, rest);
}

}  // namespace

ExitCode execute_modes(const Options& options) {
  const scene::Scene scene = prepare(scene::load_scene(options.scene));
  ModesOptions wanted = scene::modes_options(scene);
  if (options.num_modes) wanted.count = *options.num_modes;
  const OutputFolder folder(choose_folder(options.out, scene.file, ".modes.out"), "modes");
  const fs::path& directory = folder.path();
  require_no_run(directory, "modes");
  require_results_not_read(directory, scene.files);
  const auto in_scene = [&](const auto& work) { return naming_file(options.scene, work); };
  Modes found = in_scene([&] {
    try {
      return modes(scene.system, scene.system.positions, wanted);
    } catch (const NotAtRest& error) {
      const fs::path at_rest = choose_folder({}, scene.file, ".equilibrium.out") / report::scene_at_rest_name;
      throw InputError(error.where(), fmt::format("{}: tanor equilibrium {}, then tanor modes {}", error.what(),
                                                  typed(options.scene), typed(at_rest)));
    }
  });
  found.left_out = list_left_out_at_rest(scene, found.left_out);
  std::optional<Buckling> buckling;
  if (!scene.buckling_loads.empty())
    buckling =
        in_scene([&] { return find_buckling(scene.system, scene.system.positions, scene::buckling_options(scene)); });

  System system;
  const Solution state = in_scene([&] { return state_of(scene, found, &system); });
  std::vector<Observed> observed;
  if (found.outcome.ok()) observed = observe(system, scene.observables, state);

  remove_results(directory);
  report::write_modes(directory, scene, found, observed, buckling);
  show(directory, scene, system, state, observed, found);
  if (!found.outcome.ok()) return tell(options.scene, found.outcome.what);
  if (options.pictures) report::write_mode_pictures(directory, system, state, found);
  if (options.json) print_json_file(directory / "summary.json");
  const std::string page = report::write_observables_at_rest(directory, scene.name, describe(found, scene.system.units),
                                                             observed, system, scene.modes.time, found.left_out);
  if (!options.json)
    print_page(page),
        print_lines(fmt::format("{}; results in {}", describe(found, scene.system.units), typed(directory)));
  if (!buckling) return ExitCode::Done;
  if (!buckling->outcome.ok()) return tell(options.scene, buckling->outcome.what);
  if (options.json) return ExitCode::Done;
  if (std::isinf(buckling->load_factor))
    fmt::print("buckles at no multiple of the load\n");
  else
    fmt::print("buckles at {:.10g} times the load\n", buckling->load_factor);
  return ExitCode::Done;
}

}  // namespace tanor::cli
