// Measures what it costs to change the constraints of a Constrainer, and to call it from C:
//   edits
// Prints medians in milliseconds of processor time of one thread for making a handle, for an edit with the plan that it
// asks for, and for the first step after it beside a later one; then the ratio of a step by calls from C to one by
// calls
// from C++, in turn.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <time.h>

#include <tanor.h>
#include <tanor/constrainer.hpp>

#include "timing.hpp"

namespace {

using namespace tanor;

constexpr double h = 1e-3;

struct Host {
  std::vector<double> masses, r, v;
  Rods rods{"rods", {}, {}, {}};
};

/// Makes crumpled chains.
Host make_chains(std::size_t count, std::size_t length) {
  Host host;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (std::size_t i = 0; i < count * (length + 1); ++i) {
    const bool begins = i % (length + 1) == 0;
    const double d[3]{normal(random), normal(random), normal(random)}, size = std::hypot(d[0], d[1], d[2]);
    for (std::size_t k = 0; k < 3; ++k) {
      host.r.push_back((begins ? 0.0 : host.r[3 * i + k - 3]) + d[k] / size);
      host.v.push_back(normal(random));
    }
    if (!begins) host.rods.pairs.push_back({static_cast<Index>(i) - 1, static_cast<Index>(i)});
  }
  host.masses.assign(host.r.size() / 3, 1.0);
  return host;
}

/// Makes bent square nets of side x side points.
Host make_nets(std::size_t count, std::size_t side) {
  Host host;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto width = static_cast<Index>(side);
  for (std::size_t i = 0; i < count * side * side; ++i) {
    const std::size_t a = i % (side * side) / side, b = i % side;
    const auto point = static_cast<Index>(i);
    host.r.insert(host.r.end(), {static_cast<double>(a), static_cast<double>(b), 0.3 * normal(random)});
    for (std::size_t k = 0; k < 3; ++k) host.v.push_back(normal(random));
    if (b > 0) host.rods.pairs.push_back({point - 1, point});
    if (a > 0) host.rods.pairs.push_back({point - width, point});
  }
  host.masses.assign(host.r.size() / 3, 1.0);
  return host;
}

double milliseconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}
double time_of(const std::function<void()>& task) {
  const double begin = milliseconds();
  task();
  return milliseconds() - begin;
}

void expect(bool is_so, const std::string& what) {
  if (is_so) return;
  std::puts(what.c_str());
  std::exit(1);
}

void step(Constrainer* constrainer, const Host& host) {
  std::vector<double> r = host.r, v = host.v;
  for (std::size_t k = 0; k < r.size(); ++k) r[k] += h * v[k];
  ConstraintReport report = constrainer->constrain_positions(
      {.step = h, .old_positions = host.r, .positions = r, .velocities = v, .measures = false});
  expect(report.outcome.ok(), report.outcome.what);
  report = constrainer->constrain_velocities({.step = h, .positions = r, .velocities = v, .measures = false});
  expect(report.outcome.ok(), report.outcome.what);
}

/// Takes steps, in turn, of a handle that expects edits and of one that does not.
void measure_parts(const Host& host, std::vector<double>* in_parts, std::vector<double>* in_one) {
  Constrainer parts(host.masses, {host.rods}, host.r, {.threads = 1}),
      one(host.masses, {host.rods}, host.r, {.threads = 1});
  parts.expect_edits();
  for (int turn = 0; turn < 22; ++turn) {
    const double by_parts = time_of([&] { step(&parts, host); }), by_one = time_of([&] { step(&one, host); });
    if (turn < 2) continue;  // plans
    in_parts->push_back(by_parts);
    in_one->push_back(by_one);
  }
}

/// Removes rods from the middle of many islands and adds them again.
void measure_edits(const char* name, const Host& host) {
  constexpr int turns = 51;
  std::vector<double> makes, removals, additions, masses, lengths, first_steps, later_steps;
  for (int k = 0; k < 3; ++k)
    makes.push_back(time_of([&] { Constrainer(host.masses, {host.rods}, host.r, {.threads = 1}); }));
  Constrainer constrainer(host.masses, {host.rods}, host.r, {.threads = 1});
  std::vector<double> steps_of_parts, steps_of_one;
  measure_parts(host, &steps_of_parts, &steps_of_one);
  constrainer.expect_edits();
  step(&constrainer, host);
  const std::size_t num_rods = host.rods.pairs.size();
  for (std::size_t turn = 0; turn < turns; ++turn) {
    const std::size_t number = (turn * 7919 + 50) % num_rods;
    ConstraintId id = static_cast<ConstraintId>(number);
    const auto pair = host.rods.pairs[number];
    double length = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<std::size_t>(pair[0]), j = static_cast<std::size_t>(pair[1]);
      length += std::pow(host.r[3 * j + k] - host.r[3 * i + k], 2);
    }
    length = std::sqrt(length);
    removals.push_back(time_of([&] {
      constrainer.remove({&id, 1});
      (void)constrainer.update_plan();
    }));
    first_steps.push_back(time_of([&] { step(&constrainer, host); }));
    later_steps.push_back(time_of([&] { step(&constrainer, host); }));
    additions.push_back(time_of([&] {
      id = constrainer.add(Rods{{}, {pair}, length, {}});
      (void)constrainer.update_plan();
    }));
    const double mass = turn % 2 == 0 ? 2.0 : 1.0;
    masses.push_back(time_of([&] {
      constrainer.set_masses({&pair[0], 1}, {&mass, 1});
      (void)constrainer.update_plan();
    }));
    const double rate = 1e-9;
    constrainer.set_lengths({&id, 1}, {&length, 1}, {&rate, 1});
    (void)constrainer.update_plan();
    lengths.push_back(time_of([&] {
      constrainer.set_lengths({&id, 1}, {&length, 1}, {&rate, 1});
      (void)constrainer.update_plan();
    }));
  }
  std::printf(
      "%-28s made %8.2f   removed %6.3f   added %6.3f   mass %6.3f   driven length %7.4f   step after an edit %6.2f, "
      "later %6.2f ms; "
      "in parts %.2f of one in one part\n",
      name, median(makes), median(removals), median(additions), median(masses), median(lengths), median(first_steps),
      median(later_steps), median(steps_of_parts) / median(steps_of_one));
}

/// Compares handles of the same system, called from C and from C++ on the same arrays.
void compare_c(std::size_t count, std::size_t length) {
  const Host host = make_chains(count, length);
  Constrainer constrainer(host.masses, {host.rods}, host.r, {.threads = 1});
  tn_system* system = nullptr;
  tn_options options{.size = sizeof(tn_options), .threads = 1};
  expect(tn_create(&system, host.masses.size(), host.masses.data(), {host.r.data(), 0, nullptr}, &options) == TN_OK,
         tn_create_error());
  expect(
      tn_add_rods(system, host.rods.pairs.size(), host.rods.pairs.data()->data(), nullptr, nullptr, nullptr) == TN_OK,
      tn_last_error(system));
  std::vector<double> r, v, free = host.r;
  for (std::size_t k = 0; k < free.size(); ++k) free[k] += h * host.v[k];
  const auto from_cpp = [&] {
    (void)constrainer.constrain_positions(
        {.step = h, .old_positions = host.r, .positions = r, .velocities = v, .measures = false});
    (void)constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v, .measures = false});
  };
  const auto from_c = [&] {
    (void)tn_constrain_positions(system, h, {host.r.data(), 0, nullptr}, {r.data(), 0, nullptr}, {v.data(), 0, nullptr},
                                 nullptr, nullptr);
    (void)tn_constrain_velocities(system, h, {r.data(), 0, nullptr}, {v.data(), 0, nullptr}, nullptr, nullptr);
  };
  const std::size_t repeats = 100'000 / (count * length) + 1;
  std::vector<double> ratios;
  for (int turn = 0; turn < 101; ++turn) {
    double times[2]{};
    for (std::size_t k = 0; k < 2 * repeats; ++k) {
      r = free;
      v = host.v;
      const bool is_c = k % 2 == 0;
      times[is_c ? 0 : 1] += is_c ? time_of(from_c) : time_of(from_cpp);
    }
    ratios.push_back(times[0] / times[1]);
  }
  tn_destroy(system);
  std::printf("%zu chains of %zu rods: a step from C takes %.3f of one from C++\n", count, length, median(ratios));
}

}  // namespace

int main() {
  measure_edits("1000 chains of 100 rods", make_chains(1000, 100));
  measure_edits("10,000 chains of 10 rods", make_chains(10'000, 10));
  measure_edits("100 nets of 22 x 22 points", make_nets(100, 22));
  for (const std::size_t length : {10, 1000, 100'000}) compare_c(1, length);
  compare_c(1000, 100);
}
