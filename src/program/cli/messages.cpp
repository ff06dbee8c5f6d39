#include "cli/messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <exception>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include <tanor/warnings.hpp>

#include "cli/process.hpp"
#include "report/page.hpp"
#include "report/terminal.hpp"
#include "report/words.hpp"

namespace tanor::cli {

using report::Terminal;

void print_message(const std::string& message, Tone tone) {
  const Terminal terminal = Terminal::of(stderr);
  const std::string name = tone == Tone::Error     ? terminal.error("tanor:")
                           : tone == Tone::Warning ? terminal.warning("tanor:")
                                                   : terminal.bold("tanor:");
  std::string line = message;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  constexpr std::size_t column = 7;  // column behind the program's name
  std::fputs((name + " " + report::wrap(line, column, terminal.width()) + "\n").c_str(), stderr);
}

std::string typed(const std::filesystem::path& path) {
  std::string plain = path.string();
  const bool is_plain = std::ranges::all_of(plain, [](const unsigned char c) {
    return std::isalnum(c) || c >= 128 ||
           std::string_view("/._-+,:=@%^").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (is_plain && !plain.starts_with('-')) return plain;
  std::string quoted = "'";
  for (const char c : plain) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

void print(std::string_view key, const std::string& value) {
  constexpr std::size_t column = 25;
  const Terminal terminal = Terminal::of(stdout);
  const std::size_t taken = report::count_columns(key) + 1;
  const std::string gap(taken < column ? column - taken : 1, ' ');
  fmt::print("{}{}{}\n", terminal.key(fmt::format("{}:", key)), gap,
             report::wrap(value, std::max(column, taken + 1), terminal.width()));
}

void print_lines(std::string_view text, std::size_t column) {
  const std::optional<std::size_t> width = Terminal::of(stdout).width();
  if (width && column + 24 > *width) column = 4;  // too little is left there for words
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const std::size_t blanks = std::min(line.find_first_not_of(' '), line.size());
    fmt::print("{}{}\n", line.substr(0, blanks), report::wrap(line.substr(blanks), column, width, blanks));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

void print_heading(std::string_view title) {
  fmt::print("\n{}\n", Terminal::of(stdout).bold(title));
}

void print_checks(const Certificate& certificate, bool with_symbols) {
  fmt::print("{:<52}{:>9}{:>20}\n", "identity", "error", "rounding explains");
  for (const CertificateCheck& check : certificate.checks) {
    const std::string row =
        fmt::format("{:<52}{:>9}{:>20}", with_symbols ? check.identity : check.words,
                    report::in_words(check.error, "{:.1e}"), report::in_words(check.allowed, "{:.1e}"));
    const bool holds = check.error <= check.allowed;
    fmt::print("{}\n", holds ? row : Terminal::of(stdout).error(row + "  FAILS at " + check.where));
  }
}

void print_page(std::string_view page) {
  const Terminal terminal = Terminal::of(stdout);
  while (!page.empty()) {
    const std::size_t end = std::min(page.find('\n'), page.size());
    const std::string_view row = page.substr(0, end), words = row.substr(std::min(report::page_column, row.size()));
    page.remove_prefix(std::min(end + 1, page.size()));
    if (!row.starts_with(' '))
      fmt::print("{}\n", terminal.bold(report::wrap(row, 0, terminal.width())));
    else
      fmt::print("{}{}\n", terminal.key(row.substr(0, row.size() - words.size())),
                 report::wrap(words, report::page_column, terminal.width()));
  }
}

void print_json(const nlohmann::ordered_json& json) {
  fmt::print("{}\n", json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

void print_json_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::fputs(text.str().c_str(), stdout);
}

ExitCode tell(const std::filesystem::path& scene, const std::string& why) {
  print_message(scene.string() + ": " + why, Tone::Error);
  return ExitCode::NoAnswer;
}

std::vector<std::string> list_left_out_at_rest(const scene::Scene& scene, const std::vector<std::string>& not_needed) {
  std::vector<std::string> all = report::list_left_out(scene.left_out, not_needed);
  if (!scene.events.empty()) all.push_back("events: nothing moves");
  return all;
}

scene::Scene prepare(scene::Scene scene) {
  for (const std::string& each : scene.old_names) print_message(scene.file.string() + ": " + each);
  for (const std::string& each : report::list_left_out(scene.left_out, find_warnings(scene.system)))
    print_message(scene.file.string() + ": warning: " + each, Tone::Warning);
  require_threads(scene.solver.threads);
  require_work_space_of_blas();
  return scene;
}

std::string describe(const InputError& error) {
  // If a file cannot be read, the sentence names it already.
  const std::string& where = error.where();
  const std::string what = error.what();
  return where.empty() || what.starts_with(where + " ") ? what : where + ": " + what;
}

Failure describe_current_exception() {
  try {
    throw;
  } catch (const InputError& error) {
    return {ExitCode::BadInput, describe(error)};
  } catch (const std::bad_alloc&) {
    return {ExitCode::MachineFailure, "out of memory"};
  } catch (const std::exception& error) {
    return {ExitCode::MachineFailure, error.what()};
  } catch (...) {
    return {ExitCode::MachineFailure, "unknown failure"};
  }
}

}  // namespace tanor::cli
