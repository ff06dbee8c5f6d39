// Measures a step of RATTLE of a million links, one thread, with reactions:
//   links [STEPS]
// The size is that of published direct multibody solvers: 1,076,748 rods of 0.1 m with points of 0.1 kg. Every island
// hangs from its first point and is released: 500 chains of 1,000 rods, 200 binary trees of depth 10, 1,000 rings of
// 100,
// nets of 50 x 50 points, and one chain for the rest. Steps take 1 ms, with constraints to rounding. The program prints
// ms a step (median and best, wall and processor time), ns a rod, and the violation of the constraints in the end.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

#include <tanor/constrainer.hpp>
#include <tanor/tanor.hpp>

#include "timing.hpp"

namespace {

using namespace tanor;

constexpr std::size_t num_links = 1'076'748;
constexpr double spacing = 0.1, mass = 0.1, step = 1e-3;

/// Appends points and rods. Islands lie beside one another along z, where their position does not matter.
class Hangings {
 public:
  System finish() {
    system_.constraints = {rods_};
    system_.supports = {supports_};
    system_.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    system_.velocities.assign(system_.positions.size(), 0.0);
    return std::move(system_);
  }
  std::size_t num_rods() const { return rods_.pairs.size(); }

  void add_chain(int count) {
    Index last = begin_island();
    for (int k = 1; k <= count; ++k) last = add_joined(last, {spacing * k, 0.0, 0.0});
  }
  void add_ring(int count) {
    const double radius = 0.5 * spacing / std::sin(std::numbers::pi / count);
    const auto place = [&](int k) {
      const double angle = 2.0 * std::numbers::pi * k / count;
      return Vector3{radius * (std::cos(angle) - 1.0), radius * std::sin(angle), 0.0};
    };
    const Index first = begin_island();
    Index last = first;
    for (int k = 1; k < count; ++k) last = add_joined(last, place(k));
    rods_.pairs.push_back({last, first});
  }
  /// Appends rods in random directions.
  void add_tree(int depth) {
    std::normal_distribution<double> normal;
    Index first = begin_island();
    std::vector<Vector3> places{{0.0, 0.0, 0.0}};
    for (int level = 0; level < depth; ++level) {
      std::vector<Vector3> next;
      for (std::size_t k = 0; k < places.size(); ++k) {
        for (int branch = 0; branch < 2; ++branch) {
          Vector3 along{normal(generator_), normal(generator_), normal(generator_)};
          const double length = std::hypot(along[0], along[1], along[2]);
          for (std::size_t c = 0; c < 3; ++c) along[c] = places[k][c] + spacing / length * along[c];
          (void)add_joined(first + static_cast<Index>(k), along);
          next.push_back(along);
        }
      }
      first += static_cast<Index>(places.size());
      places = std::move(next);
    }
  }
  void add_net(int size) {
    const Index first = begin_island();
    for (int k = 1; k < size * size; ++k) add_point({spacing * (k % size), spacing * (k / size), 0.0});
    for (int k = 0; k < size * size; ++k) {
      if (k % size + 1 < size) rods_.pairs.push_back({first + k, first + k + 1});
      if (k / size + 1 < size) rods_.pairs.push_back({first + k, first + k + size});
    }
  }

 private:
  Index begin_island() {
    supports_.points.push_back(add_point({0.0, 0.0, 0.0}));
    return supports_.points.back();
  }
  Index add_point(const Vector3& place) {
    system_.positions.insert(system_.positions.end(), place.begin(), place.end());
    system_.masses.push_back(mass);
    return static_cast<Index>(system_.masses.size()) - 1;
  }
  Index add_joined(Index to, const Vector3& place) {
    const Index point = add_point(place);
    rods_.pairs.push_back({to, point});
    return point;
  }

  System system_;
  Rods rods_{"links", {}, {}, {}};
  Support supports_;
  std::mt19937 generator_{1};
};

System make_links() {
  Hangings all;
  for (int k = 0; k < 500; ++k) all.add_chain(1000);
  for (int k = 0; k < 200; ++k) all.add_tree(10);
  for (int k = 0; k < 1000; ++k) all.add_ring(100);
  constexpr int side = 50;
  while (num_links - all.num_rods() > 2 * side * (side - 1)) all.add_net(side);
  all.add_chain(static_cast<int>(num_links - all.num_rods()));
  return all.finish();
}

/// Measures steps in tens; the time between them does not count.
template <class Advance>
void measure(const char* name, int steps, const Advance& advance_ten) {
  constexpr int at_once = 10;
  std::vector<double> wall, processor;
  for (int k = 0; k < steps; k += at_once) {
    const double before = processor_seconds();
    wall.push_back(seconds_of(advance_ten) / at_once);
    processor.push_back((processor_seconds() - before) / at_once);
  }
  const auto best = [](const std::vector<double>& times) { return *std::min_element(times.begin(), times.end()); };
  std::printf("%-12s %.1f ms a step (best %.1f), %.1f ms of the processor (best %.1f), %.0f ns a rod; ", name,
              1e3 * median(wall), 1e3 * best(wall), 1e3 * median(processor), 1e3 * best(processor),
              1e9 * median(processor) / num_links);
}

void check(const Outcome& outcome) {
  if (!outcome.ok()) throw std::runtime_error(outcome.what);
}

void simulate(const System& system, int steps) {
  Simulation motion(system, {.method = Method::Rattle, .step = step}, {.threads = 1});
  int reached = 0;
  const auto advance = [&](int count) { check(motion.advance_to(step * (reached += count))); };
  advance(1);
  measure("Simulation", steps, [&] { advance(10); });
  std::printf("violation %.1e, solved by %s\n", motion.report().violation.position,
              motion.plan().linear_solver().c_str());
}

/// Runs velocity Verlet around SHAKE and RATTLE, with multipliers.
void embed(const System& system, int steps) {
  std::vector<double> masses = system.masses, r = system.positions, v = system.velocities, old(r.size());
  for (const Index support : system.supports.front().points)
    masses[static_cast<std::size_t>(support)] = std::numeric_limits<double>::infinity();
  Constrainer constrainer(masses, system.constraints, r, {.threads = 1});
  std::vector<double> lambda(constrainer.num_rows());
  const auto kick = [&] {
    for (std::size_t i = 0; i < masses.size(); ++i) v[3 * i + 2] -= std::isinf(masses[i]) ? 0.0 : 0.5 * step * 9.81;
  };
  double violation = 0.0;
  const auto advance = [&] {
    kick();
    old = r;
    for (std::size_t k = 0; k < r.size(); ++k) r[k] += step * v[k];
    const ConstraintReport positions = constrainer.constrain_positions({.step = step,
                                                                        .old_positions = old,
                                                                        .positions = r,
                                                                        .velocities = v,
                                                                        .wanted = {.multipliers = lambda},
                                                                        .measures = false,
                                                                        .tolerance = 1e-10});
    check(positions.outcome);
    kick();
    check(constrainer.constrain_velocities({.step = step, .positions = r, .velocities = v, .measures = false}).outcome);
    violation = positions.violation;
  };
  advance();
  measure("Constrainer", steps, [&] {
    for (int k = 0; k < 10; ++k) advance();
  });
  std::printf("violation %.1e\n", violation);
}

}  // namespace

int main(int argc, char** argv) try {
  const int steps = argc > 1 ? std::atoi(argv[1]) : 100;
  const System system = make_links();
  simulate(system, steps);
  embed(system, steps);
} catch (const std::exception& error) {
  std::fprintf(stderr, "links: %s\n", error.what());
  return 1;
}
