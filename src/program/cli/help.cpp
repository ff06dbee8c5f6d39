#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include <tanor/error.hpp>
#include <tanor/version.hpp>

#include "cli/command_line.hpp"
#include "cli/command_table.hpp"
#include "report/terminal.hpp"

namespace tanor::cli {

namespace {

using report::Terminal;
using Rows = std::vector<std::pair<std::string, std::string>>;

/// Sets two columns; the second is broken into lines where the window ends.
std::string set_rows(const Rows& rows, const Terminal& terminal) {
  std::size_t widest = 0;
  for (const auto& [left, right] : rows) widest = std::max(widest, report::count_columns(left));
  const std::size_t indent = widest + 4, width = terminal.width().value_or(100);
  std::string text;
  for (const auto& [left, right] : rows) {
    const std::string gap(widest - report::count_columns(left) + 2, ' ');
    // In a narrow window the second column stands below.
    text += indent + 24 <= width
                ? fmt::format("  {}{}{}\n", terminal.bold(left), gap, report::wrap(right, indent, width))
                : fmt::format("  {}\n      {}\n", terminal.bold(left), report::wrap(right, 6, width));
  }
  return text;
}

std::string set_section(const char* title, const Rows& rows, const Terminal& terminal) {
  return rows.empty() ? "" : fmt::format("\n{}\n{}", terminal.key(title), set_rows(rows, terminal));
}

Rows list_examples(std::span<const Example> examples) {
  Rows rows;
  for (const Example& each : examples) rows.emplace_back(each.line, each.what);
  return rows;
}

std::string describe_program(const Terminal& terminal) {
  Rows commands, options, codes;
  for (const Command& each : all_commands()) commands.emplace_back(each.name, each.summary);
  for (const ProgramOption& each : program_options()) options.emplace_back(each.names, each.what);
  for (const ExitMeaning& each : exit_meanings()) codes.emplace_back(each.codes, each.what);
  const std::size_t width = terminal.width().value_or(100);
  return report::wrap(fmt::format("tanor {}: {}", TANOR_VERSION, program_summary), 0, width) + "\n" +
         fmt::format("\n{}\n  tanor COMMAND [ARGUMENT...] [OPTION...]\n", terminal.key("Usage")) +
         set_section("Commands", commands, terminal) + set_section("Options", options, terminal) +
         set_section("Examples", list_examples(first_examples()), terminal) +
         set_section("Exit codes", codes, terminal);
}

std::string describe_command(const Command& command, const Terminal& terminal) {
  Rows arguments, options;
  for (const Argument& each : command.arguments) arguments.emplace_back(each.name, each.what);
  for (const Option& each : command.options) {
    options.emplace_back(each.place.empty() ? each.name : each.name + " " + each.place, describe(each));
  }
  options.emplace_back("-h, --help", "this page");
  const std::size_t width = terminal.width().value_or(100);
  std::string text = report::wrap(fmt::format("tanor {}: {}", command.name, command.summary), 0, width) + "\n\n" +
                     fmt::format("{}\n  {}\n\n", terminal.key("Usage"), usage(command));
  for (std::size_t begin = 0; begin < command.text.size();) {
    const std::size_t end = std::min(command.text.find('\n', begin), command.text.size());
    text += report::wrap(std::string_view(command.text).substr(begin, end - begin), 0, width) + "\n";
    begin = end + 1;
  }
  return text + set_section("Arguments", arguments, terminal) + set_section("Options", options, terminal) +
         set_section("Examples", list_examples(command.examples), terminal);
}

nlohmann::ordered_json as_json(const Command& command) {
  nlohmann::ordered_json arguments = nlohmann::json::array(), options = arguments, examples = arguments;
  for (const Argument& each : command.arguments)
    arguments.push_back({{"name", each.name}, {"what", each.what}, {"required", each.is_required}});
  for (const Option& each : command.options)
    options.push_back(
        {{"name", each.name}, {"value", each.place}, {"what", describe(each)}, {"required", each.is_required}});
  for (const Example& each : command.examples) examples.push_back({{"line", each.line}, {"what", each.what}});
  return {{"name", command.name},   {"summary", command.summary}, {"text", command.text},
          {"arguments", arguments}, {"options", options},         {"examples", examples}};
}

}  // namespace

ExitCode execute_help(const Options& options) {
  const std::span<const Command> commands =
      options.topic.empty() ? std::span(all_commands()) : std::span(&find_command(options.topic), 1);
  if (options.json) {
    nlohmann::ordered_json table = nlohmann::json::array();
    for (const Command& each : commands) table.push_back(as_json(each));
    fmt::print("{}\n", table.dump(1));
    return ExitCode::Done;
  }
  const Terminal terminal = Terminal::of(stdout);
  fmt::print("{}", options.topic.empty() ? describe_program(terminal) : describe_command(commands[0], terminal));
  return ExitCode::Done;
}

}  // namespace tanor::cli
