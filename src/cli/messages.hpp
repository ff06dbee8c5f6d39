#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include <tanor/error.hpp>

#include "cli/exit_code.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

/// How grave a line is; on a terminal it shows.
enum class Tone { Note, Warning, Error };

/// One line on stderr, "tanor: <message>", whatever the message holds; as many as a terminal needs.
void print_message(const std::string& message, Tone tone = Tone::Note);

/// A path as it is to be typed into a shell: in quotes where the shell would take it apart.
std::string typed(const std::filesystem::path& path);

/// "<key>:   <value>" on standard output, in as many lines as a terminal needs; one elsewhere.
void print(std::string_view key, const std::string& value);
/// Lines on standard output; what is longer than a terminal goes on below, somewhat to the right, or at a column.
void print_lines(std::string_view text, std::size_t column = 4);
/// The title of some rows, after an empty line.
void print_heading(std::string_view title);
/// A page of a run (`report::format_page`) on standard output, in as many lines as a terminal needs.
void print_page(std::string_view page);
/// JSON that somebody asked for, on standard output.
void print_json(const nlohmann::ordered_json& json);
/// The same from a file that was just written.
void print_json_file(const std::filesystem::path& file);

/// Says on stderr why a scene has no complete answer.
ExitCode tell(const std::filesystem::path& scene, const std::string& why);

/// A scene that was read: one line on stderr for each old name that it uses and for each warning, and the threads that
/// it asks for are there.
scene::Scene prepare(scene::Scene scene);

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
