// Measures the tangent form with Google Benchmark, by scene and threads: evaluate A and psi, assemble H, factorize,
// solve,
// and the accelerations as a whole. Then it compares, in turn and with the ratio of their medians, beads on circles
// with
// a plain Eigen program, and rigid bodies held by 3n - 6 rods in both forms.
//   tangent [--benchmark_filter=NAME]      all of it
//   tangent --markdown FILE                what is taken in turn alone
// `items_per_second` counts points.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "dynamics/forms.hpp"
#include "eigen_baseline.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

/// Makes beads on circles side by side, each joined to the next one by a spring.
System make_beads(int count) {
  System system;
  Springs springs{"", {}, 10.0, 0.0, 0.1};
  for (Index i = 0; i < count; ++i) {
    const double x = 0.1 * i, angle = std::sin(7.0 * x);
    system.positions.insert(system.positions.end(), {x, 0.5 * std::cos(angle), 0.5 * std::sin(angle)});
    system.masses.push_back(0.1);
    system.coordinates.push_back(CircleCoordinates{"", {i}, Vector3{x, 0, 0}, Vector3{1, 0, 0}, 0.5});
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  system.forces = {Gravity{"", {0, 0, -9.81}}, springs};
  return system;
}

/// Makes spinning bodies of `size` points within a ball.
System make_bodies(int count, int size) {
  System system;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> component(-0.5, 0.5);
  for (int body = 0; body < count; ++body) {
    RigidBody group;
    for (int p = 0; p < size; ++p) {
      const std::array<double, 3> y = {component(random), component(random), component(random)};
      group.points.push_back(static_cast<Index>(system.masses.size()));
      system.positions.insert(system.positions.end(), {2.0 * body + y[0], y[1], y[2]});
      system.velocities.insert(system.velocities.end(), {-3.0 * y[1], 3.0 * y[0] - y[2], y[1]});
      system.masses.push_back(1.0);
    }
    system.coordinates.push_back(std::move(group));
  }
  system.forces = {Gravity{"", {0, 0, -9.81}}};
  return system;
}

/// Makes one body and rods that hold it: each point to three others before it, the last three, or the nearest ones that
/// are seen in different directions (rods in one plane would not hold it).
System make_framework(int size, bool nearest) {
  System system = make_bodies(1, size);
  const auto distance = [&](Index i, Index j) {
    return norm(load(system.positions.data(), i) - load(system.positions.data(), j));
  };
  Rods rods;
  for (Index i = 1; i < size; ++i) {
    std::vector<Index> others(static_cast<std::size_t>(i));
    for (Index j = 0; j < i; ++j) others[static_cast<std::size_t>(j)] = i - 1 - j;
    if (nearest) std::ranges::sort(others, {}, [&](Index j) { return distance(i, j); });
    std::vector<Vec3> taken;
    for (const Index j : others) {
      const Vec3 arm = load(system.positions.data(), j) - load(system.positions.data(), i);
      Vec3 rest = (1.0 / norm(arm)) * arm;
      for (const Vec3& other : taken) rest = rest - dot(other, rest) * other;
      if (taken.size() == 3 || (nearest && norm(rest) < 0.5 && i > 3)) continue;
      taken.push_back((1.0 / norm(rest)) * rest);
      rods.pairs.push_back({j, i});
    }
  }
  system.constraints = {rods};
  return system;
}

struct Instant {
  Forms forms;
  std::vector<double> r, v, q, q_dot, q_ddot, psi, blocks, rows;
  GramSolver solver;

  Instant(System system, int threads, LinearSolver of_H = LinearSolver::General)
      : forms(std::move(system), {.form = Form::Tangent, .threads = threads}),
        r(3 * forms.model.num_points()),
        v(r),
        q(forms.tangent->size()),
        q_dot(q),
        q_ddot(q),
        psi(r),
        blocks(3 * forms.work.coordinates.num_blocks()),
        rows(q.size(), 1.0),
        solver(forms.work.coordinates.list_products(forms.model.mass),
               {forms.work.coordinates.island_start(), q.size()}, Ordering::Auto, of_H) {
    const System& given = forms.model.system;
    std::vector<double> velocities = given.velocities;
    velocities.resize(r.size());
    forms.model.numbering.gather_points(given.positions, r);
    forms.model.numbering.gather_points(velocities, v);
    (void)forms.tangent->set_state(0.0, r.data(), v.data(), q.data(), q_dot.data());
    evaluate();
    assemble();
    (void)factorize();
  }

  const Parallel& parallel() const { return forms.model.parallel; }
  void evaluate() {
    forms.work.coordinates.evaluate(parallel(), q.data(), q_dot.data(), r.data(), v.data(), psi.data(), blocks.data());
  }
  void assemble() { solver.assemble(parallel(), blocks.data()); }
  GramSolver::Quality factorize() { return solver.factorize(parallel()); }
  void solve() { solver.solve_negative(parallel(), rows.data(), q_ddot.data()); }
  void all_phases() {
    evaluate();
    assemble();
    (void)factorize();
    solve();
  }
  void accelerations() { (void)forms.tangent->accelerations({0.0, q.data(), q_dot.data()}, {}, q_ddot.data()); }
};

template <class Phase>
void run(benchmark::State& state, const Phase& phase) {
  const bool beads = state.range(1) == 1;
  const auto members = static_cast<int>(state.range(0)), points = static_cast<int>(state.range(1));
  Instant instant(beads ? make_beads(members) : make_bodies(members, points), static_cast<int>(state.range(2)));
  for (auto _ : state) phase(instant);
  state.SetItemsProcessed(state.iterations() * members * points);
}

void evaluate(benchmark::State& state) {
  run(state, [](Instant& i) { i.evaluate(); });
}
void assemble(benchmark::State& state) {
  run(state, [](Instant& i) { i.assemble(); });
}
void factorize(benchmark::State& state) {
  run(state, [](Instant& i) { benchmark::DoNotOptimize(i.factorize()); });
}
void solve(benchmark::State& state) {
  run(state, [](Instant& i) { i.solve(); });
}
void accelerations(benchmark::State& state) {
  run(state, [](Instant& i) { i.accelerations(); });
}

/// Adds 1e5 beads on circles and 1e4 bodies of 20 points.
void scenes(benchmark::internal::Benchmark* benchmark) {
  benchmark->ArgNames({"members", "points", "threads"})->UseRealTime()->Unit(benchmark::kMillisecond);
  for (const int threads : {1, 2}) benchmark->Args({100'000, 1, threads})->Args({10'000, 20, threads});
}

BENCHMARK(evaluate)->Apply(scenes);
BENCHMARK(assemble)->Apply(scenes);
BENCHMARK(factorize)->Apply(scenes);
BENCHMARK(solve)->Apply(scenes);
BENCHMARK(accelerations)->Apply(scenes);

double largest_difference(const double* w, const double* reference, std::size_t size) {
  double difference = 0.0, largest = 0.0;
  for (std::size_t c = 0; c < size; ++c) {
    difference = std::max(difference, std::abs(w[c] - reference[c]));
    largest = std::max(largest, std::abs(reference[c]));
  }
  return difference / largest;
}

/// Compares accelerations of beads on circles at (q, q_dot) by tanor and by the Eigen program, beside the phases with
/// CHOLMOD's factor of H. Returns a row of the table.
std::string compare_with_eigen(int count) {
  System system = make_beads(count);
  system.forces = {Gravity{"", {0, 0, -9.81}}};
  for (std::size_t i = 0; i < system.masses.size(); ++i) {
    const double* r = system.positions.data() + 3 * i;
    system.velocities.insert(system.velocities.end(), {0.0, -3.0 * r[2], 3.0 * r[1]});
  }
  Instant ours(system, 1), cholmod(system, 1, LinearSolver::Cholmod);
  // The circles are r - c = R (cos q e1 + sin q e2), from the first bead.
  const double angle = ours.q[0], radius = 0.5;
  const Vec3 outwards = 1.0 / radius * Vec3{0.0, ours.r[1], ours.r[2]}, along = cross({1, 0, 0}, outwards);
  const Vec3 e1 = std::cos(angle) * outwards - std::sin(angle) * along,
             e2 = std::sin(angle) * outwards + std::cos(angle) * along;
  EigenTangentBaseline baseline({e1.x, e1.y, e1.z}, {e2.x, e2.y, e2.z}, radius, system.masses, {0, 0, -9.81});
  const double* w = baseline.evaluate(ours.q.data(), ours.q_dot.data());
  ours.accelerations();
  std::vector<double> eigen, by_cholmod, mine;
  for (int round = 0; round < 11; ++round) {
    eigen.push_back(seconds_of([&] { w = baseline.evaluate(ours.q.data(), ours.q_dot.data()); }));
    cholmod.all_phases();  // wakes the caches after the other one's work
    by_cholmod.push_back(seconds_of([&] { cholmod.all_phases(); }));
    ours.accelerations();
    mine.push_back(seconds_of([&] { ours.accelerations(); }));
  }
  Reactions found;
  (void)ours.forms.tangent->accelerations({0.0, ours.q.data(), ours.q_dot.data()}, {},
                                          {ours.q_ddot.data(), nullptr, nullptr, &found});
  const double difference = largest_difference(found.w.data(), w, system.positions.size());
  if (!(difference < 1e-12)) throw std::runtime_error("the two solutions differ");
  const double unit = 1e9 / count;
  return fmt::format("| {} beads on circles | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {} |\n", count, unit * median(eigen),
                     unit * median(by_cholmod), unit * median(mine), median(eigen) / median(mine),
                     count == 100'000 ? "8" : "");
}

double seconds_of_solve(Dynamics* dynamics, const System& system, std::vector<double>* w) {
  SolveReport report;
  const double seconds = seconds_of([&] {
    report = dynamics->solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                             {.accelerations = *w});
  });
  if (!report.outcome.ok()) throw std::runtime_error(report.outcome.what);
  return seconds;
}

/// Compares both forms in turn; the tangent one has no constraints, since nobody asks for multipliers. Returns a row of
/// the
/// table.
std::string compare_forms(const char* name, int size, bool nearest) {
  const System with_rods = make_framework(size, nearest);
  System alone = with_rods, rods_alone = with_rods;
  alone.constraints.clear();
  rods_alone.coordinates.clear();
  Dynamics tangent(alone, {.threads = 1}), normal(rods_alone, {.threads = 1});
  Dynamics cholmod(rods_alone, {.linear_solver = LinearSolver::Cholmod, .threads = 1});
  const bool is_chosen = Dynamics(with_rods, {.threads = 1}).plan().form == Form::Tangent;
  std::vector<double> w(with_rods.positions.size()), w_normal(w), of_tangent, of_cholmod, of_normal;
  for (int round = 0; round < 15; ++round) {
    of_tangent.push_back(seconds_of_solve(&tangent, with_rods, &w));
    of_cholmod.push_back(seconds_of_solve(&cholmod, with_rods, &w_normal));
    of_normal.push_back(seconds_of_solve(&normal, with_rods, &w_normal));
  }
  return fmt::format("| {}, rods to {} | {:.3g} | {:.3g} | {:.3g} | {:.1f} | {} | {:.1e} |\n", size, name,
                     1e3 * median(of_tangent), 1e3 * median(of_normal), 1e3 * median(of_cholmod),
                     median(of_normal) / median(of_tangent), is_chosen ? "yes" : "no",
                     largest_difference(w.data(), w_normal.data(), w.size()));
}

}  // namespace

int main(int argc, char** argv) try {
  const bool writes = argc == 3 && std::string(argv[1]) == "--markdown";
  if (!writes) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
    benchmark::RunSpecifiedBenchmarks();
  }
  std::string page =
      "# The tangent form\n\n"
      "One evaluation of all accelerations, one thread, medians of runs in turn; ns a bead. Eigen: A by values, A'MA "
      "by "
      "sparse\nproducts, SimplicialLDLT analysed once; CHOLMOD: A and psi as ours, then\nA'MA assembled, factorized "
      "and solved by CHOLMOD. Repeat "
      "with `scripts/bench`.\n\n"
      "| scene | Eigen | CHOLMOD | ours | Eigen/ours | wanted |\n|---|--:|--:|--:|--:|--:|\n";
  for (const int count : {1000, 100'000, 1'000'000}) page += compare_with_eigen(count);
  page +=
      "\nA rigid body of so many points by its six coordinates, and by rods between them, ms:\n\n"
      "| points | tangent | normal | normal by CHOLMOD | normal/tangent | chosen by itself | w differ by "
      "|\n|---|--:|--:|--:|--:|--:|--:|\n";
  page += compare_forms("the last three", 1000, false);
  page += compare_forms("the nearest three", 1000, true);
  fmt::print("{}", page);
  if (writes) std::ofstream(argv[2]) << page;
} catch (const std::exception& error) {
  fmt::print(stderr, "tangent: {}\n", error.what());
  return 1;
}
