#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command_line.hpp"

/// The one description of the command line: the parser, the help, the completions of shells and the manual pages all
/// read it. docs/contributing.md, "How to add a command".
namespace tanor::cli {

/// What may stand in a place of the command line. Shells complete it.
enum class Word { Text, Number, File, Folder, Scene, Choice, Choices, Command };

/// Reads one word and keeps it; returns what would be right where it is wrong ("must be …, not '0'"), else nothing.
struct Value {
  Word word = Word::Text;
  std::function<std::string(const std::string&)> take;
  std::vector<std::string> offers = {};  ///< of a Choice, or of Choices between commas
};

struct Argument {
  std::string name;  ///< "SCENE"
  Value value;
  std::string what;
  bool is_required = true;
};

struct Option {
  std::string name;   ///< "--out"
  std::string place;  ///< the name of its value, "DIR"; empty: it has none
  Value value;        ///< without a value: told "" where the option is given
  std::string what;
  bool is_required = false;
  std::vector<std::string> excludes = {};  ///< options that may not stand beside it
};

struct Example {
  std::string line, what;
};

struct Command {
  std::string name;     ///< "run"
  std::string summary;  ///< a line
  std::string text;     ///< a paragraph or some, each a line
  std::vector<Argument> arguments = {};
  std::vector<Option> options = {};
  std::vector<Example> examples = {};
  std::function<Request()> request = {};  ///< what was read
};

/// All commands in the order of the help, which is that in which a new user needs them. What they read is in them:
/// each call makes new ones.
std::vector<Command> make_commands();

/// The command of a name. Throws InputError where there is none.
Command find_command(const std::string& name);

/// Options of the program itself: --help, --version, --methods, --json.
struct ProgramOption {
  std::string_view names, what;
};
std::span<const ProgramOption> program_options();
/// Their long names, "--help" and so on.
std::vector<std::string> list_program_options();

/// What an exit code means.
struct ExitMeaning {
  std::string_view codes, what;
};
std::span<const ExitMeaning> exit_meanings();

/// Examples for someone who sees the program for the first time.
std::span<const Example> first_examples();

inline constexpr std::string_view program_summary =
    "Motion and reactions of large systems of material points under constraints.";

/// "fixed step, s; not with --rtol, --atol"
std::string describe(const Option& option);

/// "tanor run SCENE [OPTION...]"
std::string usage(const Command& command);

}  // namespace tanor::cli
