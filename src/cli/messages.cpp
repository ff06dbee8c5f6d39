#include "cli/messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <new>

#include "cli/machine.hpp"

namespace tanor::cli {

void print_message(const std::string& message) {
  std::string line = "tanor: " + message;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  std::fputs((line + '\n').c_str(), stderr);
}

void print(std::string_view key, const std::string& value) {
  fmt::print("{:<24} {}\n", fmt::format("{}:", key), value);
}

ExitCode tell(const std::filesystem::path& scene, const std::string& why) {
  print_message(scene.string() + ": " + why);
  return ExitCode::NoAnswer;
}

scene::Scene prepare(scene::Scene scene) {
  for (const std::string& each : scene.old_names) print_message(scene.file.string() + ": " + each);
  require_threads(scene.solver.threads);
  return scene;
}

std::string describe(const InputError& error) {
  return error.where().empty() ? error.what() : error.where() + ": " + error.what();
}

Failure describe_current_exception() {
  try {
    throw;
  } catch (const InputError& error) {
    return {ExitCode::BadInput, describe(error)};
  } catch (const std::bad_alloc&) {
    return {ExitCode::MachineFailure, "out of memory"};
  } catch (const std::exception& error) {
    return {ExitCode::MachineFailure, error.what()};
  } catch (...) {
    return {ExitCode::MachineFailure, "unknown failure"};
  }
}

}  // namespace tanor::cli
