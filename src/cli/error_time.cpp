#include <fmt/format.h>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "report/error_time.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

namespace {

std::vector<Method> read_methods(const std::vector<std::string>& names) {
  if (names.empty()) return {Method::Rattle, Method::Rk4, Method::Dopri5};
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
  scene::Scene scene = scene::load_scene(options.scene);
  if (options.t_end) scene.t_end = *options.t_end;
  if (options.step) scene.motion.step = *options.step;
  if (options.threads) scene.solver.threads = *options.threads;
  if (scene.t_end <= 0.0) {
    throw InputError(options.scene.string() + ": /motion/t_end", "is missing; give it there or with --t-end (s, > 0)");
  }
  const std::vector<Method> methods = read_methods(options.methods);
  const auto say = [&](const std::string& line) {
    if (!options.quiet) fmt::print(stderr, "{}\n", line);
  };
  const report::ErrorTimeTable table =
      naming_file(options.scene, [&] { return report::measure_error_time(scene, methods, say); });
  report::write_error_time(options.out.value_or(scene.name + ".out"), table);
  fmt::print("{}", report::format_error_time(table));
  return ExitCode::Done;
}

}  // namespace tanor::cli
