#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include <tanor/error.hpp>

#include "cli/command_line.hpp"
#include "cli/command_table.hpp"
#include "cli/messages.hpp"

// Scripts with which shells complete commands, options, their words and files.
namespace tanor::cli {

namespace {

std::string list_commands(const std::vector<Command>& commands) {
  std::string names;
  for (const Command& each : commands) names += (names.empty() ? "" : " ") + each.name;
  return names;
}

/// The ways of a shell for the kinds of Word, in their order; {} stands for the words that it offers.
using Shell = std::array<const char*, 8>;
static_assert(std::tuple_size_v<Shell> == static_cast<std::size_t>(Word::Command) + 1);
constexpr const char* offer_in_bash = "COMPREPLY=($(compgen -W '{}' -- \"$cur\"))";
constexpr Shell bash{
    ":", ":", "_tanor_files", "_tanor_files /", "_tanor_files json", offer_in_bash, "_tanor_list '{}'", offer_in_bash};
constexpr Shell zsh{" ", " ", "_files", "_files -/", "_files -g \"*.json\"", "({})", "_values -s , name {}", "({})"};

/// Returns what a shell does for a value; `commands` are their names.
std::string complete(const Shell& shell, const Value& value, const std::string& commands) {
  const bool is_command = value.word == Word::Command;
  return fmt::format(fmt::runtime(shell.at(static_cast<std::size_t>(value.word))),
                     is_command ? commands : fmt::format("{}", fmt::join(value.offers, " ")));
}

/// Returns what bash completes behind a command: the value of an option, an option, or the command's first argument.
std::string complete_command_in_bash(const Command& command, const std::string& words) {
  std::string options = "--help", values;
  for (const Option& each : command.options) {
    options += " " + each.name;
    if (!each.place.empty())
      values += fmt::format("        {}) {}; return ;;\n", each.name, complete(bash, each.value, words));
  }
  const std::string argument = command.arguments.empty() ? ":" : complete(bash, command.arguments[0].value, words);
  return fmt::format(R"(    {})
      case $prev in
{}      esac
      if [[ $cur == -* ]]; then COMPREPLY=($(compgen -W '{}' -- "$cur")); else {}; fi ;;
)",
                     command.name, values, options, argument);
}

std::string write_bash() {
  const std::vector<Command>& commands = all_commands();
  const std::string words = list_commands(commands);
  std::string cases;
  for (const Command& each : commands) cases += complete_command_in_bash(each, words);
  return R"(# Completion of tanor for bash, made by `tanor completion bash`.
_tanor_files() {  # folders, and files unless $1 is /; where it is an ending only those that have it
  compopt -o filenames
  local IFS=$'\n' begun=${cur//\\/}  # names may have blanks, which were quoted
  begun=${begun#[\"\']}
  COMPREPLY=($(compgen -d -- "$begun"))
  [[ ${1-} == / ]] || COMPREPLY+=($(compgen -f -X "${1:+!*.$1}" -- "$begun"))
}
_tanor_list() {  # the last of some names between commas
  local before=
  [[ $cur == *,* ]] && before=${cur%,*},
  COMPREPLY=($(compgen -P "$before" -W "$1" -- "${cur##*,}"))
  compopt -o nospace
}
_tanor() {
  local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]}
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    COMPREPLY=($(compgen -W ')" +
         words + fmt::format(" {}", fmt::join(list_program_options(), " ")) + R"(' -- "$cur"))
    return
  fi
  case ${COMP_WORDS[1]} in
)" + cases +
         R"(  esac
}
complete -F _tanor tanor
)";
}

/// Quotes a text inside single quotes and brackets of _arguments.
std::string quote_in_zsh(std::string_view text) {
  std::string quoted;
  for (const char c : text) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      if (c == '[' || c == ']' || c == ':' || c == '\\') quoted += '\\';
      quoted += c;
    }
  }
  return quoted;
}

std::string complete_command_in_zsh(const Command& command, const std::string& words) {
  std::string rules;
  for (const Option& each : command.options) {
    const std::string value =
        each.place.empty() ? "" : fmt::format(":{}:{}", each.place, complete(zsh, each.value, words));
    rules += fmt::format(" \\\n        '{}[{}]{}'", each.name, quote_in_zsh(each.what), value);
  }
  rules += " \\\n        '(- *)'{-h,--help}'[all about this command]'";
  for (const Argument& each : command.arguments)
    rules += fmt::format(" \\\n        '{}{}:{}'", each.is_required ? ":" : "::", quote_in_zsh(each.what),
                         complete(zsh, each.value, words));
  return fmt::format("    {})\n      _arguments{} ;;\n", command.name, rules);
}

std::string write_zsh() {
  const std::vector<Command>& commands = all_commands();
  const std::string words = list_commands(commands);
  std::string list, cases;
  for (const Command& each : commands) {
    list += fmt::format("    '{}:{}'\n", each.name, quote_in_zsh(each.summary));
    cases += complete_command_in_zsh(each, words);
  }
  return R"(#compdef tanor
# Completion of tanor for zsh, made by `tanor completion zsh`.
_tanor() {
  local -a commands
  commands=(
)" + list +
         R"(  )
  if ((CURRENT == 2)); then
    _describe command commands
    compadd -- )" +
         fmt::format("{}", fmt::join(list_program_options(), " ")) + R"(
    return
  fi
  local command=${words[2]}
  shift words
  ((CURRENT--))
  case $command in
)" + cases +
         R"(  esac
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then _tanor "$@"; else compdef _tanor tanor; fi
)";
}

}  // namespace

ExitCode execute_completion(const Options& options) {
  if (options.topic != "bash" && options.topic != "zsh")
    throw InputError("SHELL", "must be bash or zsh, not '" + options.topic + "'");
  const std::string script = options.topic == "bash" ? write_bash() : write_zsh();
  options.json ? print_json({{"shell", options.topic}, {"script", script}}) : fmt::print("{}", script);
  return ExitCode::Done;
}

}  // namespace tanor::cli
