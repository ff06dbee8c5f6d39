#pragma once

#include <filesystem>
#include <string>

#include <tanor/error.hpp>

#include "cli/exit_code.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

/// One line on stderr, "tanor: <message>", whatever the message holds.
void print_message(const std::string& message);

/// One line for each old name that a scene uses.
void tell_old_names(const scene::Scene& scene);

/// "<where>: <what>", or what alone.
std::string describe(const InputError& error);

/// Exit code of the exception in flight, and its message. To be called in a catch block.
struct Failure {
  ExitCode code;
  std::string message;
};
Failure describe_current_exception();

/// Does some work of the library, whose InputErrors know JSON pointers alone: the scene's file goes in front.
template <class Work>
auto naming_file(const std::filesystem::path& file, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    const std::string name = file.string();
    throw InputError(error.where().empty() ? name : name + ": " + error.where(), error.what());
  }
}

}  // namespace tanor::cli
