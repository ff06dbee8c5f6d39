// Measures the cost of the public calls beside the kernels inside, in turn in one process:
//   constrainer [threads] [largest number of rods] [smallest number of rods]
// The scenes are chains of 100 rods and one chain, with points in the order of the chains and shuffled. The program
// prints a table: nanoseconds a rod (medians) of each call, of the kernels alone on arrays in their own order, and the
// median ratio of both; then of the moves alone, which are plain loops that read each of the host's points that the
// call reads and write each that it writes, and the median ratio of the call and kernels + moves. A part of that ratio
// above 1 is not the memory's. One thread is measured by its processor time, several by the clock on the wall, since
// threads that wait for work spend processor time, too; the machine must then have nothing else to do.
//   host solve, host step    Constrainer: solve; constrain_positions and constrain_velocities with new arrays
//   Dynamics::solve          accelerations and multipliers
//   Simulation               a step of `rattle` in a long advance, beside the same step on bare arrays

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <tanor/constrainer.hpp>
#include <tanor/dynamics.hpp>
#include <tanor/motion.hpp>

#include "dynamics/forms.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

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

/// Times functions in turn.
struct Stopwatches {
  int threads;

  double now() const {
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now().time_since_epoch();
    return threads == 1 ? processor_seconds() : wall.count();
  }
  Times time_in_turns(const std::function<void()>& call, const std::function<void()>& kernels,
                      const std::function<void()>& moves, std::size_t num_rods) const;
};

Times Stopwatches::time_in_turns(const std::function<void()>& call, const std::function<void()>& kernels,
                                 const std::function<void()>& moves, std::size_t num_rods) const {
  constexpr int rounds = 15;
  const std::size_t repeats = std::max<std::size_t>(1, 400'000 / num_rods);
  const std::function<void()>* const all[]{&call, &kernels, &moves};
  std::vector<double> times[3], ratios, bound_ratios;
  for (int round = -1; round < rounds; ++round) {
    double spent[3];
    for (const int k : {0, 1, 2}) {
      const double begin = now();
      for (std::size_t i = 0; i < repeats; ++i) (*all[k])();
      spent[k] = 1e9 * (now() - begin) / static_cast<double>(repeats * num_rods);
    }
    if (round < 0) continue;  // the first one warms up
    for (const int k : {0, 1, 2}) times[k].push_back(spent[k]);
    ratios.push_back(spent[0] / spent[1]);
    bound_ratios.push_back(spent[0] / (spent[1] + spent[2]));
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

constexpr double h = 1e-3;  // s

/// Copies arrays by the threads that compute.
void copy(const Parallel& parallel, const std::vector<double>& from, std::vector<double>* to) {
  parallel.for_ranges(from.size(), [&](std::size_t begin, std::size_t end) {
    std::copy(from.begin() + static_cast<std::ptrdiff_t>(begin), from.begin() + static_cast<std::ptrdiff_t>(end),
              to->begin() + static_cast<std::ptrdiff_t>(begin));
  });
}

System make_system(const Chains& chains) {
  System system;
  system.masses = chains.masses;
  system.positions = chains.r;
  system.constraints = {chains.rods};
  system.forces = {Gravity{}};
  return system;
}

/// The arrays of a host, in its order: its state, and what the calls write.
struct Host {
  Chains chains;
  std::vector<double> other, free_r;  ///< another place, and the places after a step without rods
  std::vector<double> w, lambda, r, v;
  int turn = 0;

  explicit Host(Chains given)
      : chains(std::move(given)),
        other(chains.r),
        free_r(chains.r),
        w(chains.r.size()),
        lambda(chains.rods.pairs.size()),
        r(chains.r.size()),
        v(chains.r.size()) {
    for (double& x : other) x = -x;
    for (std::size_t k = 0; k < r.size(); ++k) free_r[k] += h * chains.v[k];
  }
  /// Returns one of two places in turn, so that every call factorizes.
  const std::vector<double>& next_place() { return (turn ^= 1) == 0 ? chains.r : other; }
};

/// The kernels inside, which work on arrays in the inner order.
class Kernels {
 public:
  Kernels(const System& system, const SolverOptions& options, const Chains& host)
      : forms_(system, options),
        place_(host.r.size()),
        v_(host.r.size()),
        f_(host.r.size()),
        r_(host.r.size()),
        w_(host.r.size()) {
    model().numbering.gather_points(host.r, place_);
    model().numbering.gather_points(host.v, v_);
    model().numbering.gather_points(host.f, f_);
    free_place_ = place_;
    free_v_ = v_;
    for (std::size_t k = 0; k < place_.size(); ++k) free_place_[k] += h * v_[k];
  }

  const Model& model() const { return forms_.model; }
  MultiplierForm& form() { return *forms_.normal; }

  /// Solves for the accelerations under the host's forces.
  void solve() {
    const InnerForces forces(model(), f_.data(), w_.data());
    expect(form().dynamics().solve({0.0, place_.data(), v_.data()}, {.exact = true, .given = &forces}, w_.data()));
  }
  /// Solves for the accelerations under the system's forces.
  void solve_with_own_forces() {
    expect(form().dynamics().solve({0.0, place_.data(), v_.data()}, {.exact = true}, w_.data()));
  }
  /// Brings the positions and the velocities after a step back to the rods.
  void step() {
    copy(model().parallel, free_place_, &r_);
    copy(model().parallel, v_, &free_v_);
    expect(form().linearization().update(0.0, place_.data()));
    expect(form().steps().project_step(0.0, h, r_.data(), nullptr, free_v_.data(), 0.0).outcome);
    expect(form().linearization().update(0.0, r_.data()));
    expect(form().projector().project_velocities(0.0, r_.data(), free_v_.data(), nullptr, 1.0).outcome);
  }

 private:
  Forms forms_;
  std::vector<double> place_, v_, f_, free_place_, free_v_, r_, w_;
};

/// The moves alone: plain loops over the numbers that a call reads and writes in the host's arrays.
class Moves {
 public:
  Moves(const Model& model, std::size_t size)
      : model_(model), moved_{std::vector<double>(size), std::vector<double>(size), std::vector<double>(size)} {}

  void move(const std::vector<const std::vector<double>*>& read, const std::vector<std::vector<double>*>& written) {
    model_.parallel.for_ranges(model_.num_points(), [&](std::size_t begin, std::size_t end) {
      const Index* const user_point = model_.numbering.user_point.data();
      for (std::size_t k = 0; k < read.size(); ++k) {
        for (std::size_t i = begin; i < end; ++i) store(moved_[k].data(), i, load(read[k]->data(), user_point[i]));
      }
      for (std::size_t k = 0; k < written.size(); ++k) {
        for (std::size_t i = begin; i < end; ++i) store(written[k]->data(), user_point[i], load(moved_[k].data(), i));
      }
    });
  }

 private:
  const Model& model_;
  std::vector<double> moved_[3];
};

/// Calls Constrainer::solve as a host does.
void solve(Constrainer* constrainer, Host* host) {
  expect(constrainer
             ->solve({.positions = host->next_place(),
                      .velocities = host->chains.v,
                      .forces = host->chains.f,
                      .accelerations = host->w,
                      .wanted = {.multipliers = host->lambda},
                      .measures = false})
             .outcome);
}

/// Constrains the positions and the velocities after a step as a host does.
void step(Constrainer* constrainer, const Parallel& parallel, Host* host) {
  copy(parallel, host->free_r, &host->r);
  copy(parallel, host->chains.v, &host->v);
  expect(constrainer
             ->constrain_positions({.step = h,
                                    .old_positions = host->chains.r,
                                    .positions = host->r,
                                    .velocities = host->v,
                                    .wanted = {.multipliers = host->lambda},
                                    .measures = false})
             .outcome);
  expect(constrainer->constrain_velocities({.step = h, .positions = host->r, .velocities = host->v, .measures = false})
             .outcome);
}

/// Steps of `rattle` on bare arrays in the inner order.
class BareSteps {
 public:
  BareSteps(Kernels* kernels, const Simulation& start)
      : model_(kernels->model()),
        form_(kernels->form()),
        kick_(0.5 * h * *model_.uniform_free()),
        r_(start.positions().size()),
        v_(start.positions().size()) {
    model_.numbering.gather_points(start.positions(), r_);
    model_.numbering.gather_points(start.velocities(), v_);
    expect(form_.linearization().update(0.0, r_.data()));
    form_.steps().forget_steps();
  }

  void advance(std::size_t steps) {
    for (std::size_t k = 0; k < steps; ++k) {
      model_.parallel.for_ranges(model_.num_points(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          const Vec3 middle = load(v_.data(), i) + kick_;
          store(v_.data(), i, middle);
          store(r_.data(), i, load(r_.data(), i) + h * middle);
        }
      });
      expect(form_.steps().project_step(0.0, h, r_.data(), nullptr, v_.data(), 0.0).outcome);
      expect(form_.linearization().update(0.0, r_.data()));
      model_.parallel.for_ranges(model_.num_points(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) store(v_.data(), i, load(v_.data(), i) + kick_);
      });
      expect(form_.steps().project_step_velocities(0.0, h, r_.data(), v_.data()).outcome);
    }
  }

 private:
  const Model& model_;
  MultiplierForm& form_;
  Vec3 kick_;
  std::vector<double> r_, v_;
};

void print(const Times& times) {
  std::printf(" | %.1f / %.1f = %.2f", times.call, times.kernels, times.ratio);
  if (times.moves > 0.5) std::printf("; %.1f: %.2f", times.moves, times.bound_ratio);
  std::fflush(stdout);
}

void measure(std::size_t num_rods, std::size_t length, bool shuffled, int threads) {
  const SolverOptions options{.threads = threads};
  Host host(make_chains(num_rods, length, shuffled));
  const Chains& chains = host.chains;
  const std::size_t d = chains.rods.pairs.size(), steps = std::max<std::size_t>(100, 400'000 / d);
  const System system = make_system(chains);
  Constrainer constrainer(chains.masses, {chains.rods}, chains.r, options);
  Kernels kernels(system, options, chains);
  Moves moves(kernels.model(), chains.r.size());
  Dynamics dynamics(system, options);
  Simulation simulation(system, {.method = Method::Rattle, .step = h}, options);
  BareSteps bare(&kernels, simulation);

  std::printf("| %zu | %zu | %s | %d", d, length, shuffled ? "shuffled" : "natural", threads);
  const Stopwatches watches{threads};
  const auto advance = [&] { expect(simulation.advance_to(simulation.time() + h * static_cast<double>(steps))); };
  print(watches.time_in_turns(
      advance, [&] { bare.advance(steps); }, [] {}, steps * d));
  print(watches.time_in_turns([&] { solve(&constrainer, &host); }, [&] { kernels.solve(); },
                              [&] {
                                moves.move({&host.next_place(), &chains.v, &chains.f}, {&host.w});
                              },
                              d));
  const auto move_step = [&] {
    moves.move({&chains.r, &host.r, &host.v}, {&host.r, &host.v});
    moves.move({&host.r, &host.v}, {&host.v});
  };
  print(watches.time_in_turns([&] { step(&constrainer, kernels.model().parallel, &host); }, [&] { kernels.step(); },
                              move_step, d));
  const auto call_dynamics = [&] {
    expect(dynamics
               .solve({.positions = host.next_place(), .velocities = chains.v},
                      {.accelerations = host.w, .multipliers = host.lambda})
               .outcome);
  };
  print(watches.time_in_turns(
      call_dynamics, [&] { kernels.solve_with_own_forces(); },
      [&] {
        moves.move({&host.next_place(), &chains.v}, {&host.w});
      },
      d));
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
