#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "cli/process.hpp"
#include "report/error_time.hpp"
#include "report/terminal.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

std::vector<Method> read_methods(const std::vector<std::string>& names) {
  std::vector<Method> result;
  if (names.empty()) {
    for (const MethodTraits& each : methods()) {
      if (each.is_compared) result.push_back(each.method);
    }
  }
  for (const std::string& name : names) {
    try {
      result.push_back(method_from_name(name));
    } catch (const InputError& error) {
      throw InputError("--methods", error.what());
    }
  }
  return result;
}

/// Returns each method once. `auto` stands for the scene's own method: the one that it names, or the one that suits it
/// (an implicit one for a stiff scene).
std::vector<Method> choose_methods(const std::vector<Method>& wanted, const scene::Scene& scene) {
  std::vector<Method> methods;
  for (Method method : wanted) {
    if (method == Method::Auto) method = choose_method(scene.motion, Dynamics(scene.system, scene.solver)).method;
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) methods.push_back(method);
  }
  return methods;
}

}  // namespace

ExitCode execute_error_time(const Options& options) {
  const scene::Scene scene = prepare(scene::load_moving_scene(options.scene, options.overrides));
  for (std::size_t k = 0; k < scene.events.size(); ++k)
    if (scene.events[k].action == EventAction::Stop)
      throw InputError(
          fmt::format("{}: /events/{}/do", scene.file.string(), k),
          "error-time compares states at t_end, and \"stop\" ends each method's run at an instant of its own");
  const std::vector<Method> wanted = read_methods(options.methods);
  const auto say = [&](const std::string& line) {
    if (!options.quiet) fmt::print(stderr, "{}\n", report::wrap(line, 2, report::Terminal::of(stderr).width(), 0));
  };
  std::optional<scene::ReferenceState> reference;
  if (options.reference) reference = scene::read_reference_state(*options.reference, scene.system, scene.t_end);
  const std::vector<Method> methods = naming_file(options.scene, [&] { return choose_methods(wanted, scene); });
  catch_interrupts();  // before there is a folder that a signal would leave behind
  const OutputFolder folder(choose_folder(options.out, scene.file), "error-time");
  const report::ErrorTimeTable table = naming_file(options.scene, [&] {
    return report::measure_error_time(scene, methods, reference ? &*reference : nullptr,
                                      {.say = say, .goes_on = [] { return !caught_interrupt(); }});
  });
  if (!table.rows.empty()) {
    const std::string no_picture = report::write_error_time(folder.path(), table);
    options.json ? print_json(report::describe_error_time(table)) : print_lines(report::format_error_time(table));
    if (!no_picture.empty()) say(no_picture);
  }
  if (const auto interrupt = caught_interrupt(); interrupt && !table.outcome.ok()) {
    (void)tell(options.scene, fmt::format("{} came; rows are missing", interrupt->name));
    return interrupt->code;
  }
  if (table.outcome.ok()) return ExitCode::Done;
  return tell(options.scene, table.outcome.what);
}

}  // namespace tanor::cli
