#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include <tanor/certificate.hpp>
#include <tanor/error.hpp>

#include "cli/exit_code.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {

/// The severity of a line, which a terminal shows.
enum class Tone { Note, Warning, Error };

/// Prints "tanor: <message>" on stderr, as one line whatever the message holds; a terminal breaks it where it ends.
void print_message(const std::string& message, Tone tone = Tone::Note);

/// Returns a path as it is to be typed into a shell: in quotes where the shell would take it apart.
std::string typed(const std::filesystem::path& path);

/// Prints "<key>:   <value>" on standard output, in as many lines as a terminal needs; one elsewhere.
void print(std::string_view key, const std::string& value);
/// Prints lines on standard output. What is longer than a terminal goes on below, at its own indentation or at a
/// column.
void print_lines(std::string_view text, std::size_t column = 4);
/// Prints the title of some rows, after an empty line.
void print_heading(std::string_view title);
/// Prints a page of a run (`report::format_page`) on standard output, in as many lines as a terminal needs.
void print_page(std::string_view page);
/// Prints each check of a certificate on standard output, in plain words or with the paper's symbols.
void print_checks(const Certificate& certificate, bool with_symbols);
/// Prints JSON that somebody asked for, on standard output.
void print_json(const nlohmann::ordered_json& json);
/// Does the same from a file that was just written.
void print_json_file(const std::filesystem::path& file);

/// Prints on stderr why a scene has no complete answer, and returns the exit code for that.
ExitCode tell(const std::filesystem::path& scene, const std::string& why);

/// Lists what a state of rest leaves out of its scene, then what the search did not need.
std::vector<std::string> list_left_out_at_rest(const scene::Scene& scene, const std::vector<std::string>& not_needed);

/// Prepares a scene that was read: prints one line on stderr for each old name that it uses and for each warning, and
/// checks that the threads it asks for can be had.
scene::Scene prepare(scene::Scene scene);

/// Returns "<where>: <what>", or only what.
std::string describe(const InputError& error);

/// The exit code and the message of the exception in flight. `describe_current_exception` is called in a catch block.
struct Failure {
  ExitCode code;
  std::string message;
};
Failure describe_current_exception();

/// Calls the library, whose InputErrors contain only JSON pointers, and puts the scene's file in front of them.
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
