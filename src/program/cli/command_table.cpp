#include "cli/command_table.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <tanor/build_info.hpp>
#include <tanor/error.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>

#include "base/suggestion.hpp"
#include "cli/values.hpp"

namespace tanor::cli {
namespace {

/// Reads any text but an empty one. `Target` is a string, a path, or an optional one of them.
template <class Target>
Value text(Word word, Target* target) {
  return {word, [target](const std::string& given) -> std::string {
            if (given.empty()) return "must not be empty";
            *target = given;
            return {};
          }};
}

/// Reads a number that satisfies a condition, which `wanted` tells in words.
template <class Number, class Condition, class Target>
Value checked(const Condition& condition, const std::string& wanted, Target* target) {
  return {Word::Number, [=](const std::string& given) -> std::string {
            const std::optional<Number> number = read_number<Number>(given);
            if (!number || !condition(*number)) return "must be " + wanted + ", not '" + given + "'";
            *target = *number;
            return {};
          }};
}

Value positive(std::optional<double>* target) {
  return checked<double>([](double x) { return x > 0.0 && std::isfinite(x); }, "a finite number > 0", target);
}

Value number(std::optional<double>* target) {
  return checked<double>([](double x) { return std::isfinite(x); }, "a finite number", target);
}

/// Reads a time that a clock can add, s.
Value interval(std::optional<double>* target) {
  return checked<double>([](double x) { return x >= 0.0 && x <= 1e9; }, "a number from 0 to 1e9", target);
}

template <class Target>
Value whole(int least, int most, const std::string& range, Target* target) {
  return checked<int>([=](int k) { return least <= k && k <= most; }, "a whole number " + range, target);
}

Value threads(std::optional<int>* target) {
  return whole(0, scene::most_threads, "0 (= all) to " + std::to_string(scene::most_threads), target);
}

std::vector<std::string> names_of_methods() {
  std::vector<std::string> names;
  for (const MethodTraits& each : methods()) names.emplace_back(each.name);
  return names;
}

Value method(std::optional<std::string>* target) {
  return offer(names_of_methods(), {Word::Text, [target](const std::string& given) -> std::string {
                                      const std::vector<std::string> names = names_of_methods();
                                      if (std::ranges::find(names, given) == names.end())
                                        return "must be one of those that tanor --methods lists, not '" + given + "'" +
                                               detail::suggest(given, names);
                                      *target = given;
                                      return {};
                                    }});
}

/// Reads words of an enumeration between commas; one that comes twice counts once.
template <class Enum>
Value names(std::optional<std::vector<Enum>>* target) {
  std::vector<std::string> known;
  for (const auto& [each, name] : enum_names<Enum>) known.emplace_back(name);
  return offer(known,
               {Word::Text,
                [target, known](const std::string& given) -> std::string {
                  std::vector<std::string> words;
                  if (std::string wrong = list(&words).take(given); !wrong.empty()) return wrong;
                  std::vector<Enum>& values = target->emplace();
                  for (const std::string& word : words) {
                    const std::optional<Enum> value = value_of<Enum>(word);
                    if (!value)
                      return fmt::format("must be names of {} between commas, not '{}'", fmt::join(known, ", "), word);
                    if (std::ranges::find(values, *value) == values.end()) values.push_back(*value);
                  }
                  return {};
                }},
               Word::Choices);
}

Value yes(bool* target, bool says = true) {
  return {Word::Text, [=](const std::string&) -> std::string {
            *target = says;
            return {};
          }};
}

/// Sets the instruction set before the first hot loop runs, which chooses for good.
Value instruction_set() {
  return offer({"avx512", "avx2", "baseline"}, {Word::Text, [](const std::string& given) -> std::string {
                                                  setenv("TANOR_ISA", given.c_str(), 1);
                                                  try {
                                                    (void)build_info();
                                                  } catch (const InputError& error) {
                                                    return error.what();
                                                  }
                                                  return {};
                                                }});
}

Argument scene_argument(Options* options) {
  return {"SCENE", text(Word::Scene, &options->scene), "scene file (JSON)"};
}

/// Adds the options that every command has.
Command complete(Options* options, Command command) {
  command.options.push_back(
      {"--quiet", "", yes(&options->quiet), "no progress and no notes; warnings and errors stay"});
  command.options.push_back({"--json", "", yes(&options->json), "print the result as JSON"});
  command.options.push_back(
      {"--isa", "NAME", instruction_set(),
       "instruction set of the hot loops: avx512, avx2 or baseline, as TANOR_ISA; default the best"});
  return command;
}

Command describe_run(Options* options) {
  scene::Overrides* over = &options->overrides;
  return complete(
      options,
      {.name = "run",
       .summary = "simulate a scene; trajectory, summary, page",
       .text = "Moves the scene from t_start (0 s) to t_end. Writes summary.json, report.txt, trajectory.xyz (OVITO), "
               "trajectory.pvd (ParaView) and a checkpoint into the folder of results.\n"
               "Ctrl-C ends the step and leaves all files whole; --resume goes on there. Options win over the scene. "
               "With --quiet the page of numbers is in report.txt alone.",
       .arguments = {scene_argument(options)},
       .options = {{"--out", "DIR", text(Word::Folder, &options->out), "folder of the results; default <scene>.out"},
                   {"--method", "METHOD", method(&over->method),
                    "how to step, one of those that tanor --methods lists; default auto"},
                   {"--step",
                    "H",
                    positive(&over->step),
                    "fixed step, or the first one to try with adaptive methods, s",
                    false,
                    {"--rtol", "--atol"}},
                   {"--rtol", "R", positive(&over->rtol), "relative tolerance of a step; default 1e-8"},
                   {"--atol", "A", positive(&over->atol), "absolute tolerance, m; default 1e-10 of the size"},
                   {"--max-step", "H", positive(&over->max_step), "no step is longer, s"},
                   {"--t-end", "T", number(&over->t_end), "end of the simulated time, s"},
                   {"--threads", "P", threads(&over->threads), "threads; 0: all"},
                   {"--trajectory", "LIST", names(&over->trajectory),
                    "files of the frames, names between commas: xyz, vtp, lammps, h5md, csv, npz; default xyz,vtp"},
                   {"--resume",
                    "",
                    yes(&options->resume),
                    "go on from the checkpoint of an interrupted run",
                    false,
                    {"--overwrite"}},
                   {"--overwrite", "", yes(&options->overwrite), "begin anew where the same run was interrupted"},
                   {"--checkpoint-every", "S", interval(&options->checkpoint_every),
                    "also between frames, s of the clock; 0: as often as takes a twentieth of the time; default 60"},
                   {"--report", "", yes(&options->report),
                    "write report.html too: the motion in 3-D, histories, certificate; tanor view opens it"},
                   {"--verbose", "", yes(&options->verbose),
                    "print each identity of the certificate, with its number"}},
       .examples = {{"tanor run net.json --report", "simulate, and make a page for the browser"},
                    {"tanor run net.json --method rattle --step 1e-3", "another method, fixed steps"},
                    {"tanor run net.json --resume", "go on after Ctrl-C or a power cut"}}});
}

Command describe_solve(Options* options) {
  return complete(
      options, {.name = "solve",
                .summary = "accelerations, reactions and multipliers at t_start (0 s)",
                .text = "Solves the dynamics once, at the start of the scene, and prints the answer as JSON.",
                .arguments = {scene_argument(options)},
                .options = {{"--out", "FILE", text(Word::File, &options->out), "JSON file; default: standard output"}},
                .examples = {{"tanor solve net.json | jq .certificate", "is the answer proven?"},
                             {"tanor solve net.json --out start.json", "keep it"}}});
}

Command describe_forces(Options* options) {
  return complete(
      options,
      {.name = "forces",
       .summary = "reactions and control forces of a given motion",
       .text = "Inverse dynamics: the motion is given, the forces that it takes are found. Writes forces.json and "
               "tables into the folder of results.",
       .arguments = {scene_argument(options)},
       .options = {{"--motion", "FILE", text(Word::File, &options->motion),
                    "the motion, .csv or .npy, rows t, x1, y1, z1, x2, …", true},
                   {"--out", "DIR", text(Word::Folder, &options->out), "folder of the results; default <scene>.out"}},
       .examples = {{"tanor forces crane.json --motion drive.csv", "what the drives of the crane must do"}}});
}

Command describe_info(Options* options) {
  return complete(options, {.name = "info",
                            .summary = "what a scene holds, how it is solved, what a step will cost",
                            .text = "Reads and plans the scene. It solves nothing and writes nothing.",
                            .arguments = {scene_argument(options)},
                            .examples = {{"tanor info net.json", "before a long run"},
                                         {"tanor info net.json --json | jq .predicted", "the cost of each method"}}});
}

Command describe_check(Options* options) {
  return complete(
      options,
      {.name = "check",
       .summary = "is the start consistent, are constraints redundant, is the answer proven",
       .text = "Tries the start against the constraints, finds the rank and names redundant constraints, and certifies "
               "the answer at t_start. It writes nothing.",
       .arguments = {scene_argument(options)},
       .options = {{"--verbose", "", yes(&options->verbose), "the identities of the certificate in symbols"}},
       .examples = {{"tanor check bridge.json", "why does a run complain?"}}});
}

std::string list_compared_methods() {
  std::vector<std::string> names;
  for (const MethodTraits& each : methods()) {
    if (each.is_compared) names.emplace_back(each.name);
  }
  return fmt::format("{}", fmt::join(names, ","));
}

Command describe_error_time(Options* options) {
  scene::Overrides* over = &options->overrides;
  return complete(
      options,
      {.name = "error-time",
       .summary = "error against run time of each method: tables and plots",
       .text = "Runs the scene with each method at four steps or tolerances, against a finer run of another method.",
       .arguments = {scene_argument(options)},
       .options = {{"--methods", "LIST", offer(names_of_methods(), list(&options->methods), Word::Choices),
                    "names between commas; default " + list_compared_methods() + " (the scene's own)"},
                   {"--out", "DIR", text(Word::Folder, &options->out),
                    "folder of tables and plots; default <scene>.out"},
                   {"--reference", "FILE", text(Word::File, &options->reference),
                    "file with the state at the end; default: another method"},
                   {"--step", "H", positive(&over->step), "coarsest fixed step, s"},
                   {"--t-end", "T", number(&over->t_end), "end of the simulated time, s"},
                   {"--threads", "P", threads(&over->threads), "threads; 0: all"}},
       .examples = {{"tanor error-time net.json", "which method is best for this scene?"},
                    {"tanor error-time net.json --methods taylor,dop853", "two of them"}}});
}

Value count_of_modes(std::optional<std::size_t>* target) {
  return {Word::Number, [target](const std::string& given) -> std::string {
            const std::optional<std::size_t> number =
                given == "all" ? std::optional(ModesOptions::all) : read_number<std::size_t>(given);
            if (!number || *number == 0) return "must be a whole number > 0, or all, not '" + given + "'";
            *target = number;
            return {};
          }};
}

Command describe_equilibrium(Options* options) {
  return complete(
      options,
      {.name = "equilibrium",
       .summary = "where a scene rests, and whether it is stable there",
       .text = "Finds positions and reactions at rest from the positions of the scene, which need not satisfy the "
               "constraints. Writes summary.json, report.html (tanor view opens it), equilibrium.xyz and "
               "equilibrium.json, the scene at rest, into the folder of results.",
       .arguments = {scene_argument(options)},
       .options = {{"--modes", "N", count_of_modes(&options->num_modes), "the lowest modes about it too; all"},
                   {"--out", "DIR", text(Word::Folder, &options->out),
                    "folder of the results; default <scene>.equilibrium.out"}},
       .examples = {{"tanor equilibrium net.json", "where does it hang?"},
                    {"tanor run net.equilibrium.out/equilibrium.json --t-end 1", "does it stay there?"}}});
}

Command describe_modes(Options* options) {
  return complete(
      options, {.name = "modes",
                .summary = "frequencies and shapes of small vibrations about an equilibrium",
                .text = "Finds the lowest modes about the positions of the scene, which must be an equilibrium. Writes "
                        "summary.json, report.html and the shapes into the folder of results; tanor view opens it.",
                .arguments = {scene_argument(options)},
                .options = {{"--count", "N", count_of_modes(&options->num_modes),
                             "modes, the lowest ones; all; default: that of the scene, or 10"},
                            {"--out", "DIR", text(Word::Folder, &options->out),
                             "folder of the results; default <scene>.modes.out"},
                            {"--pictures", "", yes(&options->pictures),
                             "write the vibration in each mode, mode_<k>.pvd, for tanor picture --mode and ParaView"}},
                .examples = {{"tanor modes hanging.json --count 20", "how does it swing?"}}});
}

Command describe_selftest(Options* options) {
  return complete(options,
                  {.name = "selftest",
                   .summary = "published and closed-form problems: digits won, in seconds",
                   .text = "Solves problems whose answers are known and compares. It reads and writes nothing.",
                   .examples = {{"tanor selftest", "does tanor work on this machine?"}}});
}

Command describe_view(Options* options) {
  return complete(
      options,
      {.name = "view",
       .summary = "show the page of a run, a state of rest or modes in the browser",
       .text =
           "Serves the folder of equilibrium, of modes, or of a run that was started with --report, to this machine "
           "alone "
           "and read-only, and opens the browser. The page of a run that goes on follows it. Ctrl-C ends the server.",
       .arguments = {{"DIR", text(Word::Folder, &options->folder), "folder of the results, such as net.out"}},
       .options = {{"--port", "PORT", whole(0, 65535, "0 (= any that is free) to 65535", &options->server.port),
                    "port on 127.0.0.1; default: any that is free"},
                   {"--no-open", "", yes(&options->server.no_open), "start no browser"}},
       .examples = {{"tanor view net.out", "look at a run"},
                    {"tanor view net.out --no-open --port 8080", "on a machine without a screen"}}});
}

Command describe_picture(Options* options) {
  picture::Style* style = &options->style;
  return complete(
      options,
      {.name = "picture",
       .summary = "an instant of a run, a state of rest or a mode as a picture, PNG, for papers",
       .text =
           "Draws the points, the rods in the colours of their tension, the forces as arrows, and the guides, from the "
           "frames in trajectory.pvd; all pictures of a run have the same colours, arrows and view. Between frames "
           "positions follow a cubic polynomial, forces a straight line.",
       .arguments = {{"DIR", text(Word::Folder, &options->folder), "folder of the results, such as net.out"}},
       .options =
           {{"--time", "T", number(&options->instant.time), "the instant, s; default: the last frame"},
            {"--mode", "K", whole(1, 1'000'000, "> 0", &options->instant.mode),
             "a mode, of tanor modes --pictures, at its largest moves"},
            {"--out", "FILE", text(Word::File, &options->out), "the picture; default DIR/picture.png"},
            {"--size", "WxH", size_of_picture(style), "pixels; default 1600x1000"},
            {"--view", "VIEW", view_of_picture(style),
             "auto, x, -x, y, -y, z, -z, or AROUND,ABOVE: degrees around the vertical and above; default auto"},
            {"--projection", "KIND", projection_of_picture(style),
             "perspective or orthographic; default: perspective, but for a motion in a plane"},
            {"--scale", "N", positive(&style->tension_scale),
             "tension at which the colours end, N; default: that of the run"},
            {"--show", "LIST", parts_of_picture(style),
             "of points, rods, reactions (or normal, tangent alone), guides, legend, names between commas; default: "
             "all"}},
       .examples = {{"tanor picture net.out --time 0.25", "net.out/picture.png"},
                    {"tanor picture net.out --time 0.25 --view 30,15 --size 2400x1600 --out net.png", "for a paper"},
                    {"tanor picture net.modes.out --mode 2", "net.modes.out/mode_2.png"},
                    {"tanor picture net.out --show rods,legend", "the last frame, rods alone"}}});
}

Command describe_help(Options* options) {
  return {.name = "help",
          .summary = "this overview, or all about one command",
          .text = "The same as tanor --help and tanor COMMAND --help.",
          .arguments = {{"COMMAND", text(Word::Command, &options->topic), "a command; default: all of them", false}},
          .options = {{"--json", "", yes(&options->json), "print the table of commands as JSON"}},
          .examples = {{"tanor help run", "all options of run"}}};
}

Command describe_completion(Options* options) {
  return {.name = "completion",
          .summary = "a script with which bash or zsh completes commands, options and files",
          .text = "Debian packages of tanor install it. Elsewhere the shell's start file reads it.",
          .arguments = {{"SHELL", offer({"bash", "zsh"}, text(Word::Text, &options->topic)), "bash or zsh"}},
          .options = {{"--json", "", yes(&options->json), "print the script inside JSON"}},
          .examples = {{"source <(tanor completion bash)", "in ~/.bashrc"},
                       {"source <(tanor completion zsh)", "in ~/.zshrc, after compinit"}}};
}

Command describe_manual(Options* options) {
  return {.name = "manual",
          .summary = "the manual page of tanor or of a command, for man",
          .text = "Prints roff. Debian packages of tanor install the pages.",
          .arguments = {{"COMMAND", text(Word::Command, &options->topic), "a command; default: tanor itself", false}},
          .options = {{"--out", "DIR", text(Word::Folder, &options->out), "write all pages into a folder instead"},
                      {"--json", "", yes(&options->json), "print the page, or the files written, as JSON"}},
          .examples = {{"tanor manual run | man -l -", "read one that is not installed"}}};
}

}  // namespace
std::vector<Command> make_commands(Options* options) {
  std::vector<Command> commands;
  for (const auto& describe : {describe_run, describe_view, describe_picture, describe_info, describe_check,
                               describe_solve, describe_forces, describe_error_time, describe_equilibrium,
                               describe_modes, describe_selftest, describe_help, describe_completion, describe_manual})
    commands.push_back(describe(options));
  return commands;
}

const std::vector<Command>& all_commands() {
  static Options unread;
  static const std::vector<Command> commands = make_commands(&unread);
  return commands;
}

const Command& find_command(const std::string& name) {
  std::vector<std::string> names;
  for (const Command& each : all_commands()) {
    if (each.name == name) return each;
    names.push_back(each.name);
  }
  throw InputError("", "there is no command " + name + detail::suggest(name, names) + "; see tanor --help");
}

namespace {

std::vector<Row> program_options() {
  return {{"-h, --help", "this overview; behind a command: all about it"},
          {"--version", "the version, and what this program was built of"},
          {"--methods", "the methods: name, order, steps, what it is"},
          {"--json", "with --version or --methods: print it as JSON"}};
}

std::vector<Row> exit_meanings() {
  return {{"0", "done; redundant but consistent constraints are no fault"},
          {"2", "bad input or usage: one line says what and where, nothing was written"},
          {"3", "no answer, no unique one, not certified, or not within the tolerance"},
          {"4", "memory, disk, a folder in use, standard output or another failure of the machine"},
          {"129, 130, 143", "SIGHUP, SIGINT, SIGTERM came; files are whole, run --resume goes on"}};
}

std::vector<Row> first_examples() {
  return {{"tanor info net.json", "what is in it, and what will a step cost?"},
          {"tanor run net.json --report", "simulate; results go to net.out"},
          {"tanor check net.json", "is the start consistent, what is redundant?"},
          {"tanor help run", "all options of a command"}};
}

}  // namespace

std::vector<std::string> list_program_options() {
  std::vector<std::string> names;
  for (const auto& [term, what] : program_options()) names.push_back(term.substr(term.find("--")));
  return names;
}

std::vector<Section> sections_of_program() {
  std::vector<Row> commands;
  for (const Command& each : all_commands()) commands.push_back({each.name, each.summary});
  return {{"Commands", commands},
          {"Options", program_options()},
          {"Examples", first_examples()},
          {exit_codes, exit_meanings()}};
}

std::vector<Section> sections_of(const Command& command, const char* help) {
  std::vector<Row> arguments, options;
  for (const Argument& each : command.arguments) arguments.push_back({each.name, each.what});
  for (const Option& each : command.options)
    options.push_back({each.place.empty() ? each.name : each.name + " " + each.place, describe(each)});
  options.push_back({"-h, --help", help});
  return {
      {"Arguments", arguments}, {"Options", options}, {"Examples", command.examples}, {exit_codes, exit_meanings()}};
}

std::string describe(const Option& option) {
  std::string what = option.what;
  if (option.is_required) what += " (required)";
  for (const std::string& other : option.excludes)
    what += (&other == &option.excludes[0] ? "; not with " : ", ") + other;
  return what;
}

std::string usage(const Command& command) {
  std::string line = "tanor " + command.name;
  for (const Argument& each : command.arguments) line += each.is_required ? " " + each.name : " [" + each.name + "]";
  std::size_t optional = command.options.size();
  for (const Option& each : command.options) {
    if (!each.is_required) continue;
    line += " " + each.name + " " + each.place;
    --optional;
  }
  return line + (optional > 0 ? " [OPTION...]" : "");
}

}  // namespace tanor::cli
