// Measures the cost of the public calls beside the kernels inside, in turn in one process:
//   constrainer [threads] [largest number of rods] [smallest number of rods]
// The scenes are chains of 100 rods and one chain, with points in the order of the chains and shuffled. The program
// prints a table: nanoseconds of processor time a rod (medians, of all threads together) of each call, of the kernels
// alone on arrays in their own order, and the median ratio of both; then of the moves alone, which are plain loops that
// read each of the host's points that the call reads and write each that it writes, and the median ratio of the call
// and
// kernels + moves. A part of that ratio above 1 is not the memory's.
//   host solve, host step    Constrainer: solve; constrain_positions and constrain_velocities with new arrays
//   Dynamics::solve          accelerations and multipliers
//   Simulation               a step of `rattle` in a long advance, beside the same step on bare arrays

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>
#include <tanor/dynamics.hpp>
#include <tanor/motion.hpp>

#include "dynamics/forms.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;

struct Chains {
  std::vector<double> masses, r, v, f;
  Rods rods{"rods", {}, {}, {}};
};

/// Makes about `num_rods` rods in crumpled chains of `length` rods, whose velocities the rods do not allow.
Chains make_chains(std::size_t num_rods, std::size_t length, bool shuffled) {
  const std::size_t count = num_rods / length, n = count * (length + 1);
  std::vector<Index> place(n);
  std::iota(place.begin(), place.end(), 0);
  std::mt19937 random(7);
  if (shuffled) std::shuffle(place.begin(), place.end(), random);
  std::normal_distribution<double> normal;
  Chains chains{std::vector<double>(n, 1.0), std::vector<double>(3 * n), std::vector<double>(3 * n),
                std::vector<double>(3 * n)};
  for (std::size_t i = 0; i < n; ++i) {
    const bool begins = i % (length + 1) == 0;
    const double d[3]{normal(random), normal(random), normal(random)}, size = std::hypot(d[0], d[1], d[2]);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = 3 * static_cast<std::size_t>(place[i]) + k;
      const double before = begins ? 0.0 : chains.r[3 * static_cast<std::size_t>(place[i - 1]) + k];
      chains.r[at] = before + d[k] / size;
      chains.v[at] = normal(random);
      chains.f[at] = normal(random);
    }
    if (!begins) chains.rods.pairs.push_back({place[i - 1], place[i]});
  }
  return chains;
}

struct Times {
  double call, kernels, moves, ratio, bound_ratio;  // ns a rod, medians
};

/// Times the three functions in turn.
Times time_in_turns(const std::function<void()>& call, const std::function<void()>& kernels,
                    const std::function<void()>& moves, std::size_t num_rods) {
  constexpr int rounds = 15;
  const std::size_t repeats = std::max<std::size_t>(1, 400'000 / num_rods);
  const std::function<void()>* const all[]{&call, &kernels, &moves};
  std::vector<double> times[3], ratios, bound_ratios;
  for (int round = -1; round < rounds; ++round) {
    double now[3];
    for (const int k : {0, 1, 2}) {
      const double begin = processor_seconds();
      for (std::size_t i = 0; i < repeats; ++i) (*all[k])();
      now[k] = 1e9 * (processor_seconds() - begin) / static_cast<double>(repeats * num_rods);
    }
    if (round < 0) continue;  // the first one warms up
    for (const int k : {0, 1, 2}) times[k].push_back(now[k]);
    ratios.push_back(now[0] / now[1]);
    bound_ratios.push_back(now[0] / (now[1] + now[2]));
  }
  return {median(times[0]), median(times[1]), median(times[2]), median(ratios), median(bound_ratios)};
}

/// Brings the accelerations of forces in the inner order.
struct InnerForces final : GivenMotion {
  const Model& model;
  const double* forces;
  double* accelerations;
  mutable std::atomic<double> square{0.0};

  InnerForces(const Model& of, const double* f, double* a) : model(of), forces(f), accelerations(a) {}
  void bring(std::size_t first, std::size_t count) const override {
    double worst = 0.0;
    for (std::size_t i = first; i < first + count; ++i) {
      const Vec3 a = model.inverse_mass[i] * load(forces, i);
      store(accelerations, i, a);
      worst = std::max(worst, dot(a, a));
    }
    double seen = square;
    while (worst > seen && !square.compare_exchange_weak(seen, worst)) {
    }
  }
  double largest() const override { return std::sqrt(square); }
};

void expect(const Outcome& outcome) {
  if (outcome.ok()) return;
  std::puts(outcome.what.c_str());
  std::exit(1);
}

void measure(std::size_t num_rods, std::size_t length, bool shuffled, int threads) {
  const double h = 1e-3;
  Chains host = make_chains(num_rods, length, shuffled);
  const std::size_t d = host.rods.pairs.size();
  const SolverOptions options{.threads = threads};
  Constrainer constrainer(host.masses, {host.rods}, host.r, options);
  std::vector<double> w(host.r.size()), lambda(d), r(host.r.size()), v(host.r.size());
  std::vector<double> other = host.r;  // another place, so that every call factorizes
  for (double& x : other) x = -x;
  const std::vector<double>* places[2]{&host.r, &other};
  int turn = 0;

  // The kernels inside work on arrays in the inner order.
  System system;
  system.masses = host.masses;
  system.positions = host.r;
  system.constraints = {host.rods};
  system.forces = {Gravity{}};
  Forms forms(system, options);
  const Model& model = forms.model;
  MultiplierForm& form = *forms.normal;
  std::vector<double> inner_place(r.size()), inner_v(r.size()), inner_f(r.size()), inner_r(r.size());
  model.numbering.gather_points(host.r, inner_place);
  model.numbering.gather_points(host.v, inner_v);
  model.numbering.gather_points(host.f, inner_f);
  std::vector<double> free_place = inner_place, free_v = inner_v;
  for (std::size_t k = 0; k < r.size(); ++k) free_place[k] += h * inner_v[k];
  const auto copy = [&](const std::vector<double>& from, std::vector<double>* to) {
    model.parallel.for_ranges(from.size(), [&](std::size_t begin, std::size_t end) {
      std::copy(from.begin() + static_cast<std::ptrdiff_t>(begin), from.begin() + static_cast<std::ptrdiff_t>(end),
                to->begin() + static_cast<std::ptrdiff_t>(begin));
    });
  };
  std::vector<double> free_r = host.r;
  for (std::size_t k = 0; k < r.size(); ++k) free_r[k] += h * host.v[k];

  const auto solve = [&] {
    expect(constrainer
               .solve({.positions = *places[turn ^= 1],
                       .velocities = host.v,
                       .forces = host.f,
                       .accelerations = w,
                       .wanted = {.multipliers = lambda},
                       .measures = false})
               .outcome);
  };
  const auto solve_inside = [&] {
    const InnerForces forces(model, inner_f.data(), w.data());
    expect(
        form.dynamics().solve({0.0, inner_place.data(), inner_v.data()}, {.exact = true, .given = &forces}, w.data()));
  };
  std::vector<double> moved[3]{r, r, r};
  const auto move = [&](const std::vector<const std::vector<double>*>& read,
                        const std::vector<std::vector<double>*>& written) {
    model.parallel.for_ranges(model.num_points(), [&](std::size_t begin, std::size_t end) {
      const Index* const user_point = model.numbering.user_point.data();
      for (std::size_t k = 0; k < read.size(); ++k) {
        for (std::size_t i = begin; i < end; ++i) store(moved[k].data(), i, load(read[k]->data(), user_point[i]));
      }
      for (std::size_t k = 0; k < written.size(); ++k) {
        for (std::size_t i = begin; i < end; ++i) store(written[k]->data(), user_point[i], load(moved[k].data(), i));
      }
    });
  };
  const auto moves_of_solve = [&] { move({places[turn ^= 1], &host.v, &host.f}, {&w}); };
  const auto moves_of_step = [&] {
    move({&host.r, &r, &v}, {&r, &v});
    move({&r, &v}, {&v});
  };
  const auto moves_of_dynamics = [&] { move({places[turn ^= 1], &host.v}, {&w}); };
  const auto step = [&] {
    copy(free_r, &r);
    copy(host.v, &v);
    expect(constrainer
               .constrain_positions({.step = h,
                                     .old_positions = host.r,
                                     .positions = r,
                                     .velocities = v,
                                     .wanted = {.multipliers = lambda},
                                     .measures = false})
               .outcome);
    expect(constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v, .measures = false}).outcome);
  };
  const auto step_inside = [&] {
    copy(free_place, &inner_r);
    copy(inner_v, &free_v);
    expect(form.linearization().update(0.0, inner_place.data()));
    expect(form.steps().project_step(0.0, h, inner_r.data(), nullptr, free_v.data(), 0.0).outcome);
    expect(form.linearization().update(0.0, inner_r.data()));
    expect(form.projector().project_velocities(0.0, inner_r.data(), free_v.data(), nullptr, 1.0).outcome);
  };
  Dynamics dynamics(system, options);
  const auto call_dynamics = [&] {
    expect(
        dynamics
            .solve({.positions = *places[turn ^= 1], .velocities = host.v}, {.accelerations = w, .multipliers = lambda})
            .outcome);
  };
  const auto solve_own = [&] {
    expect(form.dynamics().solve({0.0, inner_place.data(), inner_v.data()}, {.exact = true}, w.data()));
  };

  const std::size_t steps = std::max<std::size_t>(20, 200'000 / d);
  Simulation simulation(system, {.method = Method::Rattle, .step = h}, options);
  const auto advance = [&] { expect(simulation.advance_to(simulation.time() + h * static_cast<double>(steps))); };
  std::vector<double> bare_r(r.size()), bare_v(r.size());
  model.numbering.gather_points(simulation.positions(), bare_r);
  model.numbering.gather_points(simulation.velocities(), bare_v);
  expect(form.linearization().update(0.0, bare_r.data()));
  form.steps().forget_steps();
  const Vec3 kick = 0.5 * h * *model.uniform_free();
  const auto advance_bare = [&] {
    for (std::size_t k = 0; k < steps; ++k) {
      model.parallel.for_ranges(model.num_points(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3 middle = load(bare_v.data(), i) + kick;
          store(bare_v.data(), i, middle);
          store(bare_r.data(), i, load(bare_r.data(), i) + h * middle);
        }
      });
      expect(form.steps().project_step(0.0, h, bare_r.data(), nullptr, bare_v.data(), 0.0).outcome);
      expect(form.linearization().update(0.0, bare_r.data()));
      model.parallel.for_ranges(model.num_points(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) store(bare_v.data(), i, load(bare_v.data(), i) + kick);
      });
      expect(form.steps().project_step_velocities(0.0, h, bare_r.data(), bare_v.data()).outcome);
    }
  };

  std::printf("| %zu | %zu | %s | %d", d, length, shuffled ? "shuffled" : "natural", threads);
  const auto print = [](const Times& times) {
    std::printf(" | %.1f / %.1f = %.2f", times.call, times.kernels, times.ratio);
    if (times.moves > 0.5) std::printf("; %.1f: %.2f", times.moves, times.bound_ratio);
    std::fflush(stdout);
  };
  print(time_in_turns(
      advance, advance_bare, [] {}, steps * d));
  print(time_in_turns(solve, solve_inside, moves_of_solve, d));
  print(time_in_turns(step, step_inside, moves_of_step, d));
  print(time_in_turns(call_dynamics, solve_own, moves_of_dynamics, d));
  std::puts(" |");
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  const double largest = argc > 2 ? std::atof(argv[2]) : 1e6;
  std::puts(
      "| rods | a chain | order | threads | Simulation | host solve | host step | Dynamics::solve |\n"
      "|--:|--:|---|--:|--:|--:|--:|--:|");
  const double smallest = argc > 3 ? std::atof(argv[3]) : 1e4;
  for (double rods = smallest; rods <= largest; rods *= 10.0) {
    const auto count = static_cast<std::size_t>(rods);
    for (const bool shuffled : {false, true}) {
      measure(count, 100, shuffled, threads);
      measure(count, count, shuffled, threads);
    }
  }
}
