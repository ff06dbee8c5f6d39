#pragma once

#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/program.hpp"

/// The tables of docs/scene-format.md.
namespace tanor::cli {

using Names = std::set<std::string>;

inline std::vector<std::string> read_page() {
  std::istringstream page(read_text(std::filesystem::path(TANOR_DOCS) / "scene-format.md"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(page, line);) lines.push_back(line);
  return lines;
}

/// Returns the words in backticks.
inline Names find_quoted(const std::string& text) {
  Names names;
  for (std::size_t begin = text.find('`'); begin != std::string::npos;) {
    const std::size_t end = text.find('`', begin + 1);
    if (end == std::string::npos) break;
    names.insert(text.substr(begin + 1, end - begin - 1));
    begin = text.find('`', end + 1);
  }
  return names;
}

/// Returns the cells of a row; `\|` is a bar inside one.
inline std::vector<std::string> split_row(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (line[i] == '|' && line[i - 1] != '\\') {
      const std::size_t first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
      cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
      cell.clear();
    } else {
      cell += line[i];
    }
  }
  return cells;
}

/// A table of keys, with its rows and the JSON that leads to it, in which "?" stands for a key.
struct Table {
  std::string probe;
  std::map<std::string, Names> choices{};  ///< of each key, empty where any value may stand
  std::map<std::string, Names> words{};    ///< of each key, the words that are quoted in the cells behind it
  /// The cells of each key by the names of their columns: `what`, `unit`, `default`.
  std::map<std::string, std::map<std::string, std::string>> cells{};
};

/// Returns the tables that follow a comment "<!-- mark JSON -->".
inline std::vector<Table> find_tables(const std::string& mark) {
  const std::string begin = "<!-- " + mark;
  std::vector<Table> tables;
  std::vector<std::string> columns;
  bool is_inside = false;
  for (const std::string& line : read_page()) {
    if (line.starts_with(begin)) {
      const std::string rest = line.substr(begin.size());
      tables.push_back({rest.substr(0, rest.find("-->"))});
      is_inside = true;
    } else if (is_inside && !line.starts_with("|")) {
      is_inside = false;
    } else if (is_inside && line.starts_with("| key")) {
      columns = split_row(line);
    } else if (is_inside && line.starts_with("| `")) {
      const std::size_t middle = line.find(" | ");
      const std::string keys = line.substr(0, middle), what = line.substr(middle + 3);
      const bool is_choice = what.starts_with("one of ");
      const Names choices = is_choice ? find_quoted(what.substr(0, what.find_first_of(":|"))) : Names();
      const std::vector<std::string> cells = split_row(line);
      for (const std::string& key : find_quoted(keys)) {
        tables.back().choices[key] = choices;
        tables.back().words[key] = find_quoted(what);
        for (std::size_t k = 1; k < std::min(cells.size(), columns.size()); ++k)
          tables.back().cells[key][columns[k]] = cells[k];
      }
    }
  }
  return tables;
}

}  // namespace tanor::cli
