// Compares steps of dop853 that keep the factor of S from their begin (SolverOptions::reuse) with steps that factorize
// at
// every evaluation, by tanor or CHOLMOD, in turn in one process, one thread:
//   reuse [--markdown FILE] [NAME …]      scenes whose name begins so; default: all of them
// Nets and lattices hang by two corners, fall, and waves run across them. Errors are those of the positions at the end,
// against a run with a hundredth of the tolerance.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include <tanor/tanor.hpp>

#include "bench_scenes.hpp"
#include "cholmod_baseline.hpp"
#include "dynamics/forms.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

struct ReuseScene {
  std::string name, generate;
  double t_end, rtol;
  int rounds;
  double bar;  // beside CHOLMOD
};

const std::vector<ReuseScene> scenes = {
    {"net 30", R"({"kind": "net", "columns": 30, "rows": 30})", 0.4, 1e-6, 5, 2.0},
    {"net 100", R"({"kind": "net", "columns": 100, "rows": 100})", 0.15, 1e-6, 3, 3.5},
    {"net 300", R"({"kind": "net", "columns": 300, "rows": 300})", 0.02, 1e-6, 1, 3.0},
    {"lattice 10", R"({"kind": "lattice", "size": [10, 10, 10]})", 0.1, 1e-6, 5, 2.5},
    {"lattice 20", R"({"kind": "lattice", "size": [20, 20, 20]})", 0.05, 1e-6, 1, 2.5},
};

System make_system(const ReuseScene& scene) {
  System system = make_generated(scene.generate);
  system.supports = {{"corners", {0, static_cast<Index>(system.num_points() - 1)}, {}}};
  system.forces = {Gravity{"gravity", {0.0, 0.0, -9.81}}};
  return system;
}

struct Run {
  double seconds = 0.0;
  MotionReport report;
  std::vector<double> places;
};

Run run(const ReuseScene& scene, const System& system, double rtol, bool reuse) {
  MotionOptions motion;
  motion.method = Method::Dop853;
  motion.rtol = rtol;
  motion.atol = 1e-2 * rtol;
  motion.start = StartMode::Project;
  SolverOptions solver;
  solver.threads = 1;
  solver.reuse = reuse;
  Simulation simulation(system, motion, solver);
  Run result;
  Outcome outcome = simulation.outcome();
  if (outcome.ok()) result.seconds = seconds_of([&] { outcome = simulation.advance_to(scene.t_end); });
  if (!outcome.ok()) throw std::runtime_error(scene.name + ": " + outcome.what);
  result.report = simulation.report();
  result.places.assign(simulation.positions().begin(), simulation.positions().end());
  return result;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double result = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) result = std::max(result, std::abs(a[i] - b[i]));
  return result;
}

/// Times assembly and factorization by CHOLMOD at the start of a scene, s.
class CholmodTime {
 public:
  explicit CholmodTime(const System& system)
      : forms_(system, {.linear_solver = LinearSolver::General, .threads = 1}),
        blocks_(forms_.normal->linearization().blocks()),
        cholmod_(forms_.model.incidences, forms_.model.inverse_mass, forms_.model.numbering.first_idle_row()) {
    std::vector<double> r(system.positions.size()), v(r.size());
    Workspace& work = forms_.work;
    const Model& model = forms_.model;
    model.numbering.gather_points(system.positions, r);
    work.prescribe_all(0.0, r.data(), v.data());
    work.constraints.evaluate_gradients(model.parallel, r.data(), blocks_.data());
    cholmod_.factorize(blocks_.data());
  }
  double take() {
    constexpr int repeats = 5;
    std::vector<double> times;
    for (int k = 0; k < repeats; ++k) times.push_back(seconds_of([&] { cholmod_.factorize(blocks_.data()); }));
    return median(times);
  }

 private:
  Forms forms_;
  std::vector<double> blocks_;
  CholmodBaseline cholmod_;
};

/// Returns a row of the table.
std::string measure(const ReuseScene& scene) {
  const System system = make_system(scene);
  const std::vector<double> reference = run(scene, system, 1e-2 * scene.rtol, true).places;
  CholmodTime cholmod(system);
  Run each, reused;
  std::vector<double> ratios, times, cholmod_ratios;
  for (int round = 0; round < scene.rounds; ++round) {
    each = run(scene, system, scene.rtol, false);
    reused = run(scene, system, scene.rtol, true);
    ratios.push_back(each.seconds / reused.seconds);
    times.push_back(reused.seconds);
    // The time with CHOLMOD is that of the same steps with its time in place of ours.
    const PhaseTimes& spent = each.report.times;
    const double with_cholmod = each.seconds - spent.assemble - spent.factor +
                                static_cast<double>(each.report.counters.factorizations) * cholmod.take();
    cholmod_ratios.push_back(with_cholmod / reused.seconds);
  }
  const auto per_solve = [](const Counters& counters) {
    return static_cast<double>(counters.iterations) / static_cast<double>(counters.solves);
  };
  return fmt::format("| {} | {} | {} | {} | {} | {:.1f} | {:.1e} | {:.1e} | {:.3g} | {:.2f} | {:.2f} | {} |\n",
                     scene.name, each.report.steps, reused.report.steps, each.report.counters.factorizations,
                     reused.report.counters.factorizations, per_solve(reused.report.counters),
                     largest_difference(each.places, reference), largest_difference(reused.places, reference),
                     median(times), median(ratios), median(cholmod_ratios), scene.bar);
}

}  // namespace

int main(int argc, char** argv) try {
  std::string file;
  std::vector<std::string> wanted;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--markdown" && k + 1 < argc) {
      file = argv[++k];
    } else {
      wanted.push_back(word);
    }
  }
  std::string page =
      "# Re-use of factors: dop853 with and without\n\n"
      "Nets and lattices that hang by two corners, fall and wave; one thread, in turn in one process, medians; errors "
      "in\nm, against a hundredth of the tolerance (rtol 1e-6). `own`: time with a factor of ours at every evaluation "
      "over time\nwith re-use; `CHOLMOD`: the same run with the time of assembly + CHOLMOD (best of AMD and METIS, one "
      "thread of BLAS)\nin place of our factor's. Repeat with `scripts/bench`.\n\n"
      "| scene | steps | with re-use | factorizations | with re-use | iterations a solve | error | with re-use | s "
      "with re-use | own | CHOLMOD | bar |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
  fmt::print("{}", page);
  for (const ReuseScene& scene : scenes) {
    const auto begins = [&](const std::string& word) { return scene.name.starts_with(word); };
    if (!wanted.empty() && std::none_of(wanted.begin(), wanted.end(), begins)) continue;
    const std::string row = measure(scene);
    fmt::print("{}", row);
    std::fflush(stdout);
    page += row;
  }
  if (!file.empty()) std::ofstream(file) << page;
} catch (const std::exception& error) {
  fmt::print(stderr, "reuse: {}\n", error.what());
  return 1;
}
