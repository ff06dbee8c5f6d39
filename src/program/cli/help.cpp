#include <fmt/format.h>

#include <algorithm>

#include <tanor/error.hpp>
#include <tanor/version.hpp>

#include "cli/command_line.hpp"
#include "cli/command_table.hpp"
#include "report/json_text.hpp"
#include "report/terminal.hpp"

namespace tanor::cli {

namespace {

using report::Terminal;

/// Sets two columns; the second is broken into lines where the window ends.
std::string set_rows(const std::vector<Row>& rows, const Terminal& terminal) {
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

std::string set_sections(const std::vector<Section>& sections, const Terminal& terminal) {
  std::string text;
  for (const auto& [title, rows] : sections)
    if (!rows.empty()) text += fmt::format("\n{}\n{}", terminal.key(title), set_rows(rows, terminal));
  return text;
}

std::string describe_program(const Terminal& terminal) {
  return report::wrap(fmt::format("tanor {}: {}", TANOR_VERSION, program_summary), 0, terminal.width().value_or(100)) +
         fmt::format("\n\n{}\n  tanor COMMAND [ARGUMENT...] [OPTION...]\n", terminal.key("Usage")) +
         set_sections(sections_of_program(), terminal);
}

std::string describe_command(const Command& command, const Terminal& terminal) {
  const std::size_t width = terminal.width().value_or(100);
  std::string text = report::wrap(fmt::format("tanor {}: {}", command.name, command.summary), 0, width) + "\n\n" +
                     fmt::format("{}\n  {}\n\n", terminal.key("Usage"), usage(command));
  for (std::size_t begin = 0; begin < command.text.size();) {
    const std::size_t end = std::min(command.text.find('\n', begin), command.text.size());
    text += report::wrap(std::string_view(command.text).substr(begin, end - begin), 0, width) + "\n";
    begin = end + 1;
  }
  std::vector<Section> sections = sections_of(command, "this page");
  sections.pop_back();  // the overview has the exit codes
  return text + set_sections(sections, terminal);
}

report::Json as_json(const Command& command) {
  using report::Json;
  const auto argument = [](const Argument& each) {
    return Json{{"name", each.name}, {"what", each.what}, {"required", each.is_required}};
  };
  const auto option = [](const Option& each) {
    return Json{{"name", each.name}, {"value", each.place}, {"what", describe(each)}, {"required", each.is_required}};
  };
  const auto example = [](const Row& each) { return Json{{"line", each.term}, {"what", each.what}}; };
  return {{"name", command.name},
          {"summary", command.summary},
          {"text", command.text},
          {"arguments", report::list_of(command.arguments, argument)},
          {"options", report::list_of(command.options, option)},
          {"examples", report::list_of(command.examples, example)}};
}

}  // namespace

ExitCode execute_help(const Options& options) {
  const std::span<const Command> commands =
      options.topic.empty() ? std::span(all_commands()) : std::span(&find_command(options.topic), 1);
  if (options.json) {
    fmt::print("{}\n", report::list_of(commands, as_json).dump(1));
    return ExitCode::Done;
  }
  const Terminal terminal = Terminal::of(stdout);
  fmt::print("{}", options.topic.empty() ? describe_program(terminal) : describe_command(commands[0], terminal));
  return ExitCode::Done;
}

}  // namespace tanor::cli
