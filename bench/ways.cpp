// One evaluation of the accelerations on each way (SolverOptions::way), beside the Eigen baseline, in turn in one
// process:
//   ways [--threads N] [--json FILE] [NAME …]      scenes whose name begins so; default: all of them
// Prints nanoseconds a rod or bead (medians) and the ratios baseline/ours and general way/ours on one thread; with
// N > 1 by how much N threads are faster than one (best of each: others' work on the machine stops threads that wait
// for each other).

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "dynamics/forms.hpp"
#include "eigen_baseline.hpp"
#include "scene/scene.hpp"
#include "timing.hpp"

namespace {

using namespace tanor;

System melt(int chains, int count) {
  const std::string entry = fmt::format(R"({{"kind": "melt", "chains": {}, "count": {}}})", chains, count);
  return scene::parse_scene(R"({"tanor_scene": 1, "generate": )" + entry + "}", "bench.json").system;
}

/// The same system with points and rods in any order.
System shuffled(System given) {
  std::mt19937 generator(2);
  std::vector<Index> place(given.masses.size());
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), generator);
  System system = given;
  const auto move = [](const std::vector<double>& from, std::size_t i, Index to, std::vector<double>* all) {
    if (!from.empty()) std::copy_n(from.begin() + 3 * static_cast<std::ptrdiff_t>(i), 3, all->begin() + 3 * to);
  };
  for (std::size_t i = 0; i < place.size(); ++i) {
    system.masses[static_cast<std::size_t>(place[i])] = given.masses[i];
    move(given.positions, i, place[i], &system.positions);
    move(given.velocities, i, place[i], &system.velocities);
  }
  auto& pairs = std::get<Rods>(system.constraints.front()).pairs;
  for (auto& [i, j] : pairs) {
    i = place[static_cast<std::size_t>(i)];
    j = place[static_cast<std::size_t>(j)];
  }
  std::shuffle(pairs.begin(), pairs.end(), generator);
  return system;
}

/// Nets and lattices of rods, with waves across their flat directions.
System generated(const std::string& generate) {
  System system = scene::parse_scene(R"({"tanor_scene": 1, "generate": )" + generate + "}", "bench.json").system;
  if (!system.velocities.empty()) return system;
  system.velocities.resize(system.positions.size());
  for (std::size_t i = 0; i < system.positions.size(); i += 3)
    system.velocities[i + 2] = 0.1 * std::sin(7.0 * system.positions[i] + 3.0 * system.positions[i + 1]);
  return system;
}

System net(int size) {
  return generated(fmt::format(R"({{"kind": "net", "columns": {0}, "rows": {0}}})", size));
}

System lattice(int size) {
  return generated(fmt::format(R"({{"kind": "lattice", "size": [{0}, {0}, {0}]}})", size));
}

/// Copies of a rigid or jointed thing, each turned and thrown at random, the same each time.
System copies(int count, const std::vector<Eigen::Vector3d>& points, const std::vector<std::array<int, 2>>& rods) {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const auto random_vector = [&] { return Eigen::Vector3d(normal(generator), normal(generator), normal(generator)); };
  const auto append = [](const Eigen::Vector3d& x, std::vector<double>* to) {
    to->insert(to->end(), x.data(), x.data() + 3);
  };
  System system;
  Rods group;
  for (int copy = 0; copy < count; ++copy) {
    const auto first = static_cast<Index>(system.masses.size());
    const Eigen::Quaterniond turn = Eigen::Quaterniond::UnitRandom();
    const Eigen::Vector3d place = 10.0 * random_vector(), v = random_vector(), omega = random_vector();
    for (const Eigen::Vector3d& point : points) {
      const Eigen::Vector3d arm = turn * point;
      append(place + arm, &system.positions);
      append(v + omega.cross(arm), &system.velocities);
      system.masses.push_back(std::exp(0.3 * normal(generator)));
    }
    for (const auto& [i, j] : rods) group.pairs.push_back({first + i, first + j});
  }
  system.constraints = {group};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

System rings(int count) {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 2>> rods;
  for (int k = 0; k < 6; ++k) {
    points.emplace_back(std::cos(k * std::numbers::pi / 3.0), std::sin(k * std::numbers::pi / 3.0), 0.3 * (k % 2));
    rods.push_back({k, (k + 1) % 6});
  }
  return copies(count, points, rods);
}

System triangles(int count) {
  return copies(count, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1}, {0, 2}, {1, 2}});
}

System tetrahedra(int count) {
  return copies(count, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}});
}

/// Each on a sphere of its own radius around the origin, or on such a circle around the z axis.
System beads(int count, EigenBeads::Guide guide) {
  System system = copies(count, {{0, 0, 0}}, {});
  std::vector<Index> points(static_cast<std::size_t>(count));
  std::iota(points.begin(), points.end(), 0);
  const bool on_circles = guide == EigenBeads::Guide::Circle;
  if (on_circles) {
    for (std::size_t i = 2; i < system.positions.size(); i += 3) system.positions[i] = 0.0;
    system.constraints = {Circles{"", points, VectorFunction(0.0, 0.0, 0.0), VectorFunction(0.0, 0.0, 1.0), {}}};
  } else {
    system.constraints = {Spheres{"", points, VectorFunction(0.0, 0.0, 0.0), {}}};
  }
  return system;
}

struct BenchScene {
  std::string name;
  std::function<System()> make;
  double bar;  ///< wanted ratio baseline/ours on one thread; 0: none
};

const std::vector<BenchScene> scenes = {
    {"chain 1e3", [] { return melt(1, 1000); }, 8.0},
    {"chain 1e4", [] { return melt(1, 10000); }, 8.0},
    {"chain 1e5", [] { return melt(1, 100000); }, 8.0},
    {"chain 1e6", [] { return melt(1, 1000000); }, 12.0},
    {"shuffled chain 1e6", [] { return shuffled(melt(1, 1000000)); }, 12.0},
    {"clusters 1e2 x 10", [] { return melt(100, 10); }, 8.0},
    {"clusters 1e3 x 10", [] { return melt(1000, 10); }, 8.0},
    {"clusters 1e4 x 10", [] { return melt(10000, 10); }, 8.0},
    {"clusters 1e5 x 10", [] { return melt(100000, 10); }, 8.0},
    {"rings 1e4 x 6", [] { return rings(10000); }, 8.0},
    {"triangles 1e4", [] { return triangles(10000); }, 8.0},
    {"tetrahedra 1e4", [] { return tetrahedra(10000); }, 8.0},
    {"spheres 1e3", [] { return beads(1000, EigenBeads::Guide::Sphere); }, 13.0},
    {"spheres 1e4", [] { return beads(10000, EigenBeads::Guide::Sphere); }, 13.0},
    {"spheres 1e5", [] { return beads(100000, EigenBeads::Guide::Sphere); }, 13.0},
    {"spheres 1e6", [] { return beads(1000000, EigenBeads::Guide::Sphere); }, 13.0},
    {"circles 1e5", [] { return beads(100000, EigenBeads::Guide::Circle); }, 0.0},
    {"melt 320 x 99", [] { return melt(320, 99); }, 8.0},
    {"net 30", [] { return net(30); }, 1.2},
    {"net 100", [] { return net(100); }, 1.2},
    {"net 300", [] { return net(300); }, 2.0},
    {"lattice 10", [] { return lattice(10); }, 1.6},
    {"lattice 20", [] { return lattice(20); }, 22.0},
};

/// The yardstick for what a system is made of.
std::function<const Eigen::VectorXd&(const double*, const double*)> make_baseline(const System& system) {
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  for (const Force& force : system.forces)
    gravity = Eigen::Map<const Eigen::Vector3d>(std::get<Gravity>(force).acceleration.data());
  const auto evaluation_of = [](const auto& baseline) {
    return [baseline](const double* r, const double* v) -> const Eigen::VectorXd& { return baseline->evaluate(r, v); };
  };
  const Constraint& first = system.constraints.front();
  if (const auto* rods = std::get_if<Rods>(&first))
    return evaluation_of(std::make_shared<EigenBaseline>(rods->pairs, system.masses, gravity));
  const auto guide = std::holds_alternative<Spheres>(first) ? EigenBeads::Guide::Sphere : EigenBeads::Guide::Circle;
  return evaluation_of(std::make_shared<EigenBeads>(guide, system.masses, gravity));
}

/// A system at a consistent start in the inner order; `evaluate` finds its accelerations.
struct Ours {
  Forms forms;
  std::vector<double> r, v, w;

  Ours(const System& system, const SolverOptions& options) : forms(system, options) {
    for (std::vector<double>* array : {&r, &v, &w}) array->resize(system.positions.size());
    forms.model.numbering.gather_points(forms.model.system.positions, r);
    forms.model.numbering.gather_points(forms.model.system.velocities, v);
    forms.model.prescribe_all(0.0, r.data(), v.data());
    check(forms.start(0.0, r.data(), v.data(), StartMode::Project).outcome);
  }
  void evaluate() { check(forms.normal->accelerations(0.0, r.data(), v.data(), Gradients::Evaluate, w.data())); }
  std::vector<double> in_users_order(const std::vector<double>& inner) const {
    std::vector<double> result(inner.size());
    forms.model.numbering.scatter_points(inner, result);
    return result;
  }
  static void check(const Outcome& outcome) {
    if (!outcome.ok()) throw std::runtime_error(outcome.what);
  }
};

/// One line of the table, as JSON.
std::string measure(const BenchScene& scene, int threads) {
  const System system = scene.make();
  Ours ours(system, {.threads = 1}), general(system, {.way = Way::General, .threads = 1});
  std::unique_ptr<Ours> together;
  if (threads > 1) together = std::make_unique<Ours>(system, SolverOptions{.threads = threads});
  const auto baseline = make_baseline(system);
  const bool is_of_beads = !std::holds_alternative<Rods>(system.constraints.front());
  const double num_members =
      static_cast<double>(is_of_beads ? ours.forms.model.num_points() : ours.forms.model.num_rows());
  const std::vector<double> r = ours.in_users_order(ours.r), v = ours.in_users_order(ours.v);

  const int repeats = std::max(1, static_cast<int>(2e5 / num_members));
  std::vector<double> times[4];
  const double first = seconds_of([&] { (void)baseline(r.data(), v.data()); });
  const int rounds = first < 0.5 ? 11 : 3;
  for (int round = 0; round < rounds; ++round) {
    times[0].push_back(seconds_of([&] { (void)baseline(r.data(), v.data()); }));
    const auto repeat = [&](Ours& each) {
      each.evaluate();  // wakes the caches after another one's work
      return seconds_of([&] {
               for (int k = 0; k < repeats; ++k) each.evaluate();
             }) /
             repeats;
    };
    times[1].push_back(repeat(ours));
    times[2].push_back(repeat(general));
    if (together) times[3].push_back(repeat(*together));
  }
  const std::vector<double> w = ours.in_users_order(ours.w);
  double difference = 0.0, largest = 1e-300;
  const Eigen::VectorXd& reference = baseline(r.data(), v.data());
  for (std::size_t i = 0; i < w.size(); ++i) {
    difference = std::max(difference, std::abs(w[i] - reference[static_cast<Eigen::Index>(i)]));
    largest = std::max(largest, std::abs(w[i]));
  }
  // The baseline does not refine: a chain of N rods costs it cond S ~ N^2 digits.
  const double tolerance = std::max(1e-9, 1e-15 * num_members * num_members);
  if (!(difference <= tolerance * largest)) throw std::runtime_error(scene.name + ": the two solutions differ");
  const double unit = 1e9 / num_members, base = median(times[0]), mine = median(times[1]), theirs = median(times[2]);
  const auto best = [](const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); };
  const std::string speedup = together ? fmt::format("{:12.2f}", best(times[1]) / best(times[3])) : "";
  fmt::print("{:20}{:>14}{:10.1f}{:10.1f}{:10.1f}{:10.1f}{:8.1f}{:10.1f}{}\n", scene.name, ours.forms.plan.way,
             unit * base, unit * theirs, unit * mine, base / mine, scene.bar, theirs / mine, speedup);
  return fmt::format(
      R"({{"scene": "{}", "way": "{}", "members": {:.0f}, "eigen_ns": {:.2f}, "general_ns": {:.2f}, "ours_ns": {:.2f}, )"
      R"("ratio": {:.2f}, "bar": {:.1f}, "threads": {}, "speedup": {}}})",
      scene.name, ours.forms.plan.way, num_members, unit * base, unit * theirs, unit * mine, base / mine, scene.bar,
      threads, together ? fmt::format("{:.2f}", best(times[1]) / best(times[3])) : "null");
}

}  // namespace

int main(int argc, char** argv) try {
  int threads = 1;
  std::string file;
  std::vector<std::string> wanted, lines;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word == "--threads" && k + 1 < argc) {
      threads = std::stoi(argv[++k]);
    } else if (word == "--json" && k + 1 < argc) {
      file = argv[++k];
    } else {
      wanted.push_back(word);
    }
  }
  fmt::print("{:20}{:>14}{:>10}{:>10}{:>10}{:>10}{:>8}{:>10}{}\n", "ns a rod or bead", "way", "Eigen", "general",
             "ours", "ratio", "bar", "/general", threads > 1 ? fmt::format("{:>11}x", threads) : "");
  for (const BenchScene& scene : scenes) {
    const auto begins = [&](const std::string& word) { return scene.name.starts_with(word); };
    if (wanted.empty() || std::any_of(wanted.begin(), wanted.end(), begins)) lines.push_back(measure(scene, threads));
  }
  if (!file.empty()) std::ofstream(file) << fmt::format("[\n{}\n]\n", fmt::join(lines, ",\n"));
} catch (const std::exception& error) {
  fmt::print(stderr, "ways: {}\n", error.what());
  return 1;
}
