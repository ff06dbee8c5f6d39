#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command_line.hpp"

/// The one description of the command line, read by the parser, the help, the completions of shells and the manual
/// pages. See docs/contributing.md, "How to add a command".
namespace tanor::cli {

/// The kind of word at a place of the command line, which shells complete.
enum class Word { Text, Number, File, Folder, Scene, Choice, Choices, Command };

/// Reads one word and keeps it. If the word is wrong, `take` returns what would be right ("must be …, not '0'"), else
/// nothing.
struct Value {
  Word word = Word::Text;
  std::function<std::string(const std::string&)> take;
  std::vector<std::string> offers = {};  ///< the words of a Choice, or of Choices between commas
};

struct Argument {
  std::string name;  ///< "SCENE"
  Value value;
  std::string what;
  bool is_required = true;
};

struct Option {
  std::string name;   ///< "--out"
  std::string place;  ///< the name of its value, "DIR"; empty if it has none
  Value value;        ///< reads the value, or "" if it has none
  std::string what;
  bool is_required = false;
  std::vector<std::string> excludes = {};  ///< options that may not stand beside it
};

/// A term, such as a line to type, and what it means.
struct Row {
  std::string term, what;
};

struct Command {
  std::string name;     ///< "run"
  std::string summary;  ///< a line
  std::string text;     ///< one or several paragraphs, each a line
  std::vector<Argument> arguments = {};
  std::vector<Option> options = {};
  std::vector<Row> examples = {};
};

/// Returns all commands in the order of the help, which is that in which a new user needs them. They keep in `options`
/// what they read.
std::vector<Command> make_commands(Options* options);

/// Returns them for those who tell about them and read nothing.
const std::vector<Command>& all_commands();

/// Returns the command of a name. Throws InputError if there is none.
const Command& find_command(const std::string& name);

/// Returns the long names of the options of the program itself: --help, --version, --methods, --json.
std::vector<std::string> list_program_options();

/// A list of a page of help, and of a manual page.
struct Section {
  std::string title;
  std::vector<Row> rows;
};
/// Returns the lists about the program: its commands, options, examples for someone who sees it for the first time, and
/// exit codes.
std::vector<Section> sections_of_program();
/// Returns the lists about a command. `help` says what its --help prints.
std::vector<Section> sections_of(const Command& command, const char* help);

inline constexpr const char* exit_codes = "Exit codes";  ///< title of a section

inline constexpr std::string_view program_summary =
    "Motion and reactions of large systems of material points under constraints.";

/// Returns "fixed step, s; not with --rtol, --atol" or the like.
std::string describe(const Option& option);

/// Returns "tanor run SCENE [OPTION...]" or the like.
std::string usage(const Command& command);

}  // namespace tanor::cli
