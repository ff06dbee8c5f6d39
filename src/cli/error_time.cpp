#include <fmt/format.h>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "report/error_time_table.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

std::vector<Method> read_methods(const std::vector<std::string>& names) {
  if (names.empty()) return {Method::Rattle, Method::Rk4, Method::Dopri5, Method::Dop853, Method::Taylor};
  std::vector<Method> methods;
  for (const std::string& name : names) {
    try {
      methods.push_back(method_from_name(name));
    } catch (const InputError& error) {
      throw InputError("--methods", error.what());
    }
    if (methods.back() == Method::Auto) throw InputError("--methods", "auto is a choice among methods; name one");
  }
  return methods;
}

}  // namespace

ExitCode execute(const ErrorTimeOptions& options) {
  const scene::Scene scene = scene::load_moving_scene(options.scene, options.overrides);
  const std::vector<Method> methods = read_methods(options.methods);
  const auto say = [&](const std::string& line) {
    if (!options.quiet) fmt::print(stderr, "{}\n", line);
  };
  std::optional<scene::ReferenceState> reference;
  if (options.reference) reference = scene::read_reference_state(*options.reference, scene.system, scene.t_end);
  const report::ErrorTimeTable table = naming_file(options.scene, [&] {
    return report::measure_error_time(scene, methods, reference ? &*reference : nullptr, say);
  });
  if (!table.rows.empty()) {
    const std::string no_picture = report::write_error_time(choose_folder(options.out, scene), table);
    fmt::print("{}", report::format_error_time(table));
    if (!no_picture.empty()) say(no_picture);
  }
  if (table.outcome.ok()) return ExitCode::Done;
  print_message(options.scene.string() + ": " + table.outcome.what);
  return ExitCode::NoAnswer;
}

}  // namespace tanor::cli
