/// docs/scene-format.md agrees with the program. Every key and choice that is read is on the page, and no other. The
/// page's text about them is tested in page_fields_test.cpp.

#include <regex>
#include <sstream>

#include "cli/format_page.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

/// Returns the names behind "wanted one of", or behind "wanted" if there is only one.
Names find_wanted(const std::string& complaint) {
  std::size_t at = complaint.find("wanted one of ");
  if (at == std::string::npos) at = complaint.find("wanted ");
  if (at == std::string::npos) return {};
  std::string list = complaint.substr(at);
  list = list.substr(list.starts_with("wanted one of ") ? 14 : 7);
  Names names;
  std::istringstream words(list);
  for (std::string word; std::getline(words, word, ',');) {
    std::erase_if(word, [](char c) { return c == ' ' || c == '"' || c == '\n'; });
    names.insert(word);
  }
  return names;
}

/// Puts a key in the place of "?".
void replace_key(json* value, const std::string& key, const json& by) {
  if (value->is_array()) {
    for (json& each : *value) replace_key(&each, key, by);
  } else if (value->is_object() && value->contains("?")) {
    value->erase("?");
    (*value)[key] = by;
  } else if (value->is_object()) {
    for (auto& [name, each] : value->items()) replace_key(&each, key, by);
  }
}

/// Returns the program's complaint about a scene with a key or value that it does not know.
std::string complain(const Folder& folder, const std::string& probe, const std::string& key, const json& value) {
  json scene = json::parse(probe);
  replace_key(&scene, key, value);
  scene["tanor_scene"] = 1;
  if (!scene.contains("points") && !scene.contains("generate") && !scene.contains("import"))
    scene["points"] = {{"positions", {{0, 0, 0}, {1, 0, 0}}}};
  write_text(folder / "s.json", scene.dump());
  const Ended ended = run_program(folder, {"info", "s.json"});
  EXPECT_EQ(ended.code, 2) << scene;
  return ended.err;
}

TEST(SceneFormatPage, HasEveryKeyThatIsReadAndNoOther) {
  const Folder folder;
  const std::vector<Table> tables = find_tables("keys of ");
  ASSERT_GT(tables.size(), 30u);
  for (const Table& table : tables) {
    Names keys;
    for (const auto& [key, choices] : table.choices) keys.insert(key);
    EXPECT_EQ(find_wanted(complain(folder, table.probe, "?", 0)), keys) << table.probe;
  }
}

TEST(SceneFormatPage, HasEveryChoiceThatIsReadAndNoOther) {
  const Folder folder;
  std::size_t count = 0;
  for (const Table& table : find_tables("keys of ")) {
    for (const auto& [key, choices] : table.choices) {
      if (choices.empty()) continue;
      ++count;
      EXPECT_EQ(find_wanted(complain(folder, table.probe, key, "?")), choices) << table.probe << " " << key;
    }
  }
  EXPECT_GE(count, 10u);
}

TEST(SceneFormatPage, HasEveryKindThatIsReadAndNoOther) {
  const Folder folder;
  std::map<std::string, Names> kinds;  // of each list
  for (const Table& table : find_tables("keys of ")) {
    const json probe = json::parse(table.probe);
    for (const auto& [list, value] : probe.items()) {
      const json& entry = value.is_array() ? value[0] : value;
      if (entry.is_object() && entry.contains("kind")) kinds[list].insert(entry["kind"].get<std::string>());
    }
  }
  ASSERT_EQ(kinds.size(), 5u);
  for (const auto& [list, names] : kinds) {
    const std::string probe = list == "generate" ? R"({"generate": {"?": 0}})" : "{\"" + list + R"(": [{"?": 0}]})";
    EXPECT_EQ(find_wanted(complain(folder, probe, "kind", "?")), names) << list;
  }
}

/// Returns the blocks of JSON on a page.
std::vector<std::string> find_scenes(const std::filesystem::path& file) {
  std::istringstream page(read_text(file));
  std::vector<std::string> scenes;
  bool is_inside = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("```")) {
      is_inside = line == "```json";
      if (is_inside) scenes.emplace_back();
    } else if (is_inside) {
      scenes.back() += line + "\n";
    }
  }
  return scenes;
}

TEST(Pages, EveryExampleOfASceneRuns) {
  const Folder folder;
  std::vector<std::filesystem::path> pages = {std::filesystem::path(TANOR_DOCS).parent_path() / "README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(TANOR_DOCS))
    if (entry.is_regular_file()) pages.push_back(entry.path());
  std::size_t count = 0;
  for (const std::filesystem::path& page : pages) {
    for (const std::string& scene : find_scenes(page)) {
      ++count;
      write_text(folder / "s.json", scene);
      const Ended ended = run_program(folder, {"run", "s.json", "--t-end", "1e-3", "--quiet", "--out", "o"});
      EXPECT_EQ(ended.code, 0) << page << ": " << ended.err << scene;
    }
  }
  EXPECT_GE(count, 3u);
}

/// Returns a line without its numbers, which depend on the machine.
std::string without_numbers(const std::string& line) {
  return std::regex_replace(line, std::regex("-?[0-9]+(\\.[0-9]+)?(e[-+][0-9]+)?"), "#");
}

TEST(Pages, TheReadmeShowsWhatItsSceneMakesTheProgramPrint) {
  const Folder folder;
  const std::filesystem::path readme = std::filesystem::path(TANOR_DOCS).parent_path() / "README.md";
  write_text(folder / "pendulum.json", find_scenes(readme).at(0));

  const Ended ended = run_program(folder, {"run", "pendulum.json"});

  ASSERT_EQ(ended.code, 0) << ended.err;
  const std::string page = without_numbers(ended.out);
  const std::string text = read_text(readme);
  const std::size_t begin = text.find("```\n  method");
  ASSERT_NE(begin, std::string::npos);
  std::istringstream shown(text.substr(begin + 4, text.find("```", begin + 4) - begin - 4));
  for (std::string line; std::getline(shown, line);) EXPECT_TRUE(contains(page, without_numbers(line) + "\n")) << line;
}

/// Compares the keys of a result, and those of the objects in it, with the table that describes it. `optional` keys are
/// written only where there is something to say.
void expect_keys_on_the_page(const std::string& mark, const json& result, const Names& optional) {
  const std::vector<Table> tables = find_tables(mark);
  ASSERT_EQ(tables.size(), 1u) << mark;
  Names told;
  for (const auto& [key, choices] : tables[0].choices) told.insert(key);
  for (const auto& [key, value] : result.items()) {
    ASSERT_TRUE(told.contains(key)) << mark << ": " << key << " is not on the page";
    if (!value.is_object()) continue;
    Names inner;
    for (const auto& [name, each] : value.items()) inner.insert(name);
    const Names& words = tables[0].words.at(key);
    if (words.contains("summary.json")) continue;  // summary.json describes it
    for (const std::string& name : inner) EXPECT_TRUE(words.contains(name)) << mark << ": " << key << "/" << name;
    for (const std::string& word : words)
      EXPECT_TRUE(inner.contains(word)) << mark << ": " << key << " has no " << word;
  }
  for (const std::string& key : told)
    EXPECT_TRUE(result.contains(key) || optional.contains(key)) << mark << ": " << key << " is not written";
}

TEST(SceneFormatPage, HasEveryKeyOfEveryResult) {
  const Folder folder;
  write_text(folder / "s.json", find_scenes(std::filesystem::path(TANOR_DOCS) / "scene-format.md").at(0));
  write_text(folder / "m.csv", "0,0,0,0,0.1,0,0,0.2,0,0\n0.5,0,0,0,0.1,0,0,0.2,0,0\n1,0,0,0,0.1,0,0,0.2,0,0\n");

  ASSERT_EQ(run_program(folder, {"run", "s.json", "--quiet", "--out", "o"}).code, 0);
  ASSERT_EQ(run_program(folder, {"solve", "s.json", "--out", "solution.json"}).code, 0);
  ASSERT_EQ(run_program(folder, {"forces", "s.json", "--motion", "m.csv", "--out", "o"}).code, 0);

  expect_keys_on_the_page("result of run", read_json(folder / "o/summary.json"),
                          {"events", "arrays", "method_reason", "restitution_capped", "tension_colours"});
  expect_keys_on_the_page("result of solve", read_json(folder / "solution.json"), {"arrays"});
  expect_keys_on_the_page("result of forces", read_json(folder / "o/forces.json"), {"arrays"});
}

TEST(SceneFormatPage, HasEveryColumnOfTheTableOfErrors) {
  const Folder folder;
  write_text(folder / "s.json", find_scenes(std::filesystem::path(TANOR_DOCS) / "scene-format.md").at(0));
  ASSERT_EQ(
      run_program(folder, {"error-time", "s.json", "--methods", "rk4", "--t-end", "0.01", "--quiet", "--out", "o"})
          .code,
      0);
  std::string columns = read_text(folder / "o/error_time.csv");
  columns = columns.substr(0, columns.find('\n'));

  std::string page;
  for (const std::string& line : read_page()) page += line + " ";
  std::string told = "`";
  for (const char c : columns) told += c == ',' ? std::string("`, `") : std::string(1, c);
  EXPECT_TRUE(contains(page, told + "`")) << told;
}

}  // namespace
}  // namespace tanor::cli
