// Measures what a simulation costs before and besides its steps:
//   set_up [--long] [--scene NAME] [--json FILE]
// Prints seconds of the constructor (numbering, plan, analysis, a consistent start) and bytes a rod or bead that stay
// after two steps, by scene, method and linear solver, one thread, each in a process of its own. --long adds a net of
// 1000 x 1000 and a chain of 1e7 beads. --scene selects rows of that scene alone. A flat net hangs by two corners, so
// that its upper row is redundant.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "bench_scenes.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;

struct Row {
  std::string scene;
  Method method;
  LinearSolver solver;
  double bar;  ///< wanted seconds; 0: none
};

constexpr std::array<Method, 3> methods = {Method::Rattle, Method::Dop853, Method::Taylor};

std::vector<Row> list_rows(bool with_long) {
  constexpr double bar_of_paths = 2.0, bar_of_general = 10.0;
  std::vector<Row> rows;
  for (const char* const scene : {"chain 1e6", "clusters 1e5 x 10", "spheres 1e6", "net 300", "lattice 20"}) {
    for (const Method method : methods)
      rows.push_back({scene, method, LinearSolver::Auto, std::string(scene) == "chain 1e6" ? bar_of_paths : 0.0});
  }
  rows.push_back({"shuffled chain 1e6", Method::Dop853, LinearSolver::Auto, bar_of_paths});
  rows.push_back({"chain 1e6", Method::Dop853, LinearSolver::General, bar_of_general});
  rows.push_back({"clusters 1e5 x 10", Method::Dop853, LinearSolver::General, bar_of_general});
  rows.push_back({"flat net 300", Method::Rattle, LinearSolver::Auto, 1.5});
  if (with_long) {
    rows.push_back({"net 1000", Method::Rattle, LinearSolver::Auto, 5.0});
    rows.push_back({"chain 1e7", Method::Rattle, LinearSolver::Auto, 12.0});
  }
  return rows;
}

/// Returns the memory of this process, bytes: "VmRSS" now, "VmHWM" the most so far.
double resident_bytes(const std::string& which) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.starts_with(which + ":")) return 1024.0 * std::stod(line.substr(which.size() + 1));
  }
  throw std::runtime_error("no " + which + " in /proc/self/status");
}

System make(const std::string& name) {
  if (name == "chain 1e7") return make_random_walk(10000000);
  if (name == "net 1000") return make_generated(R"({"kind": "net", "columns": 1000, "rows": 1000})");
  if (name == "flat net 300") {
    System net = make("net 300");
    net.velocities.clear();
    net.supports = {{"corners", {0, 299}, {}}};
    net.velocities.clear();
    net.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    return net;
  }
  const auto& scenes = bench_scenes();
  return std::find_if(scenes.begin(), scenes.end(), [&](const BenchScene& scene) { return scene.name == name; })
      ->make();
}

/// Measures a row and returns it as JSON.
std::string measure(const Row& row) {
  malloc_trim(0);
  const double before = resident_bytes("VmRSS");
  System system = make(row.scene);
  const bool is_of_beads = !std::holds_alternative<Rods>(system.constraints.front());
  MotionOptions motion;
  motion.method = row.method;
  motion.start = StartMode::Project;
  motion.step = 1e-5;
  std::unique_ptr<Simulation> simulation;
  const double processor_before = processor_seconds();
  const double seconds = seconds_of([&] {
    simulation = std::make_unique<Simulation>(std::move(system), motion,
                                              SolverOptions{.linear_solver = row.solver, .threads = 1});
  });
  const double processor = processor_seconds() - processor_before;
  const auto check = [&](const Outcome& outcome) {
    if (!outcome.ok()) throw std::runtime_error(row.scene + ": " + outcome.what);
  };
  check(simulation->outcome());
  int steps = 0;
  check(simulation->advance_to(2.0 * motion.step, [&](const MotionReport&) { return ++steps < 2; }));
  malloc_trim(0);
  const PlanSummary& plan = simulation->plan();
  const auto members = static_cast<double>(is_of_beads ? plan.points : plan.equations);
  if (plan.prestress_rigid_equations.empty() == (row.scene == "flat net 300"))
    throw std::runtime_error(row.scene + ": " + std::to_string(plan.prestress_rigid_equations.size()) +
                             " rows held rigid by prestress");
  const double bytes = (resident_bytes("VmRSS") - before) / members;
  return fmt::format(
      R"({{"scene": "{}", "method": "{}", "linear_solver": "{}", "members": {:.0f}, "seconds": {:.3f}, "bar": {:g}, )"
      R"("processor_seconds": {:.3f}, )"
      R"("bytes": {:.0f}, "most_resident": {:.4g}}})",
      row.scene, name_of(row.method), plan.linear_solver(), members, seconds, row.bar, processor, bytes,
      resident_bytes("VmHWM"));
}

/// Runs measure(row) in a process of its own, so that memory left over by other rows is not counted.
std::string measure_apart(const Row& row) {
  std::array<int, 2> pipe_ends{};
  if (pipe(pipe_ends.data()) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    std::string line;
    try {
      line = measure(row);
    } catch (const std::exception& error) {
      fmt::print(stderr, "set_up: {}: {}\n", row.scene, error.what());
    }
    const bool is_written = write(pipe_ends[1], line.data(), line.size()) == static_cast<ssize_t>(line.size());
    _exit(is_written && !line.empty() ? 0 : 1);
  }
  close(pipe_ends[1]);
  std::string line(4096, '\0');
  const ssize_t size = read(pipe_ends[0], line.data(), line.size());
  close(pipe_ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (status != 0 || size <= 0) throw std::runtime_error(row.scene + " failed");
  line.resize(static_cast<std::size_t>(size));
  return line;
}

}  // namespace

int main(int argc, char** argv) try {
  bool with_long = false;
  std::string file, scene;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--long")
      with_long = true;
    else if (word == "--scene" && k + 1 < argc)
      scene = argv[++k];
    else if (word == "--json" && k + 1 < argc)
      file = argv[++k];
    else
      throw std::runtime_error("unknown word " + word);
  }
  std::vector<std::string> lines;
  for (const Row& row : list_rows(with_long || !scene.empty())) {
    if (!scene.empty() && row.scene != scene) continue;
    lines.push_back(measure_apart(row));
    fmt::print("{}\n", lines.back());
    std::fflush(stdout);
  }
  if (!file.empty()) std::ofstream(file) << fmt::format("[\n{}\n]\n", fmt::join(lines, ",\n"));
} catch (const std::exception& error) {
  fmt::print(stderr, "set_up: {}\n", error.what());
  return 1;
}
