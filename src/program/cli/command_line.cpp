#include "cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>

#include <tanor/build_info.hpp>
#include <tanor/error.hpp>
#include <tanor/motion.hpp>

#include "base/suggestion.hpp"
#include "cli/command_table.hpp"
#include "cli/messages.hpp"
#include "report/field_json.hpp"

namespace tanor::cli {
using namespace detail;

namespace {

template <class Entries>
std::vector<std::string> list_names(const Entries& entries) {
  std::vector<std::string> names;
  for (const auto& each : entries) names.push_back(each.name);
  return names;
}

/// Returns a callback that reads the words of one place. A wrong word is reported with the place.
CLI::callback_t make_reader(const std::string& place, const Value& value) {
  return [place, value](const CLI::results_t& words) {
    for (const std::string& word : words) {
      if (const std::string wrong = value.take(word); !wrong.empty()) throw CLI::ValidationError(place, wrong);
    }
    return true;
  };
}

/// Adds a command to CLI11. Words that are left over or missing are reported by our own messages.
void add_command(const Command& command, CLI::App* app) {
  CLI::App* const added = app->add_subcommand(command.name, command.summary)->allow_extras();
  std::map<std::string, CLI::Option*> options;
  for (const Argument& each : command.arguments) added->add_option(each.name, make_reader(each.name, each.value));
  for (const Option& each : command.options) {
    options[each.name] = each.place.empty()
                             ? added->add_flag_callback(each.name, [take = each.value.take] { take(""); })
                             : added->add_option(each.name, make_reader(each.name, each.value));
  }
  for (const Option& each : command.options) {
    for (const std::string& other : each.excludes) options[each.name]->excludes(options[other]);
  }
}

/// Refuses unknown words and options, and asks for what is missing.
void require_complete(const Command& command, const CLI::App& found) {
  const std::string help = "; see tanor " + command.name + " --help";
  if (const std::vector<std::string> extras = found.remaining(); !extras.empty()) {
    const std::string& word = extras.front();
    if (!word.starts_with("-"))
      throw InputError("", "'" + word + "' is one word too many for tanor " + command.name + help);
    throw InputError(
        "", "tanor " + command.name + " has no option " + word + suggest(word, list_names(command.options)) + help);
  }
  const auto require = [&](const std::string& name, const std::string& what) {
    if (found.count(name) == 0) throw InputError("", name + " is required: " + what + help);
  };
  for (const Argument& each : command.arguments) {
    if (each.is_required) require(each.name, each.what);
  }
  for (const Option& each : command.options) {
    if (each.is_required) require(each.name, each.what);
  }
}

/// Refuses what stands outside of a command and is no option of the program.
void require_known(const CLI::App& app, const std::vector<Command>& commands) {
  const std::vector<std::string> extras = app.remaining();
  if (extras.empty()) return;
  const std::string& word = extras.front();
  const bool is_option = word.starts_with("-");
  throw InputError("", (is_option ? "there is no option " : "there is no command ") + word +
                           suggest(word, is_option ? list_program_options() : list_names(commands)) +
                           "; see tanor --help");
}

/// Returns a line for each method: name, order, kind of steps, what it is.
std::string list_methods() {
  std::string text;
  for (const MethodTraits& each : methods()) {
    text +=
        fmt::format("{:20}{:8}{:10}{:10}{}\n", each.name, each.order > 0 ? fmt::format("{}", each.order) : "any",
                    each.has_fixed_steps ? "fixed" : "adaptive", each.is_implicit ? "implicit" : "explicit", each.what);
  }
  return text;
}

}  // namespace

ExitCode execute_version(const Options& options) {
  using B = BuildInfo;
  const B build = build_info();
  if (!options.json) return print_lines(describe(build)), ExitCode::Done;
  print_json(
      report::json_of_members<&B::version, &B::has_suitesparse_qr, &B::cholmod_has_gpl_modules, &B::instruction_set>(
          build));
  return ExitCode::Done;
}

ExitCode execute_methods(const Options& options) {
  using M = MethodTraits;
  constexpr std::size_t column = 48;  // column of the description of a method
  if (!options.json) return print_lines(list_methods(), column), ExitCode::Done;
  report::Json table = report::Json::array();
  for (const M& each : methods()) {
    report::Json& row =
        table.emplace_back(report::json_of_members<&M::name, &M::order, &M::has_fixed_steps, &M::is_implicit,
                                                   &M::serves_friction, &M::steps_in_coordinates, &M::what>(each));
    if (each.order <= 0) row["order"] = nullptr;
  }
  print_json(table);
  return ExitCode::Done;
}

Request parse_command_line(int argc, const char* const* argv) {
  Request request;
  const std::vector<Command> commands = make_commands(&request.options);
  CLI::App app(std::string(program_summary), "tanor");
  bool tells_version = false, lists_methods = false, is_json = false;
  app.add_flag("--version", tells_version);
  app.add_flag("--methods", lists_methods);
  app.add_flag("--json", is_json);
  app.require_subcommand(0, 1)->allow_extras();
  for (const Command& each : commands) add_command(each, &app);
  const auto asked = [&] {
    return std::ranges::find_if(commands, [&](const auto& c) { return app.got_subcommand(c.name); });
  };
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    Options help;
    if (asked() != commands.end()) help.topic = asked()->name;
    const CLI::App* const place = help.topic.empty() ? &app : app.get_subcommand(help.topic);
    help.json = place->count("--json") > 0;
    return {"help", help};
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string told = error.what(), name = told.substr(0, told.find(':'));
    throw InputError("", name + " needs one value; see tanor " + asked()->name + " --help");
  } catch (const CLI::ParseError& error) {
    throw InputError("", std::string(error.what()) + "; see tanor " +
                             (asked() == commands.end() ? "" : asked()->name + " ") + "--help");
  }
  require_known(app, commands);
  if (asked() != commands.end()) {
    if (is_json || tells_version || lists_methods)
      throw InputError("", "options stand behind the command, as in tanor " + asked()->name + " --json");
    require_complete(*asked(), *app.get_subcommand(asked()->name));
    request.command = asked()->name;
    return request;
  }
  request.options.json = is_json;
  request.command = tells_version ? "--version" : "--methods";
  if (tells_version || lists_methods) return request;
  throw InputError("", "a command is required, such as tanor run SCENE; see tanor --help");
}

}  // namespace tanor::cli
