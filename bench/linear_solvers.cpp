// Measures one evaluation of the accelerations by each linear solver (SolverOptions::linear_solver), beside the Eigen
// baseline and, for paths in natural order, the plainest pass of scalars, in turn in one process:
//   linear_solvers [--threads N] [--json FILE] [NAME …]   scenes whose name begins so; default: all of them
//   linear_solvers --repeat SECONDS NAME                  our solver alone, one thread, for a profiler: prints the
//                                                         evaluations made; --repeat-call: as a host calls it
//   linear_solvers --list                                 the names of all scenes, a line each
//   linear_solvers --series SECONDS RTOL                  likewise a chain of 1000 rods, released level, by power
//                                                         series (problem P1 of bench/rivals): prints the steps
// Prints nanoseconds a rod or bead (medians) of ours by itself, in the inner order, and as a host calls it
// (Dynamics::solve: the user's arrays in the user's order, accelerations and multipliers, three calls after each
// evaluation of the baseline, which takes the caches), of the general solver and of CHOLMOD in its place; the ratios
// baseline/ours, baseline/called, baseline/inexact
// (called without refinement), general solver/ours and called/plain pass on one thread, and the part of the memory's
// bandwidth (for as many bytes as the scene has) or of dgemm's speed that is reached; then the speedup by 2, 4, … N
// threads (best of each, since other work on the machine stops threads that wait for each other).

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>
#include <tanor/motion.hpp>

#include "bench_scenes.hpp"
#include "dynamics/forms.hpp"
#include "eigen_baseline.hpp"
#include "machine.hpp"
#include "path_baseline.hpp"
#include "timing.hpp"
#include "traffic.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;
using nlohmann::ordered_json;

/// Rounds to so many decimals.
double with_decimals(int count, double value) {
  const double unit = std::pow(10.0, count);
  return std::round(value * unit) / unit;
}

/// Rounds to so many significant digits.
double with_digits(int count, double value) {
  return std::stod(fmt::format("{:.{}g}", value, count));
}

EigenBaseline::Triple gravity_of(const System& system) {
  EigenBaseline::Triple gravity{};
  for (const Force& force : system.forces) gravity = std::get<Gravity>(force).acceleration;
  return gravity;
}

/// Returns the masses, infinite at supports.
std::vector<double> masses_of(const System& system) {
  std::vector<double> masses = system.masses;
  for (const Support& support : system.supports) {
    for (const Index point : support.points)
      masses[static_cast<std::size_t>(point)] = std::numeric_limits<double>::infinity();
  }
  return masses;
}

/// Makes the yardstick for the constraints of a system.
EigenBaseline make_baseline(const System& system) {
  const EigenBaseline::Triple gravity = gravity_of(system);
  const Constraint& first = system.constraints.front();
  if (const auto* rods = std::get_if<Rods>(&first)) return {rods->pairs, masses_of(system), gravity};
  const auto guide =
      std::holds_alternative<Spheres>(first) ? EigenBaseline::Guide::Sphere : EigenBaseline::Guide::Circle;
  return {guide, system.masses, gravity};
}

/// A system at a consistent start in the inner order; `evaluate` finds its accelerations.
struct Ours {
  Forms forms;
  std::vector<double> r, v, w;

  Ours(const System& system, const SolverOptions& options) : forms(system, options) {
    for (std::vector<double>* array : {&r, &v, &w}) array->resize(system.positions.size());
    forms.model.numbering.gather_points(forms.model.system.positions, r);
    forms.model.numbering.gather_points(forms.model.system.velocities, v);
    forms.work.prescribe_all(0.0, r.data(), v.data());
    check(forms.start(0.0, r.data(), v.data(), StartMode::Project).outcome);
  }
  void evaluate() { check(forms.normal->accelerations({0.0, r.data(), v.data()}, {}, w.data())); }
  std::vector<double> in_users_order(const std::vector<double>& inner) const {
    std::vector<double> result(inner.size());
    forms.model.numbering.scatter_points(inner, result);
    return result;
  }
  static void check(const Outcome& outcome) {
    if (!outcome.ok()) throw std::runtime_error(outcome.what);
  }
};

/// A system as a host calls it: with its own arrays in its own order, accelerations and multipliers.
struct Called {
  Dynamics dynamics;
  std::vector<double> r, v, w, lambda;

  Called(const System& system, const std::vector<double>& at_r, const std::vector<double>& at_v, bool is_exact = true)
      : dynamics(system, {.threads = 1, .exact = is_exact}),
        r(at_r),
        v(at_v),
        w(at_r.size()),
        lambda(dynamics.num_equations()) {}
  void evaluate() {
    Ours::check(
        dynamics.solve({.time = 0.0, .positions = r, .velocities = v}, {.accelerations = w, .multipliers = lambda})
            .outcome);
  }
};

/// Makes the yardstick for rods in paths; none where they are not, or not in natural order.
std::optional<PathBaseline> make_path_baseline(const System& system) {
  const auto* rods = std::get_if<Rods>(&system.constraints.front());
  if (rods == nullptr || !PathBaseline::serves(rods->pairs)) return {};
  return PathBaseline(rods->pairs, masses_of(system), gravity_of(system));
}

/// Times of one evaluation, s, of many that were taken in turn.
struct Times {
  std::vector<double> baseline, general, cholmod, ours, called, inexact, plain;
  std::vector<std::vector<double>> threads;  // [number of threads in the list]
};

Times take_times(EigenBaseline* baseline, PathBaseline* plain, Ours* general, Ours* cholmod, Ours* ours, Called* called,
                 Called* inexact, const std::vector<std::unique_ptr<Ours>>& together, const std::vector<double>& r,
                 const std::vector<double>& v, double num_members) {
  Times times;
  const int repeats = std::max(1, static_cast<int>(2e5 / num_members));
  const auto evaluate_baseline = [&] { return seconds_of([&] { (void)baseline->evaluate(r.data(), v.data()); }); };
  const auto repeat = [&](const auto& once) {
    once();  // wakes the caches after another one's work
    return seconds_of([&] {
             for (int k = 0; k < repeats; ++k) once();
           }) /
           repeats;
  };
  const auto evaluate = [&](Ours* each) { return repeat([&] { each->evaluate(); }); };
  // As a host calls it, whose own work has taken the caches: one evaluation of the baseline before every three calls.
  const auto call = [&](Called* each, std::vector<double>* to) {
    constexpr int calls = 3;
    times.baseline.push_back(evaluate_baseline());
    to->push_back(seconds_of([&] {
                    for (int k = 0; k < calls; ++k) each->evaluate();
                  }) /
                  calls);
  };
  (void)evaluate_baseline();  // analyses
  const double once = evaluate_baseline();
  const int rounds = once < 0.02 ? 41 : once < 0.5 ? 11 : 3;
  times.threads.resize(together.size());
  for (int round = 0; round < rounds; ++round) {
    call(called, &times.called);
    call(inexact, &times.inexact);
    times.ours.push_back(evaluate(ours));
    times.general.push_back(evaluate(general));
    times.cholmod.push_back(evaluate(cholmod));
    if (plain != nullptr) times.plain.push_back(repeat([&] { (void)plain->evaluate(r.data(), v.data()); }));
    for (std::size_t k = 0; k < together.size(); ++k) times.threads[k].push_back(evaluate(together[k].get()));
  }
  return times;
}

/// Returns the interquartile range of the ratios of rounds over their median. The baseline runs twice a round.
double noise_of_ratio(const std::vector<double>& baseline, const std::vector<double>& ours) {
  std::vector<double> ratios;
  for (std::size_t k = 0; k < ours.size(); ++k) ratios.push_back(baseline[2 * k] / ours[k]);
  std::sort(ratios.begin(), ratios.end());
  const std::size_t n = ratios.size();
  return (ratios[3 * n / 4] - ratios[n / 4]) / ratios[n / 2];
}

/// Expects equal accelerations. The baseline does not refine: a chain of N rods costs it cond S ~ N^2 digits.
void compare(const std::string& name, const std::vector<double>& w, const double* reference, double num_members) {
  double difference = 0.0, largest = 1e-300;
  for (std::size_t i = 0; i < w.size(); ++i) {
    difference = std::max(difference, std::abs(w[i] - reference[i]));
    largest = std::max(largest, std::abs(w[i]));
  }
  const double tolerance = std::max(1e-9, 1e-15 * num_members * num_members);
  if (!(difference <= tolerance * largest))
    throw std::runtime_error(fmt::format("{}: the two solutions differ by {:.1e}", name, difference / largest));
}

/// Returns how many times as fast the threads are, by their number, from the best of each.
ordered_json list_speedups(const Times& times, const std::vector<int>& thread_counts) {
  const auto best = [](const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); };
  ordered_json result = ordered_json::object();
  for (std::size_t k = 0; k < thread_counts.size(); ++k)
    result[std::to_string(thread_counts[k])] = with_decimals(2, best(times.ours) / best(times.threads[k]));
  return result;
}

/// Returns one line of the table, as JSON. `dense` is flops a second of dgemm.
ordered_json measure(const BenchScene& scene, const std::vector<int>& thread_counts, double dense) {
  const System system = scene.make();
  Ours ours(system, {.threads = 1}), general(system, {.linear_solver = LinearSolver::General, .threads = 1}),
      cholmod(system, {.linear_solver = LinearSolver::Cholmod, .threads = 1});
  std::vector<std::unique_ptr<Ours>> together;
  for (const int threads : thread_counts)
    together.push_back(std::make_unique<Ours>(system, SolverOptions{.threads = threads}));
  EigenBaseline baseline = make_baseline(system);
  std::optional<PathBaseline> plain = make_path_baseline(system);
  const Model& model = ours.forms.model;
  const bool is_of_beads = !std::holds_alternative<Rods>(system.constraints.front());
  const auto num_points = static_cast<double>(model.num_points()), num_rows = static_cast<double>(model.num_rows());
  const double num_members = is_of_beads ? num_points : num_rows;

  const std::vector<double> r = ours.in_users_order(ours.r), v = ours.in_users_order(ours.v);
  Called called(system, r, v), inexact(system, r, v, false);
  const Times times = take_times(&baseline, plain ? &*plain : nullptr, &general, &cholmod, &ours, &called, &inexact,
                                 together, r, v, num_members);
  for (const std::vector<double>& w :
       {ours.in_users_order(ours.w), cholmod.in_users_order(cholmod.w), called.w, inexact.w})
    compare(scene.name, w, baseline.evaluate(r.data(), v.data()), num_members);
  if (plain) compare(scene.name, called.w, plain->evaluate(r.data(), v.data()), num_members);

  const double base = median(times.baseline), mine = median(times.ours), theirs = median(times.general);
  const double of_cholmod = median(times.cholmod);
  const double of_plain = plain ? median(times.plain) : NAN;
  const double of_call = median(times.called), of_inexact = median(times.inexact);
  const PlanSummary& plan = ours.forms.plan;
  const LinearSolver solver = plan.linear_solvers.size() == 1 ? plan.linear_solvers.front() : LinearSolver::General;
  const Traffic traffic = count_traffic({solver, num_points, num_rows, static_cast<double>(plan.pattern_nonzeros),
                                         static_cast<double>(plan.factor_nonzeros)});
  const double bandwidth = measure_bandwidth(traffic.working_set, 1);
  const double of_memory = traffic.bytes / mine / bandwidth, of_product = plan.factor_flops / mine / dense;
  const double passes =
      plan.linear_solvers == std::vector{LinearSolver::General}
          ? 0.0
          : measure_passes(solver == LinearSolver::Paths ? Passes::InAndOut : Passes::Once, num_points);
  const ordered_json speedups = list_speedups(times, thread_counts);
  std::string columns;
  for (const ordered_json& speedup : speedups) columns += fmt::format("{:8.2f}", speedup.get<double>());
  const double unit = 1e9 / num_members;
  fmt::print(
      "{:28}{:>16}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:8.1f}{:10.1f}{:>10}{:10.2f}{:10.2f}"
      "{}\n",
      scene.name, plan.linear_solver(), unit * base, unit * theirs, unit * of_cholmod, unit * mine, unit * of_call,
      base / mine, base / of_call, base / of_inexact, scene.bar, theirs / mine,
      plain ? fmt::format("{:.2f}", of_call / of_plain) : "-", of_memory, of_product, columns);
  std::fflush(stdout);
  return {{"scene", scene.name},
          {"linear_solver", plan.linear_solver()},
          {"members", std::llround(num_members)},
          {"eigen_ns", with_decimals(2, unit * base)},
          {"listed_eigen_ns", std::llround(scene.listed)},
          {"general_ns", with_decimals(2, unit * theirs)},
          {"cholmod_ns", with_decimals(2, unit * of_cholmod)},
          {"ours_ns", with_decimals(2, unit * mine)},
          {"called_ns", with_decimals(2, unit * of_call)},
          {"inexact_ns", with_decimals(2, unit * of_inexact)},
          {"plain_ns", plain ? ordered_json(with_decimals(2, unit * of_plain)) : ordered_json()},
          {"ratio", with_decimals(2, base / mine)},
          {"noise", with_decimals(3, noise_of_ratio(times.baseline, times.ours))},
          {"bar", with_decimals(1, scene.bar)},
          {"bytes", with_decimals(1, traffic.bytes / num_members)},
          {"working_set", std::llround(traffic.working_set)},
          {"bandwidth", with_digits(4, bandwidth)},
          {"passes_ns", with_decimals(2, unit * passes)},
          {"flops", with_digits(4, plan.factor_flops / num_members)},
          {"factor_nonzeros", with_digits(4, static_cast<double>(plan.factor_nonzeros) / num_members)},
          {"of_bandwidth", with_decimals(3, of_memory)},
          {"of_dense", with_decimals(3, of_product)},
          {"speedups", speedups}};
}

/// Evaluates a scene for about so many seconds and does nothing else but make it; prints the number and ns a rod.
void repeat(const BenchScene& scene, double seconds, bool as_called) {
  Ours ours(scene.make(), {.threads = 1});
  Called called(scene.make(), ours.in_users_order(ours.r), ours.in_users_order(ours.v));
  const double members = static_cast<double>(std::max(ours.forms.model.num_rows(), ours.forms.model.num_points()));
  std::size_t evaluations = 0;
  double spent = 0.0;
  for (; spent < seconds; ++evaluations) spent += seconds_of([&] { as_called ? called.evaluate() : ours.evaluate(); });
  fmt::print("{} {:.3f}\n", evaluations, 1e9 * spent / (static_cast<double>(evaluations) * members));
}

/// Runs problem P1 of bench/rivals again and again for about so many seconds; prints the steps and ns a rod and step.
void repeat_series(double seconds, double rtol) {
  constexpr Index num_rods = 1000;
  System chain;
  Rods rods{.length = 0.1};
  for (Index i = 0; i <= num_rods; ++i) {
    chain.positions.insert(chain.positions.end(), {0.1 * i, 0.0, 0.0});
    if (i > 0) rods.pairs.push_back({i - 1, i});
  }
  chain.masses.assign(num_rods + 1, 0.1);
  chain.supports = {{.points = {0}}};
  chain.constraints = {rods};
  chain.forces = {Gravity{.acceleration = {0.0, 0.0, -9.81}}};
  Simulation simulation(chain, {.method = Method::Taylor, .rtol = rtol, .atol = 0.01 * rtol}, {.threads = 1});
  const std::vector<std::byte> start = simulation.save();
  std::size_t steps = 0;
  double spent = 0.0;
  while (spent < seconds) {
    simulation.restore(start);
    Outcome outcome;
    spent += seconds_of([&] { outcome = simulation.advance_to(1.0); });
    if (!outcome.ok()) throw std::runtime_error(outcome.what);
    steps += simulation.report().steps;
  }
  fmt::print("{} {:.3f}\n", steps, 1e9 * spent / (static_cast<double>(steps) * num_rods));
}

/// Describes the machine's speed: dgemm, and the triad over arrays of the sizes of its caches and far beyond them.
ordered_json describe_machine(double dense, int most_threads) {
  constexpr double far_beyond = 1e9;
  ordered_json levels = ordered_json::array(), shared = ordered_json::array();
  for (const double size : {2.4e4, 4e5, 1e7, far_beyond})
    levels.push_back(ordered_json::array({size, with_digits(4, measure_bandwidth(size, 1))}));
  for (int threads = 1; threads <= most_threads; threads *= 2)
    shared.push_back(ordered_json::array({threads, with_digits(4, measure_bandwidth(far_beyond, threads))}));
  return {{"cores", std::thread::hardware_concurrency()},
          {"dense_flops", with_digits(4, dense)},
          {"bandwidth_by_bytes", levels},
          {"bandwidth_by_threads", shared}};
}

/// Writes the machine and each row on a line of its own.
void write_json(const std::string& file, const ordered_json& machine, const std::vector<ordered_json>& rows) {
  std::vector<std::string> lines;
  for (const ordered_json& row : rows) lines.push_back(row.dump());
  std::ofstream(file) << fmt::format("{{\"machine\": {},\n\"rows\": [\n{}\n]}}\n", machine.dump(),
                                     fmt::join(lines, ",\n"));
}

}  // namespace

int main(int argc, char** argv) try {
  int most_threads = 1;
  double seconds = 0.0, rtol = 0.0;
  bool as_called = false;
  std::string file;
  std::vector<std::string> wanted;
  std::vector<ordered_json> rows;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--list") {
      for (const BenchScene& scene : bench_scenes()) fmt::print("{}\n", scene.name);
      return 0;
    }
    if (word == "--threads" && k + 1 < argc) {
      most_threads = std::stoi(argv[++k]);
    } else if (word == "--json" && k + 1 < argc) {
      file = argv[++k];
    } else if ((word == "--repeat" || word == "--repeat-call") && k + 1 < argc) {
      as_called = word == "--repeat-call";
      seconds = std::stod(argv[++k]);
    } else if (word == "--series" && k + 2 < argc) {
      seconds = std::stod(argv[++k]);
      rtol = std::stod(argv[++k]);
    } else {
      wanted.push_back(word);
    }
  }
  const auto is_wanted = [&](const BenchScene& scene) {
    const auto begins = [&](const std::string& word) { return scene.name.starts_with(word); };
    return wanted.empty() || std::any_of(wanted.begin(), wanted.end(), begins);
  };
  if (rtol > 0.0) {
    repeat_series(seconds, rtol);
    return 0;
  }
  if (seconds > 0.0) {
    const auto scene = std::find_if(bench_scenes().begin(), bench_scenes().end(), is_wanted);
    if (scene == bench_scenes().end()) throw std::runtime_error("no such scene");
    repeat(*scene, seconds, as_called);
    return 0;
  }
  std::vector<int> thread_counts;
  std::string columns;
  for (int threads = 2; threads <= most_threads; threads *= 2) {
    thread_counts.push_back(threads);
    columns += fmt::format("{:>7}x", threads);
  }
  const double dense = measure_dense_product();
  fmt::print("{:28}{:>16}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>10}{:>8}{:>10}{:>10}{:>10}{:>10}{}\n",
             "ns a rod or bead", "solver", "Eigen", "general", "CHOLMOD", "ours", "called", "ratio", "/called",
             "/inexact", "bar", "/general", "/plain", "/memory", "/dgemm", columns);
  for (const BenchScene& scene : bench_scenes()) {
    if (is_wanted(scene)) rows.push_back(measure(scene, thread_counts, dense));
  }
  if (!file.empty()) write_json(file, describe_machine(dense, most_threads), rows);
} catch (const std::exception& error) {
  fmt::print(stderr, "linear_solvers: {}\n", error.what());
  return 1;
}
