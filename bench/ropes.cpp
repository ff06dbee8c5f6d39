/// Measures one-sided constraints: a hub of 20 ropes over 20 pulleys and a box on an incline, both beside MuJoCo, and a
/// fishing net beside the same net of rods.
///
///   ropes hub [pairs]            error after 1 s against processor time, both in turn, medians of `pairs` runs (5)
///   ropes incline                how fast a box of eight points creeps that sticks on an incline
///   ropes net [side] [seconds]   a net of side x side points (100) falls and is caught, for so many seconds of
///                                processor time (600), a fifth of it for rods: complementarity at every output, and
///                                its median step
///
/// Writes tables in Markdown. Without MuJoCo (Debian: libmujoco-dev) the hub has tanor's rows alone.

#ifdef TANOR_HAS_MUJOCO
#include <mujoco/mujoco.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "timing.hpp"

namespace {

using namespace tanor;

constexpr double g = 9.81, pi = 3.14159265358979323846;

// ---- the hub ----

constexpr int count = 20;
constexpr double t_end = 1.0;

double norm_of(const double* a, const double* b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The hub is point 0, loads are 1 to 20, pulleys 21 to 40. All ropes are taut at the start and stay so.
System make_hub() {
  System system;
  const auto add = [&](const Vector3& r, const Vector3& v, double mass) {
    system.positions.insert(system.positions.end(), r.begin(), r.end());
    system.velocities.insert(system.velocities.end(), v.begin(), v.end());
    system.masses.push_back(mass);
  };
  const auto place = [](int k, double z) {
    const double angle = 2.0 * pi * k / count, radius = 2.0 + 0.1 * std::sin(3.0 * k);
    return Vector3{radius * std::cos(angle), radius * std::sin(angle), z};
  };
  add({0.1, -0.05, -0.5}, {0.5, 0.3, 0.0}, 4.5);
  for (int k = 0; k < count; ++k) add(place(k, -1.0 - 0.02 * k), {0, 0, 0}, 1.0 + 0.05 * std::cos(2.0 * k));
  for (int k = 0; k < count; ++k) add(place(k, 0.0), {0, 0, 0}, 1.0);
  Ropes ropes{.name = "ropes"};
  Support pulleys{.name = "pulleys"};
  for (Index k = 0; k < count; ++k) {
    pulleys.points.push_back(count + 1 + k);
    ropes.paths.push_back({0, count + 1 + k, 1 + k});
  }
  // Each load falls with its rope: its speed is that with which the hub comes nearer to the pulley.
  for (std::size_t k = 0; k < count; ++k) {
    const double* const hub = system.positions.data();
    const double* const pulley = hub + 3 * (count + 1 + k);
    double rate = 0.0;
    for (std::size_t c = 0; c < 3; ++c) rate += (hub[c] - pulley[c]) * system.velocities[c] / norm_of(hub, pulley);
    system.velocities[3 * (1 + k)] = 0.2 * std::sin(static_cast<double>(k));
    system.velocities[3 * (1 + k) + 2] = rate;
  }
  system.supports = {pulleys};
  system.constraints = {ropes};
  system.add_gravity({0.0, 0.0, -g});
  return system;
}

struct Run {
  std::vector<double> positions{};  // of hub and loads
  double seconds = 0.0;
  std::size_t steps = 0;
};

Run run_tanor(const System& system, const MotionOptions& options) {
  Simulation simulation(system, options, {.threads = 1});
  const double begin = processor_seconds();
  const Outcome outcome = simulation.advance_to(t_end);
  Run run{.seconds = processor_seconds() - begin, .steps = simulation.report().steps};
  if (!outcome.ok()) throw std::runtime_error(outcome.what);
  run.positions.assign(simulation.positions().begin(), simulation.positions().begin() + 3 * (count + 1));
  return run;
}

#ifdef TANOR_HAS_MUJOCO
using MujocoModel = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;

MujocoModel read_mujoco(const std::string& text) {
  const std::unique_ptr<mjVFS, void (*)(mjVFS*)> files(new mjVFS, [](mjVFS* vfs) {
    mj_deleteVFS(vfs);
    delete vfs;
  });
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "x.xml", static_cast<int>(text.size()));
  std::copy(text.begin(), text.end(), static_cast<char*>(files->filedata[mj_findFileVFS(files.get(), "x.xml")]));
  char trouble[1000] = "";
  MujocoModel model(mj_loadXML("x.xml", files.get(), trouble, sizeof trouble), mj_deleteModel);
  if (!model) throw std::runtime_error(std::string("MuJoCo: ") + trouble);
  return model;
}

/// Points on three slides each; a rope is a tendon over three sites with a limit on its length, the stiffest that the
/// manual allows: a time constant of two steps, critically damped.
std::string describe_hub(const System& system, double step) {
  std::ostringstream bodies, ropes;
  bodies.precision(17);
  ropes.precision(17);
  const double* const r = system.positions.data();
  for (std::size_t i = 0; i <= 2 * count; ++i) {
    const double* const at = r + 3 * i;
    std::ostringstream place;
    place.precision(17);
    place << "pos='" << at[0] << ' ' << at[1] << ' ' << at[2] << "'";
    if (i > count) {
      bodies << "<site name='s" << i << "' " << place.str() << "/>";
      continue;
    }
    bodies << "<body " << place.str() << "><joint type='slide' axis='1 0 0'/><joint type='slide' axis='0 1 0'/>"
           << "<joint type='slide' axis='0 0 1'/><inertial pos='0 0 0' mass='" << system.masses[i]
           << "' diaginertia='1e-9 1e-9 1e-9'/><site name='s" << i << "'/></body>";
  }
  for (std::size_t k = 0; k < count; ++k) {
    const double length = norm_of(r, r + 3 * (count + 1 + k)) + norm_of(r + 3 * (1 + k), r + 3 * (count + 1 + k));
    ropes << "<spatial limited='true' range='0 " << length << "' solreflimit='" << 2.0 * step
          << " 1' solimplimit='0.9999 0.9999 0.001'><site site='s0'/><site site='s" << count + 1 + k
          << "'/><site site='s" << 1 + k << "'/></spatial>";
  }
  std::ostringstream text;
  text.precision(17);
  text << "<mujoco><compiler boundmass='0' boundinertia='0'/><option timestep='" << step
       << "' integrator='RK4' gravity='0 0 " << -g
       << "' solver='Newton' tolerance='1e-12' iterations='50'><flag contact='disable'/></option><worldbody>"
       << bodies.str() << "</worldbody><tendon>" << ropes.str() << "</tendon></mujoco>";
  return text.str();
}

Run run_mujoco(const System& system, double step) {
  const MujocoModel model = read_mujoco(describe_hub(system, step));
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model.get()), mj_deleteData);
  std::copy_n(system.velocities.begin(), model->nv, data->qvel);
  Run run{.steps = static_cast<std::size_t>(std::lround(t_end / step))};
  const double begin = processor_seconds();
  for (std::size_t k = 0; k < run.steps; ++k) mj_step(model.get(), data.get());
  run.seconds = processor_seconds() - begin;
  mj_forward(model.get(), data.get());
  run.positions.assign(data->xipos + 3, data->xipos + 3 * (count + 2));  // body 0 is the world
  return run;
}
#endif

double largest_miss(const Run& run, const Run& reference) {
  double largest = 0.0;
  for (std::size_t i = 0; i < run.positions.size(); i += 3)
    largest = std::max(largest, norm_of(&run.positions[i], &reference.positions[i]));
  return largest;
}

void measure_hub(int pairs) {
  const System system = make_hub();
  const Run reference = run_tanor(system, {.method = Method::Dop853, .rtol = 1e-14, .atol = 1e-15});
  const Run other = run_tanor(system, {.method = Method::Taylor, .rtol = 1e-14, .atol = 1e-15});
  struct Row {
    std::string name;
    std::function<Run()> run;
    double error = 0.0;
    std::vector<double> seconds{};
    std::size_t steps = 0;
  };
  std::vector<Row> rows;
  for (const Method method : {Method::Taylor, Method::Dop853})
    for (const double rtol : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
      std::ostringstream name;
      name << "tanor " << name_of(method) << ", rtol " << rtol;
      rows.push_back({name.str(), [=, &system] {
                        return run_tanor(system, {.method = method, .rtol = rtol, .atol = 0.1 * rtol});
                      }});
    }
#ifdef TANOR_HAS_MUJOCO
  for (const double step : {2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5}) {
    std::ostringstream name;
    name << "MuJoCo " << mj_versionString() << ", step " << step;
    rows.push_back({name.str(), [=, &system] { return run_mujoco(system, step); }});
  }
#endif
  for (int pair = 0; pair < pairs; ++pair)
    for (Row& row : rows) {
      const Run run = row.run();
      row.error = largest_miss(run, reference);
      row.seconds.push_back(run.seconds);
      row.steps = run.steps;
    }
  std::printf("References of dop853 and taylor at 1e-14 differ by %.1e m.\n\n", largest_miss(other, reference));
  std::printf("| | largest error at 1 s, m | steps | processor time, ms |\n|---|--:|--:|--:|\n");
  for (const Row& row : rows)
    std::printf("| %s | %.1e | %zu | %.3g |\n", row.name.c_str(), row.error, row.steps, 1e3 * median(row.seconds));
}

// ---- the incline ----

constexpr double slope = 0.3, rough = 0.5, t_settled = 5.0, t_rest = 10.0;  // rad; it sticks, since tan 0.3 = 0.31

/// Eight points of 1 kg on 18 rods, whose lower four touch the plane z = 0 in a field that leans by `slope`.
double creep_of_tanor(double* seconds) {
  System system;
  for (int i = 0; i < 8; ++i)
    system.add_point({.position = {0.2 * (i / 4), 0.2 * (i / 2 % 2), 0.1 * (i % 2)}, .mass = 1.0});
  Rods body{.name = "body"};  // edges, and one diagonal of each face
  for (Index i = 0; i < 8; ++i)
    for (Index j = 0; j < i; ++j) {
      const Index apart = i ^ j;
      const bool is_edge = apart == 1 || apart == 2 || apart == 4, is_space = apart == 7;
      if (is_edge || (!is_space && (__builtin_popcount(static_cast<unsigned>(i)) & 1) == 0))
        body.pairs.push_back({j, i});
    }
  system.constraints = {
      body, Planes{.name = "ramp", .points = {0, 2, 4, 6}, .normal = Vector3{0.0, 0.0, 1.0}, .side = OneSide::AtLeast}};
  system.friction.push_back(Coulomb{.at = {"ramp"}, .coefficient = rough});
  system.add_gravity({g * std::sin(slope), 0.0, -g * std::cos(slope)});
  const double begin = processor_seconds();
  Simulation simulation(system, {}, {.threads = 1});
  double at[2];
  for (const int k : {0, 1}) {
    const Outcome outcome = simulation.advance_to(k == 0 ? t_settled : t_rest);
    if (!outcome.ok()) throw std::runtime_error(outcome.what);
    at[k] = simulation.positions()[0];
  }
  *seconds = processor_seconds() - begin;
  return (at[1] - at[0]) / (t_rest - t_settled);
}

#ifdef TANOR_HAS_MUJOCO
double creep_of_mujoco(double step, double* seconds) {
  std::ostringstream text;
  text.precision(17);
  text << "<mujoco><option timestep='" << step
       << "' cone='elliptic' solver='Newton' tolerance='1e-12' iterations='100' "
       << "gravity='" << g * std::sin(slope) << " 0 " << -g * std::cos(slope) << "'/><default><geom friction='" << rough
       << " 0 0' condim='3' solref='" << 2.0 * step << " 1' solimp='0.9999 0.9999 0.001'/></default><worldbody>"
       << "<geom type='plane' size='9 9 1'/><body pos='0 0 0.05'><freejoint/><geom type='box' size='0.1 0.1 0.05' "
       << "mass='8'/></body></worldbody></mujoco>";
  const MujocoModel model = read_mujoco(text.str());
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model.get()), mj_deleteData);
  const double begin = processor_seconds();
  double at[2];
  for (const int k : {0, 1}) {
    while (data->time < (k == 0 ? t_settled : t_rest) - 0.5 * step) mj_step(model.get(), data.get());
    at[k] = data->qpos[0];
  }
  *seconds = processor_seconds() - begin;
  return (at[1] - at[0]) / (t_rest - t_settled);
}
#endif

void measure_incline() {
  std::printf("| | creeps, m/s | processor time of %g s, ms |\n|---|--:|--:|\n", t_rest);
  double seconds = 0.0, creep = creep_of_tanor(&seconds);
  std::printf("| tanor | %.1e | %.3g |\n", creep, 1e3 * seconds);
#ifdef TANOR_HAS_MUJOCO
  for (const double step : {2e-3, 5e-4, 1e-4}) {
    creep = creep_of_mujoco(step, &seconds);
    std::printf("| MuJoCo %s, step %g | %.1e | %.3g |\n", mj_versionString(), step, creep, 1e3 * seconds);
  }
#endif
}

// ---- the net ----

/// A flat net between two corners on a diagonal; ropes are 2 % longer than the squares are wide.
System make_net(int side, bool of_ropes) {
  constexpr double spacing = 0.1;
  System system;
  std::vector<std::array<Index, 2>> pairs;
  for (Index i = 0; i < side * side; ++i) {
    system.positions.insert(system.positions.end(), {spacing * (i % side), spacing * (i / side), 0.0});
    system.masses.push_back(0.01);
    if (i % side > 0) pairs.push_back({i - 1, i});
    if (i >= side) pairs.push_back({i - side, i});
  }
  system.velocities.assign(system.positions.size(), 0.0);
  system.supports = {{.name = "corners", .points = {0, side * side - 1}}};
  if (of_ropes) {
    Ropes ropes{.name = "ropes", .length = 1.02 * spacing};
    for (const auto& [i, j] : pairs) ropes.paths.push_back({i, j});
    system.constraints = {ropes};
  } else {
    system.constraints = {Rods{.name = "rods", .pairs = pairs}};
  }
  system.add_gravity({0.0, 0.0, -g});
  return system;
}

void measure_net(int side, double seconds) {
  constexpr double every = 0.01;
  double of_rods = 0.0;
  for (const bool of_ropes : {false, true}) {
    const System system = make_net(side, of_ropes);
    const double budget = of_ropes ? seconds : 0.2 * seconds;
    Simulation simulation(system, {.rtol = 1e-8, .atol = 1e-9}, {.threads = 1, .contact = {.max_events = 10'000'000}});
    const double start = processor_seconds();
    double last = start;
    std::size_t events = 0;
    std::vector<double> all, smooth;
    const auto observe = [&](const MotionReport& report) {
      const double now = processor_seconds();
      all.push_back(now - last);
      if (report.contact_events.size() == events) smooth.push_back(now - last);
      events = report.contact_events.size();
      last = now;
      return now - start < budget;
    };
    std::printf("%s of %d x %d (%s)\n\n", of_ropes ? "ropes" : "rods", side, side,
                std::string(name_of(simulation.report().method)).c_str());
    if (of_ropes)
      std::printf(
          "| t, s | events | taut | least T, N | least gap, m | largest T gap, N m | processor time, s |\n"
          "|--:|--:|--:|--:|--:|--:|--:|\n");
    for (int k = 1; k <= 100 && processor_seconds() - start < budget; ++k) {
      const Outcome outcome = simulation.advance_to(every * k, observe);
      if (!outcome.ok()) {
        std::printf("ends at t = %.6g s: %s\n", simulation.time(), outcome.what.c_str());
        break;
      }
      if (!of_ropes) continue;
      const Ropes& ropes = std::get<Ropes>(system.constraints[0]);
      double least = std::numeric_limits<double>::infinity(), gap = least, product = 0.0;
      std::size_t taut = 0;
      const double* const r = simulation.positions().data();
      for (std::size_t i = 0; i < ropes.paths.size(); ++i) {
        const double T = -simulation.multipliers()[i],
                     own = ropes.length.constants[0] - norm_of(r + 3 * ropes.paths[i][0], r + 3 * ropes.paths[i][1]);
        least = std::min(least, T);
        gap = std::min(gap, own);
        product = std::max(product, std::abs(T * own));
        taut += T > 0.0;
      }
      std::printf("| %.4g | %zu | %zu | %.1e | %.1e | %.1e | %.1f |\n", simulation.time(), events, taut, least, gap,
                  product, processor_seconds() - start);
      std::fflush(stdout);
      last = processor_seconds();
    }
    const double step = median(all);
    std::printf("\n%zu steps to t = %.4g s, median %.3g ms; %zu of them without an event%s\n\n", all.size(),
                simulation.time(), 1e3 * step, smooth.size(),
                smooth.empty() ? "" : (", median " + std::to_string(1e3 * median(smooth)) + " ms").c_str());
    std::fflush(stdout);
    if (!of_ropes)
      of_rods = step;
    else
      std::printf("A step of ropes takes %.2f times one of rods.\n", step / of_rods);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "";
  if (what == "hub")
    measure_hub(argc > 2 ? std::atoi(argv[2]) : 5);
  else if (what == "incline")
    measure_incline();
  else if (what == "net")
    measure_net(argc > 2 ? std::atoi(argv[2]) : 100, argc > 3 ? std::atof(argv[3]) : 600.0);
  else
    return std::fprintf(stderr, "ropes hub [pairs] | incline | net [side] [seconds]\n"), 2;
  return 0;
}
