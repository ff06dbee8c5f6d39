/// Help, completions and manual pages are all made from the table of commands.

#include <algorithm>
#include <initializer_list>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <tanor/build_info.hpp>

#include "cli/shell.hpp"
#include "cli/terminal.hpp"

namespace tanor::cli {
namespace {

using nlohmann::json;

json read_table() {
  const Ended ended = run_program(Folder(), {"help", "--json"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  return json::parse(ended.out);
}

Words split(const std::string& text) {
  std::istringstream stream(text);
  Words words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::size_t count_columns(const std::string& line) {
  return static_cast<std::size_t>(
      std::ranges::count_if(line, [](unsigned char byte) { return (byte & 0xc0u) != 0x80u; }));
}

TEST(HelpTest, TellsEveryCommandAndEveryOptionWithAnExample) {
  const std::string overview = run_program(Folder(), {"--help"}).out;
  const json table = read_table();
  ASSERT_GE(table.size(), 10u);
  for (const json& command : table) {
    const std::string name = command["name"];
    EXPECT_TRUE(contains(overview, "\n  " + name + " ")) << name;
    const std::string help = run_program(Folder(), {name, "--help"}).out;
    EXPECT_EQ(help, run_program(Folder(), {"help", name}).out);
    EXPECT_TRUE(contains(help, "Usage\n  tanor " + name)) << help;
    for (const json& option : command["options"])
      EXPECT_TRUE(contains(help, "\n  " + option["name"].get<std::string>())) << name << option;
    EXPECT_TRUE(contains(help, "Examples\n  ")) << help;
  }
}

TEST(HelpTest, ExamplesUseOptionsThatExist) {
  std::map<std::string, std::set<std::string>> options;  // the options of each command
  const json table = read_table();
  for (const json& command : table) {
    for (const json& option : command["options"]) options[command["name"]].insert(option["name"]);
  }
  for (const json& command : table) {
    bool shows_itself = false;
    for (const json& example : command["examples"]) {
      std::string line = example["line"];
      line = line.substr(line.find("tanor "), line.find('|') - line.find("tanor "));
      const Words words = split(line);
      shows_itself = shows_itself || words[1] == command["name"];
      for (const std::string& word : words)
        EXPECT_TRUE(!word.starts_with("--") || options[words[1]].contains(word)) << line << ": " << word;
    }
    EXPECT_TRUE(shows_itself) << command;
  }
}

/// "tanor view net.out" looks at the results of "tanor run net.json".
TEST(HelpTest, FoldersOfExamplesHaveTheNamesOfTheirScenes) {
  const std::filesystem::path examples = std::filesystem::path(TANOR_DOCS).parent_path() / "examples";
  std::string text = read_text(examples / "README.md");
  for (const json& command : read_table())
    for (const json& example : command["examples"]) text += "\n" + example["line"].get<std::string>();
  const std::regex folder("[^.a-z_]([a-z_]+)\\.out");
  int found = 0;
  for (std::sregex_iterator each(text.begin(), text.end(), folder), end; each != end; ++each, ++found) {
    const std::string stem = (*each)[1];
    EXPECT_TRUE(std::filesystem::exists(examples / (stem + ".json"))) << stem;
  }
  EXPECT_GE(found, 4);
}

TEST(HelpTest, TheSceneFormatPageTellsEveryCommandAndEveryOption) {
  const std::string page = read_text(std::filesystem::path(TANOR_DOCS) / "scene-format.md");
  const std::size_t begin = page.find("## Command line");
  ASSERT_NE(begin, std::string::npos);
  const std::string part = page.substr(begin, page.find("\n## ", begin + 1) - begin);
  for (const json& command : read_table()) {
    EXPECT_TRUE(contains(part, "tanor " + command["name"].get<std::string>())) << command["name"];
    for (const json& option : command["options"])
      EXPECT_TRUE(contains(part, option["name"].get<std::string>())) << command["name"] << option["name"];
  }
}

TEST(HelpTest, LinesFitIntoTheWindow) {
  for (const unsigned short columns : std::initializer_list<unsigned short>{40, 80, 200}) {
    for (const Words& arguments : {Words{"--help"}, Words{"run", "--help"}, Words{"error-time", "-h"}}) {
      const Ended ended = run_on_terminal(Folder(), arguments,
                                          {.columns = columns, .environment = {{"TERM", "xterm"}, {"NO_COLOR", "1"}}});
      std::istringstream lines(ended.out);
      for (std::string line; std::getline(lines, line);) {
        std::erase(line, '\r');
        const bool is_one_word = line.find_last_of(' ') < line.find_first_not_of(' ');
        const bool is_to_be_copied = line.starts_with("  tanor ") || line.starts_with("  source ");
        if (is_one_word || is_to_be_copied) continue;
        EXPECT_LE(count_columns(line), columns) << line;
      }
    }
  }
}

TEST(PageTest, FitsIntoTheWindow) {
  for (const unsigned short columns : std::initializer_list<unsigned short>{50, 80}) {
    const Folder folder;
    write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
    const Ended ended = run_on_terminal(folder, {"run", "s.json"},
                                        {.columns = columns, .environment = {{"TERM", "xterm"}, {"NO_COLOR", "1"}}});
    EXPECT_TRUE(contains(ended.out, "1 support, ")) << ended.out;
    std::istringstream lines(ended.out);
    for (std::string line; std::getline(lines, line);) {
      std::erase(line, '\r');
      EXPECT_LE(count_columns(line), columns) << line;
    }
  }
}

TEST(PageTest, TablesAndVerdictsGoOnBelowAtWords) {
  for (const unsigned short columns : std::initializer_list<unsigned short>{60, 80}) {
    const Folder folder;
    write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
    const Window window{.columns = columns, .environment = {{"TERM", "xterm"}, {"NO_COLOR", "1"}}};
    const auto read = [&](const Words& arguments) {
      const Ended ended = run_on_terminal(folder, arguments, window);
      EXPECT_EQ(ended.code, 0) << ended.out;
      std::istringstream lines(ended.out);
      for (std::string line; std::getline(lines, line);) {
        std::erase(line, '\r');
        EXPECT_LE(count_columns(line), columns) << line;
      }
      return ended.out;
    };
    EXPECT_TRUE(contains(read({"--methods"}), "\nrattle "));
    EXPECT_TRUE(contains(read({"selftest"}), "keep their promise"));
    EXPECT_TRUE(contains(read({"equilibrium", "s.json"}), " after "));
    EXPECT_TRUE(contains(read({"modes", "s.equilibrium.out/equilibrium.json"}), "omega = "));
    EXPECT_TRUE(contains(read({"error-time", "s.json", "--methods", "rk4", "--t-end", "0.01"}), "energy drift"));
  }
}

TEST(HelpTest, AWordThatIsNearlyOneIsRecognized) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));

  EXPECT_TRUE(contains(complaint(folder, {"rnu", "s.json"}), "no command rnu (did you mean run?)"));
  EXPECT_TRUE(contains(complaint(folder, {"help", "chek"}), "no command chek (did you mean check?)"));
  EXPECT_TRUE(contains(complaint(folder, {"run", "s.json", "--reprot"}),
                       "tanor run has no option --reprot (did you mean --report?)"));
  EXPECT_FALSE(contains(complaint(folder, {"run", "s.json", "--xyz"}), "did you mean"));
}

TEST(ColourTest, IsOnATerminalOnlyUnlessTheEnvironmentForbidsIt) {
  const Folder folder;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  const std::string escape = "\x1b[";
  for (const Words& arguments : {Words{"--help"}, Words{"info", "s.json"}, Words{"check", "s.json"}, Words{"fly"}}) {
    EXPECT_TRUE(contains(run_on_terminal(folder, arguments).out, escape)) << arguments[0];
    const std::map<std::string, std::string> silent{{"TERM", "xterm"}, {"NO_COLOR", "1"}}, dumb{{"TERM", "dumb"}},
        empty{{"TERM", "xterm"}, {"NO_COLOR", ""}};
    EXPECT_FALSE(contains(run_on_terminal(folder, arguments, {.environment = silent}).out, escape)) << arguments[0];
    EXPECT_FALSE(contains(run_on_terminal(folder, arguments, {.environment = dumb}).out, escape)) << arguments[0];
    EXPECT_TRUE(contains(run_on_terminal(folder, arguments, {.environment = empty}).out, escape)) << arguments[0];
    const Ended piped = run_program(folder, arguments);
    EXPECT_FALSE(contains(piped.out + piped.err, escape)) << arguments[0];
  }
}

TEST(JsonTest, EveryCommandPrintsJson) {
  const Folder folder;
  std::set<std::string> asked;
  write_text(folder / "s.json", pendulum(R"("t_end": 0.1)"));
  write_text(folder / "m.csv", "0,0,0,0,0.1,0,0,0.2,0,0\n0.5,0,0,0,0.1,0,0,0.2,0,0\n1,0,0,0,0.1,0,0,0.2,0,0\n");
  const auto ask = [&](Words arguments) {
    arguments.push_back("--json");
    asked.insert(arguments[0]);
    const Ended ended = run_program(folder, arguments);
    EXPECT_EQ(ended.code, 0) << arguments[0] << ended.err;
    EXPECT_TRUE(json::accept(ended.out)) << ended.out;
    return json::parse(ended.out, nullptr, false);
  };

  const json run = ask({"run", "s.json"}), solution = ask({"solve", "s.json", "--out", "a.json"});
  const json forces = ask({"forces", "s.json", "--motion", "m.csv"});

  EXPECT_EQ(run, read_json(folder / "s.out/summary.json"));
  EXPECT_EQ(solution, read_json(folder / "a.json"));
  EXPECT_EQ(forces, read_json(folder / "s.out/forces.json"));
  EXPECT_EQ(ask({"info", "s.json"})["degrees_of_freedom"], 4);
  EXPECT_EQ(ask({"check", "s.json"})["rank"]["rank"], 2);
  EXPECT_EQ(ask({"error-time", "s.json", "--methods", "rk4", "--t-end", "0.01", "--quiet"})["rows"].size(), 4u);
  EXPECT_TRUE(ask({"selftest"})[0]["keeps_promise"]);
  const json rest = ask({"equilibrium", "s.json", "--out", "e"});
  EXPECT_EQ(rest, read_json(folder / "e/summary.json"));
  const json modes = ask({"modes", "e/equilibrium.json", "--out", "m"});
  EXPECT_EQ(modes, read_json(folder / "m/summary.json"));
  EXPECT_EQ(ask({"help"}), read_table());
  EXPECT_EQ(ask({"--help"}), read_table());
  EXPECT_EQ(ask({"run", "--help"})[0]["name"], "run");
  const json version = ask({"--version"}), methods = ask({"--methods"});
  EXPECT_EQ(run_program(folder, {"--version"}).out.substr(6, 5), version["version"].get<std::string>().substr(0, 5));
  EXPECT_EQ(version["instruction_set"], build_info().instruction_set);
  for (const json& method : methods) EXPECT_TRUE(contains(run_program(folder, {"--methods"}).out, method["what"]));
  EXPECT_EQ(methods.size(), count(run_program(folder, {"--methods"}).out, "\n"));
  EXPECT_EQ(methods[0]["order"], nullptr);
  EXPECT_TRUE(contains(complaint(folder, {"--json", "run", "s.json"}), "behind the command, as in tanor run --json"));
  EXPECT_TRUE(contains(complaint(folder, {"--version", "--jsn"}), "no option --jsn (did you mean --json?)"));
  EXPECT_EQ(ask({"completion", "zsh"})["script"], run_program(folder, {"completion", "zsh"}).out);
  EXPECT_EQ(ask({"manual", "run"})["page"], run_program(folder, {"manual", "run"}).out);
  EXPECT_EQ(ask({"manual"})["name"], "tanor");
  const json pages = ask({"manual", "--out", "man"});
  EXPECT_EQ(pages["files"].size(), list_names(folder / "man").size());
  EXPECT_TRUE(std::filesystem::exists(folder / std::filesystem::path(pages["files"][1].get<std::string>())));
  // A build may be without view, whose JSON tests/cli/view_test.cpp reads, and without picture.
  asked.insert("view");
  const Ended picture = run_program(folder, {"picture", "s.out", "--json"});
  EXPECT_TRUE(picture.code == 0 ? json::accept(picture.out) : contains(picture.err, "built without cairo"));
  asked.insert("picture");
  for (const json& command : read_table()) {
    EXPECT_TRUE(asked.contains(command["name"])) << command["name"];
    EXPECT_TRUE(std::ranges::any_of(command["options"], [](const json& each) { return each["name"] == "--json"; }));
  }
}

/// Returns the completions that bash offers after words of which the last one is unfinished.
std::set<std::string> complete(const Folder& folder, const Words& words) {
  std::string line = "tanor";
  for (const std::string& word : words) line += " '" + word + "'";
  write_text(folder / "complete.sh", "source ./completion\ncompopt() { :; }\nCOMP_WORDS=(" + line +
                                         ")\nCOMP_CWORD=" + std::to_string(words.size()) +
                                         "\n_tanor\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n");
  const Ended ended = run_script(folder, "tanor completion bash > completion && bash --norc complete.sh");
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(ended.err, "");
  std::set<std::string> offers;
  std::istringstream lines(ended.out);
  for (std::string each; std::getline(lines, each);) offers.insert(each);
  return offers;
}

TEST(CompletionTest, BashOffersCommandsOptionsMethodsAndFiles) {
  using Offers = std::set<std::string>;
  const Folder folder;
  for (const char* name : {"net.json", "notes.txt", "a.csv"}) write_text(folder / name, "{}");
  std::filesystem::create_directory(folder / "nets");
  std::filesystem::create_directory(folder / "two words.out");

  EXPECT_EQ(complete(folder, {"s"}), (Offers{"solve", "selftest"}));
  EXPECT_EQ(complete(folder, {"run", "n"}), (Offers{"net.json", "nets"}));
  EXPECT_EQ(complete(folder, {"run", "--re"}), (Offers{"--report", "--resume"}));
  EXPECT_EQ(complete(folder, {"run", "net.json", "--method", "radau"}), (Offers{"radau5"}));
  EXPECT_EQ(complete(folder, {"run", "net.json", "--out", "ne"}), (Offers{"nets"}));
  EXPECT_EQ(complete(folder, {"forces", "net.json", "--motion", "a"}), (Offers{"a.csv"}));
  EXPECT_EQ(complete(folder, {"error-time", "net.json", "--methods", "rk4,ratt"}),
            (Offers{"rk4,rattle", "rk4,rattle4", "rk4,rattle6"}));
  EXPECT_EQ(complete(folder, {"help", "run"}), (Offers{"run"}));
  for (const char* begun : {"two", "two\\ w", "\"two w"})
    EXPECT_EQ(complete(folder, {"view", begun}), (Offers{"two words.out"})) << begun;
  EXPECT_EQ(complete(folder, {"run", "net.json", "--trajectory", "xyz,h"}), (Offers{"xyz,h5md"}));
  EXPECT_EQ(complete(folder, {"picture", "nets", "--show", "rods,t"}), (Offers{"rods,tangent"}));
  EXPECT_EQ(complete(folder, {"picture", "nets", "--projection", "o"}), (Offers{"orthographic"}));
  EXPECT_EQ(complete(folder, {"run", "net.json", "--isa", "b"}), (Offers{"baseline"}));
  EXPECT_EQ(complete(folder, {"completion", ""}), (Offers{"bash", "zsh"}));
}

TEST(CompletionTest, NamesTheShellsThatItKnows) {
  EXPECT_TRUE(run_program(Folder(), {"completion", "zsh"}).out.starts_with("#compdef tanor\n"));
  EXPECT_TRUE(contains(complaint(Folder(), {"completion", "fish"}), "bash or zsh, not 'fish'"));
}

TEST(ManualTest, HasAPageForEachCommandWithItsOptions) {
  const Folder folder;
  ASSERT_EQ(run_program(folder, {"manual", "--out", "man"}).code, 0);

  EXPECT_TRUE(contains(read_text(folder / "man/tanor.1"), ".TH TANOR 1"));
  for (const json& command : read_table()) {
    const std::string page = read_text(folder / "man" / ("tanor-" + command["name"].get<std::string>() + ".1"));
    for (const char* part : {".SH NAME\n", ".SH SYNOPSIS\n", ".SH EXAMPLES\n", ".SH EXIT STATUS\n"})
      EXPECT_TRUE(contains(page, part)) << page;
    for (const json& option : command["options"]) {
      std::string name = option["name"];
      for (std::size_t at = 0; (at = name.find('-', at)) != std::string::npos; at += 2) name.insert(at, "\\");
      EXPECT_TRUE(contains(page, "\n.B " + name)) << name << page;
    }
  }
}

/// A run shows progress on the terminal, and then somebody presses Ctrl-C.
TEST(ProgressOnATerminal, FitsIntoTheWindowAndGivesWayToCtrlC) {
  for (const unsigned short columns : std::initializer_list<unsigned short>{30, 70, 120}) {
    const Folder folder;
    write_text(folder / "s.json",
               pendulum(R"("t_end": 100000, "method": "rk4", "step": 1e-4, "output_every": 100000)"));
    bool has_typed = false;
    const Ended ended = run_on_terminal(folder, {"run", "s.json"},
                                        {.columns = columns, .environment = {{"TERM", "xterm"}, {"NO_COLOR", "1"}}},
                                        [&](const std::string& shown) {
                                          if (has_typed || count(shown, "\r\x1b[K") < 3) return std::string();
                                          has_typed = true;
                                          return std::string("\x03");
                                        });

    EXPECT_EQ(ended.code, 130) << ended.out;
    EXPECT_TRUE(contains(ended.out, " left  ")) << ended.out;
    EXPECT_EQ(contains(ended.out, " left  violation "), columns > 30) << ended.out;
    EXPECT_EQ(contains(ended.out, "[    "), columns > 70) << ended.out;
    EXPECT_TRUE(contains(ended.out, "stopped at t = ")) << ended.out;
    EXPECT_TRUE(contains(ended.out, "--resume")) << ended.out;
    const std::size_t begin = ended.out.find("\r\x1b[K") + 4, end = ended.out.find('\r', begin);
    EXPECT_LT(end - begin, columns) << ended.out;
  }
}

}  // namespace
}  // namespace tanor::cli
