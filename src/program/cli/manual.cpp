#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include <tanor/version.hpp>

#include "cli/command_line.hpp"
#include "cli/command_table.hpp"
#include "cli/messages.hpp"
#include "report/output_file.hpp"

// Manual pages in the macros of man(7).
namespace tanor::cli {

namespace {

/// Returns a text in which nothing is a command of roff.
std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\') {
      escaped += "\\e";
    } else if (c == '-') {
      escaped += "\\-";
    } else {
      if ((c == '.' || c == '\'') && (escaped.empty() || escaped.back() == '\n')) escaped += "\\&";
      escaped += c;
    }
  }
  return escaped;
}

std::string in_upper_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string begin_page(const std::string& name, std::string_view summary) {
  return fmt::format(".TH {} 1 \"\" \"tanor {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n", in_upper_case(name),
                     TANOR_VERSION, escape(name), escape(summary));
}

/// Returns a term and what it means.
std::string item(std::string_view term, std::string_view what) {
  return fmt::format(".TP\n.B {}\n{}\n", escape(term), escape(what));
}

std::string print_sections(const std::vector<Section>& sections) {
  std::string text;
  for (const auto& [title, rows] : sections) {
    if (!rows.empty()) text += ".SH " + (title == exit_codes ? "EXIT STATUS" : in_upper_case(title)) + "\n";
    for (const auto& [term, what] : rows) text += item(term, what);
  }
  return text + ".SH ENVIRONMENT\n" +
         item("NO_COLOR", "where it is set and not empty, nothing is coloured; colours appear on terminals only") +
         item("OMP_NUM_THREADS", "threads, where neither the scene nor --threads says how many") + ".SH SEE ALSO\n";
}

std::string write_page(const Command& command) {
  std::string page = begin_page("tanor-" + command.name, command.summary);
  page += ".SH SYNOPSIS\n.B " + escape(usage(command)) + "\n.SH DESCRIPTION\n";
  std::string text = escape(command.text);
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 5))
    text.replace(at, 1, "\n.PP\n");
  return page + text + "\n" + print_sections(sections_of(command, "print a summary of this page")) + ".BR tanor (1)\n";
}

std::string write_page_of_program() {
  std::string page = begin_page("tanor", program_summary);
  page += ".SH SYNOPSIS\n.B tanor\n.I COMMAND\n[\\fIARGUMENT\\fR...] [\\fIOPTION\\fR...]\n.SH DESCRIPTION\n";
  page +=
      "A scene is a JSON file. The commands read one and tell what it holds, move it, or solve it at one instant.\n";
  page += print_sections(sections_of_program());
  const std::vector<Command>& commands = all_commands();
  for (const Command& each : commands)
    page += fmt::format(".BR {} (1){}\n", escape("tanor-" + each.name), &each == &commands.back() ? "" : ",");
  return page;
}

}  // namespace

ExitCode execute_manual(const Options& options) {
  if (!options.out) {
    const bool is_whole = options.topic.empty();
    const std::string page = is_whole ? write_page_of_program() : write_page(find_command(options.topic));
    options.json ? print_json({{"name", is_whole ? "tanor" : "tanor-" + options.topic}, {"page", page}})
                 : fmt::print("{}", page);
    return ExitCode::Done;
  }
  report::make_folder(*options.out);
  nlohmann::ordered_json files = nlohmann::json::array();
  const auto write = [&](const std::string& name, const std::string& page) {
    const std::filesystem::path path = *options.out / (name + ".1");
    report::replace_file(path, [&](report::OutputFile* file) { file->write(page); });
    files.push_back(path.string());
  };
  write("tanor", write_page_of_program());
  for (const Command& each : all_commands()) write("tanor-" + each.name, write_page(each));
  if (options.json) print_json({{"files", files}});
  return ExitCode::Done;
}

}  // namespace tanor::cli
