/// Checks that memory does not grow: three motions of a million steps each, a million solves, ten thousand handles of
/// <tanor.h>.
///
///   soak [share]    with a share of these numbers (default 1); a page in Markdown; exit code 1 where something grows
///
/// Bytes that are in use on the heap are taken after a tenth of the work and at its end. They may differ by some arrays
/// that are kept for a moment, never by a number for each step.

#include <malloc.h>
#include <tanor.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <tanor/motion.hpp>
#include <tanor/version.hpp>

#include "scenes.hpp"

namespace {

using namespace tanor;

constexpr std::size_t million = 1'000'000;

std::size_t bytes_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}
std::size_t bytes_resident() {
  std::size_t all = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> all >> resident;
  return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

/// Does one thing so many times and returns true if memory did not grow.
bool repeat(const char* what, std::size_t count, const std::function<void()>& once) {
  constexpr double allowed_heap = 16e3, allowed_resident = 4e6;
  const std::clock_t begin = std::clock();
  std::size_t heap = 0, resident = 0;
  for (std::size_t k = 0; k < count; ++k) {
    once();
    if (k + 1 == count / 10) {
      heap = bytes_in_use();
      resident = bytes_resident();
    }
  }
  const double more = static_cast<double>(bytes_in_use()) - static_cast<double>(heap);
  const double more_resident = static_cast<double>(bytes_resident()) - static_cast<double>(resident);
  std::printf("| %s | %zu | %.1f | %.1f | %+.1f | %+.0f |\n", what, count,
              static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 1e-3 * static_cast<double>(heap), 1e-3 * more,
              1e-3 * more_resident);
  std::fflush(stdout);
  return more <= allowed_heap && more_resident <= allowed_resident;
}

/// Makes beads that slip and stick on a floor that swings.
System make_rough_floor() {
  System floor;
  for (int k = 0; k < 3; ++k) {
    floor.positions.insert(floor.positions.end(), {0.3 * k, 0.0, 0.0});
    floor.velocities.insert(floor.velocities.end(), {0.5, 0.0, 0.0});
    floor.masses.push_back(1.0);
  }
  Planes planes{.name = "floor"};
  planes.points = {0, 1, 2};
  planes.normal = Vector3{0.0, 0.0, 1.0};
  floor.constraints.emplace_back(planes);
  Coulomb law;
  law.at = {"floor"};
  law.coefficient = 0.2;
  floor.friction.emplace_back(law);
  floor.forces.emplace_back(Gravity{.name = "g", .acceleration = {0.0, 0.0, -9.81}});
  floor.forces.emplace_back(FormulaForce{"push", {0, 1, 2}, formula_force({"3*sin(5*t+x)", "2*cos(3*t)", "0"})});
  return floor;
}

/// Steps a motion until it has made so many steps; one step is one advance.
bool soak_motion(const char* what, System system, MotionOptions options, double interval, std::size_t count) {
  Simulation simulation(std::move(system), options, {.threads = 1});
  return repeat(what, count, [&, k = 0.0]() mutable {
    k += 1.0;
    const Outcome outcome = simulation.advance_to(k * interval);
    if (outcome.ok()) return;
    std::fprintf(stderr, "%s: %s\n", what, outcome.what.c_str());
    std::exit(1);
  });
}

bool soak_solves(std::size_t count) {
  const System net = scenes::make_curtain(5, 5);
  Dynamics dynamics(net, {.threads = 1});
  std::vector<double> r = net.positions, v(r.size());
  constexpr std::size_t across = 3 * 7 + 1;  // the plane, of a bead
  return repeat("solves of a net of 25 beads", count, [&, k = 0.0]() mutable {
    k += 1.0;
    v[across] = std::sin(k);
    if (!dynamics.solve({.time = k, .positions = r, .velocities = v}).outcome.ok()) std::exit(1);
  });
}

/// Makes, edits, steps, saves, restores and destroys one handle after another.
bool soak_handles(std::size_t count) {
  return repeat("handles of `tanor.h`", count, [] {
    std::vector<double> x{0, 0, 0, 1, 0, 0, 1, 1, 0, 2, 1, 0}, masses(4, 1.0), next = x, v(12, 0.01);
    const std::vector<std::int32_t> pairs{0, 1, 1, 2, 2, 3};
    tn_system* system = nullptr;
    tn_options options{sizeof(tn_options), 1, 0.0};
    bool good = tn_create(&system, 4, masses.data(), {x.data(), 0, nullptr}, &options) == TN_OK;
    std::int64_t ids[3];
    good = good && tn_add_rods(system, 3, pairs.data(), nullptr, nullptr, ids) == TN_OK;
    next[4] += 1e-3;
    good = good && tn_constrain_positions(system, 1e-2, {x.data(), 0, nullptr}, {next.data(), 0, nullptr},
                                          {v.data(), 0, nullptr}, nullptr, nullptr) == TN_OK;
    good = good && tn_remove(system, 1, ids) == TN_OK && tn_remove(system, 1, ids) == TN_EINVAL;
    std::size_t size = 0;
    good = good && tn_save(system, nullptr, &size) == TN_OK;
    std::vector<char> state(size);
    good = good && tn_save(system, state.data(), &size) == TN_OK && tn_restore(system, state.data(), size) == TN_OK;
    tn_destroy(system);
    if (!good) std::exit(1);
  });
}

}  // namespace

int main(int argc, char** argv) {
  const double share = argc > 1 ? std::atof(argv[1]) : 1.0;
  const auto part = [&](std::size_t count) { return static_cast<std::size_t>(share * static_cast<double>(count)); };
  std::printf("# Soak: does memory grow?\n\n");
  char date[11];
  const std::time_t now = std::time(nullptr);
  std::strftime(date, sizeof date, "%Y-%m-%d", std::localtime(&now));
  std::printf(
      "`build/bench/soak%s%s`, tanor %s, %s: bytes in use on the heap and resident,\n"
      "after a tenth of the work and more at its end.\n\n",
      argc > 1 ? " " : "", argc > 1 ? argv[1] : "", TANOR_VERSION, date);
  std::printf("| what | times | s of the processor | heap after a tenth, kB | more at the end, kB | resident, kB |\n");
  std::printf("|---|--:|--:|--:|--:|--:|\n");
  bool stands = soak_motion("steps of a net of 25 beads, rattle", scenes::make_curtain(5, 5),
                            {.method = Method::Rattle, .step = 1e-3}, 1e-3, part(million));
  stands &= soak_motion("steps of a net of 9 beads, taylor", scenes::make_curtain(3, 3),
                        {.method = Method::Taylor, .rtol = 1e-6}, 1e-3, part(million));
  stands &= soak_motion("steps of 3 beads that slip and stick, dop853", make_rough_floor(),
                        {.method = Method::Dop853, .rtol = 1e-6}, 1e-3, part(million));
  stands &= soak_solves(part(million));
  stands &= soak_handles(part(10'000));
  std::printf("\n%s\n", stands ? "Nothing grows." : "**Something grows.**");
  return stands ? 0 : 1;
}
