#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

/// Every driver here simulates these problems: beads on rigid rods, some also on springs or in honey, under gravity,
/// released at rest; and the car axis (car_axis.hpp).
namespace rivals {

using Place = std::array<double, 3>;

/// A rod from point i to point j, or from an anchor if i = -1.
struct Rod {
  int i, j;
  Place anchor{};
};

struct Problem {
  double mass = 0.1, length = 0.1, gravity = 9.81;  // kg, m, m/s^2 down z
  double t_end = 1.0;                               // s
  std::vector<double> places;                       // 3n, m
  std::vector<Rod> rods;
  std::vector<Rod> springs{};  // of the rods' length at rest
  double stiffness = 0.0;      // N/m
  double damping = 0.0;        // of a spring along itself, N s/m
  double drag = 0.0;           // N s/m
  bool is_car_axis = false;    // of which the above says nothing but places and t_end

  bool is_stiff() const { return !springs.empty() || drag > 0.0; }

  int size() const { return static_cast<int>(places.size() / 3); }
  int equations() const { return static_cast<int>(rods.size()); }

  /// Returns r_j - r_i of a rod, where r are positions, or velocities (anchors rest).
  Place difference(const Rod& rod, const double* r, bool are_places) const {
    Place d;
    for (int c = 0; c < 3; ++c) {
      const double from = rod.i >= 0 ? r[3 * rod.i + c] : are_places ? rod.anchor[c] : 0.0;
      d[c] = r[3 * rod.j + c] - from;
    }
    return d;
  }

  /// Computes f, N: weight, drag, and (k (|d| - l) + c d.u/|d|) d/|d| of the springs.
  void forces(const double* r, const double* v, double* f) const {
    for (int i = 0; i < 3 * size(); ++i) f[i] = -drag * v[i] - (i % 3 == 2 ? mass * gravity : 0.0);
    for (const Rod& spring : springs) {
      const Place d = difference(spring, r, true), u = difference(spring, v, false);
      const double size = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      const double stretching = (d[0] * u[0] + d[1] * u[1] + d[2] * u[2]) / size;
      const double pull = (stiffness * (size - length) + damping * stretching) / size;
      for (int c = 0; c < 3; ++c) {
        f[3 * spring.j + c] -= pull * d[c];
        if (spring.i >= 0) f[3 * spring.i + c] += pull * d[c];
      }
    }
  }
};

/// Makes N horizontal rods from an anchor.
inline Problem make_chain(int count, double mass, double length, double t_end) {
  Problem chain{mass, length, 9.81, t_end, {}, {}};
  chain.places.resize(static_cast<std::size_t>(3 * count));
  for (int i = 0; i < count; ++i) {
    chain.places[static_cast<std::size_t>(3 * i)] = length * (i + 1);
    chain.rods.push_back({i - 1, i});
  }
  return chain;
}

/// Makes such a chain with a spring for every second rod.
inline Problem make_spring_chain(int count, double stiffness, double damping) {
  Problem chain = make_chain(count, 0.1, 0.1, 1.0);
  chain.rods.clear();
  for (int i = 0; i < count; ++i) (i % 2 == 0 ? chain.rods : chain.springs).push_back({i - 1, i});
  chain.stiffness = stiffness;
  chain.damping = damping;
  return chain;
}

inline Problem make_chain_in_honey(int count) {
  Problem chain = make_chain(count, 0.1, 0.1, 20.0);
  chain.drag = 100.0;
  return chain;
}

/// Makes the axis with two wheels (IVP test set; Schneider 1990), in consistent units.
inline Problem make_car_axis() {
  Problem axis;
  axis.t_end = 3.0;
  axis.places = {0.0, 0.5, 0.0, 1.0, 0.5, 0.0};
  axis.is_car_axis = true;
  return axis;
}

/// Makes m x m beads in a plane with two diagonal corners anchored.
inline Problem make_net(int m) {
  Problem net;
  net.t_end = 0.1;
  std::vector<int> number(static_cast<std::size_t>(m * m), -1);
  const auto place = [&](int k) { return Place{net.length * (k % m), net.length * (k / m), 0.0}; };
  for (int k = 1; k + 1 < m * m; ++k) {
    number[k] = net.size();
    const Place r = place(k);
    net.places.insert(net.places.end(), r.begin(), r.end());
  }
  const auto join = [&](int a, int b) {
    if (number[b] < 0) std::swap(a, b);
    net.rods.push_back({number[a], number[b], place(a)});
  };
  for (int k = 0; k < m * m; ++k) {
    if (k % m + 1 < m) join(k, k + 1);
    if (k + m < m * m) join(k, k + m);
  }
  return net;
}

/// Makes a problem by its name: "chain" (size rods, 1 s), "net" (size x size, 0.1 s), "pendulum" (10 s), "a01" (IFToMM:
/// 1 kg, 1 m, 2000 s), "springs" (size links, every second one a spring of 1e8 N/m, 1 s), "damped" (the same with
/// 4472 N s/m: critical where two beads swing freely), "honey" (size rods, 20 s), "car_axis" (3 s).
inline Problem make_problem(const std::string& name, int size) {
  if (name == "chain") return make_chain(size, 0.1, 0.1, 1.0);
  if (name == "net") return make_net(size);
  if (name == "pendulum") return make_chain(1, 0.1, 0.1, 10.0);
  if (name == "a01") return make_chain(1, 1.0, 1.0, 2000.0);
  if (name == "springs") return make_spring_chain(size, 1e8, 0.0);
  if (name == "damped") return make_spring_chain(size, 1e8, std::sqrt(2.0 * 0.1 * 1e8));
  if (name == "honey") return make_chain_in_honey(size);
  if (name == "car_axis") return make_car_axis();
  throw std::invalid_argument("problem " + name);
}

/// Returns the processor time of the process, s; other work on the machine counts little.
inline double processor_time() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// The cost of a run and the positions at its end.
struct Run {
  double seconds = 0.0;  // of the steps alone, without set-up
  long steps = 0, factorizations = 0;
  std::vector<double> places;
};

/// Repeats short runs for a twentieth of a second and keeps the median of their times. Prints
/// "seconds steps factorizations" and writes the end in the form of a reference file.
inline void report(const Problem& problem, const std::function<Run()>& make_run, const std::string& file) {
  std::vector<double> times;
  Run last;
  for (double total = 0.0; total < 0.05 && times.size() < 101; total += last.seconds) {
    last = make_run();
    times.push_back(last.seconds);
  }
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
  std::printf("%.6g %ld %ld\n", times[times.size() / 2], last.steps, last.factorizations);
  std::FILE* out = std::fopen(file.c_str(), "w");
  if (!out) throw std::runtime_error("cannot write " + file);
  std::fprintf(out, "%.17g\n", problem.t_end);
  for (std::size_t i = 0; i < last.places.size(); i += 3) {
    std::fprintf(out, "%.17g %.17g %.17g\n", last.places[i], last.places[i + 1], last.places[i + 2]);
  }
  std::fclose(out);
}

/// Runs a driver's main with PROBLEM SIZE METHOD TOLERANCE FILE; make_run(problem, method, tolerance) is one run of it.
/// An error is the last line of the error stream, and the exit code is 1.
template <class MakeRun>
int drive(int count, char** words, const MakeRun& make_run) try {
  if (count != 6) return 2;
  const Problem problem = make_problem(words[1], std::atoi(words[2]));
  report(
      problem, [&] { return make_run(problem, std::string(words[3]), std::atof(words[4])); }, words[5]);
  return 0;
} catch (const std::exception& trouble) {
  std::fprintf(stderr, "%s\n", trouble.what());
  return 1;
}

}  // namespace rivals
