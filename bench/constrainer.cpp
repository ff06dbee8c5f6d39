// Cost of the calls of a Constrainer beside the kernels inside, in turn in one process:
//   constrainer [threads] [largest number of rods]
// Chains of 100 rods and one chain, points in the order of the chains and shuffled. Prints nanoseconds of processor
// time a rod (medians, of all threads together) of the call, of the kernels alone on arrays in their own order, and the
// ratio.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <time.h>

#include <tanor/constrainer.hpp>

#include "dynamics/forms.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;

struct Chains {
  std::vector<double> masses, r, v, f;
  Rods rods{"rods", {}, {}, {}};
};

/// Crumpled chains of `length` rods, about `num_rods` of them, whose velocities the rods do not allow.
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

/// Processor time of all threads, s: what others do on the machine does not count.
double processor_seconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// ns a rod, medians over rounds in which the tasks take turns.
std::vector<double> time_in_turns(const std::vector<std::function<void()>>& tasks, std::size_t num_rods) {
  constexpr int rounds = 9;
  const std::size_t repeats = std::max<std::size_t>(1, 400'000 / num_rods);
  std::vector<std::vector<double>> times(tasks.size());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t k = 0; k < tasks.size(); ++k) {
      const double begin = processor_seconds();
      for (std::size_t i = 0; i < repeats; ++i) tasks[k]();
      times[k].push_back(1e9 * (processor_seconds() - begin) / static_cast<double>(repeats * num_rods));
    }
  }
  std::vector<double> result;
  for (const auto& each : times) result.push_back(median(each));
  return result;
}

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

  // The kernels inside, on arrays in the inner order.
  System system;
  system.masses = host.masses;
  system.positions = host.r;
  system.constraints = {host.rods};
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
    expect(form.dynamics().solve({0.0, inner_place.data(), inner_v.data()}, {.exact = true, .forces = inner_f.data()},
                                 w.data()));
  };
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
    expect(form.steps().project_step(0.0, h, inner_r.data(), free_v.data()).outcome);
    expect(form.linearization().update(0.0, inner_r.data()));
    expect(form.projector().project_velocities(0.0, inner_r.data(), free_v.data(), nullptr, 1.0).outcome);
  };
  const std::vector<double> times = time_in_turns({solve, solve_inside, step, step_inside}, d);
  std::printf(
      "%8zu rods in chains of %7zu, %8s, %d threads: solve %5.1f / %5.1f = %4.2f   step %5.1f / %5.1f = %4.2f\n", d,
      length, shuffled ? "shuffled" : "natural", threads, times[0], times[1], times[0] / times[1], times[2], times[3],
      times[2] / times[3]);
}

}  // namespace

int main(int argc, char** argv) {
  const int threads = argc > 1 ? std::atoi(argv[1]) : 1;
  const double largest = argc > 2 ? std::atof(argv[2]) : 1e6;
  for (double rods = 1e4; rods <= largest; rods *= 10.0) {
    const auto count = static_cast<std::size_t>(rods);
    for (const bool shuffled : {false, true}) {
      measure(count, 100, shuffled, threads);
      measure(count, count, shuffled, threads);
    }
  }
}
