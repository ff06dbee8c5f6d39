#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "base/text.hpp"
#include "scene/entries.hpp"
#include "scene/parts.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

constexpr double most_steps = 1e12, most_frames = 1e6;  // more would not end, or fill the disk

void apply(const Overrides& overrides, Scene* scene) {
  MotionOptions& options = scene->motion;
  if (overrides.method) {
    try {
      options.method = method_from_name(*overrides.method);
    } catch (const InputError& error) {
      throw InputError("--method", error.what());
    }
  }
  // Tolerances replace the scene's step; only the method "auto" can follow them.
  const bool has_tolerance = overrides.rtol || overrides.atol;
  if (has_tolerance && options.method == Method::Auto) options.step = 0.0;
  options.step = overrides.step.value_or(options.step);
  options.max_step = overrides.max_step.value_or(options.max_step);
  options.rtol = overrides.rtol.value_or(options.rtol);
  options.atol = overrides.atol.value_or(options.atol);
  scene->t_end = overrides.t_end.value_or(scene->t_end);
  scene->trajectory.files = overrides.trajectory.value_or(scene->trajectory.files);
}

std::string describe_limit(const Scene& scene, double most, std::string_view what) {
  const double duration = scene.t_end - scene.t_start;
  const std::string_view name = scene.t_start == 0.0 ? "t_end" : "(t_end - t_start)";
  return fmt::format("at least {}/{:.0e} = {} ({} = {}, {:.0e} {} at most)", name, most, detail::text(duration / most),
                     name, detail::text(duration), most, what);
}

/// Checks that the end can be reached, with output that can be stored.
void check_counts(const Cursor& motion, const Overrides& overrides, const Scene& scene) {
  if (!scene.has_end()) return;
  const double duration = scene.t_end - scene.t_start;
  if (!(duration > 0.0)) {
    const auto [end, start] = texts_apart(std::array{scene.t_end, scene.t_start});
    const std::string wanted = fmt::format("a time after t_start = {}", start);
    if (overrides.t_end) throw InputError("--t-end", fmt::format("found number {}, wanted {}", end, wanted));
    motion["t_end"].fail(wanted);
  }
  struct Step {
    const char *key, *option;
    double size;
    bool is_override;
  };
  for (const Step& step : {Step{"step", "--step", scene.motion.step, overrides.step.has_value()},
                           Step{"max_step", "--max-step", scene.motion.max_step, overrides.max_step.has_value()}}) {
    if (!(step.size > 0.0 && duration / step.size > most_steps)) continue;
    const std::string wanted = describe_limit(scene, most_steps, "steps");
    if (step.is_override)
      throw InputError(step.option, fmt::format("found number {}, wanted {}", detail::text(step.size), wanted));
    motion[step.key].fail(wanted);
  }
  if (scene.output_every > 0.0 && duration / scene.output_every > most_frames) {
    motion["output_every"].fail(describe_limit(scene, most_frames, "frames"));
  }
}

CertificatePolicy read_certificate(const Cursor& certificate) {
  using When = CertificatePolicy::When;
  constexpr int most = std::numeric_limits<int>::max();
  if (certificate.is_object())
    return {When::Every, static_cast<int>(certificate.object({"every"})["every"].integer(1, most))};
  if (certificate && !certificate.is_string()) certificate.fail(R"("off", "final", "always" or {"every": N})");
  return {certificate.choice<When>({{"off", When::Off}, {"final", When::Final}, {"always", When::Always}}, When::Final),
          0};
}

/// Words of linear solvers that are read for one version, with a line that names the present word.
constexpr EnumName<LinearSolver> old_words[]{
    {LinearSolver::General, "sparse"},  {LinearSolver::Paths, "path"},      {LinearSolver::Trees, "tree"},
    {LinearSolver::Batches, "batched"}, {LinearSolver::Batches, "bundles"}, {LinearSolver::ClosedForm, "pointwise"}};

/// Reads the linear solver. Its old name "way" and the old words are accepted for one version.
LinearSolver read_linear_solver(const Cursor& solver, Scene* scene) {
  const Cursor old = solver["way"];
  if (old && solver["linear_solver"]) old.complain("found beside linear_solver, which is its new name");
  if (old) scene->old_names.push_back("/solver/way: its name is linear_solver");
  const Cursor kind = old ? old : solver["linear_solver"];
  for (const auto& [named, word] : old_words) {
    if (!kind || !kind.says(word)) continue;
    scene->old_names.push_back(fmt::format("{}: \"{}\" is \"{}\"", kind.pointer(), word, name_of(named)));
    return named;
  }
  return kind.choice<LinearSolver>(scene->solver.linear_solver);
}

/// Reads one word, or a list of words. With an empty list nothing is written.
std::vector<TrajectoryFormat> read_trajectory_formats(const Cursor& words) {
  if (!words.is_list()) return {words.choice<TrajectoryFormat>()};
  std::vector<TrajectoryFormat> formats;
  for (const Cursor word : words.list("a list of formats")) {
    const auto format = word.choice<TrajectoryFormat>();
    if (std::ranges::find(formats, format) != formats.end())
      word.complain(fmt::format("found {} twice, wanted formats that differ", name_of(format)));
    formats.push_back(format);
  }
  return formats;
}

std::vector<Index> read_output_points(const Cursor& cursor, const Context& context) {
  std::vector<Index> points = context.points(cursor);
  if (points.empty()) cursor.fail("one point at least");
  std::vector<Index> sorted = points;
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
    cursor.complain(fmt::format("names point {} twice", *twice));
  return points;
}

}  // namespace

void read_motion(const Cursor& motion, const Context& context, const Overrides& overrides, Scene* scene) {
  motion.object(keys_of("motion"));
  MotionOptions& options = scene->motion;
  std::vector<std::pair<std::string_view, Method>> names;
  for (const MethodTraits& each : methods()) names.emplace_back(each.name, each.method);
  options.method = motion["method"].choice<Method>(names, options.method);
  if (!motion["step"].is_null()) options.step = motion["step"].positive(0.0);
  if (!motion["max_step"].is_null()) options.max_step = motion["max_step"].positive(0.0);
  options.rtol = motion["rtol"].positive(options.rtol);
  options.atol = motion["atol"].positive(options.atol);
  options.order = static_cast<int>(motion["order"].integer(0, 24, options.order));
  options.spectral_radius = motion["spectral_radius"].number(options.spectral_radius);
  options.stabilisation = motion["stabilisation"].choice<Stabilisation>(options.stabilisation);
  options.start = motion["start"].choice<StartMode>(options.start);

  scene->t_start = motion["t_start"].number(0.0);
  scene->t_end = motion["t_end"].number(scene->t_end);
  scene->output_every = motion["output_every"].positive(0.0);
  if (const Cursor points = motion["output_points"]; points && !points.says("all"))
    scene->output_points = read_output_points(points, context);
  if (const Cursor formats = motion["trajectory"]) scene->trajectory.files = read_trajectory_formats(formats);
  scene->trajectory.compression = motion["compression"].boolean(scene->trajectory.compression);

  apply(overrides, scene);
  check_counts(motion, overrides, *scene);
}

void read_solver(const Cursor& solver, const Overrides& overrides, Scene* scene) {
  solver.object(keys_of("solver"));
  scene->solver.form = solver["form"].choice<Form>(scene->solver.form);
  scene->solver.linear_solver = read_linear_solver(solver, scene);
  scene->solver.ordering = solver["ordering"].choice<Ordering>(scene->solver.ordering);
  scene->solver.friction = solver["friction"].choice<FrictionMethod>(scene->solver.friction);
  scene->solver.reuse = solver["reuse"].boolean(scene->solver.reuse);
  scene->solver.exact = solver["exact"].boolean(scene->solver.exact);
  if (const Cursor contact = solver["contact"]) {
    contact.object(keys_of("contact"));
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    const auto read = [&](const char* key, int* limit) {
      *limit = static_cast<int>(contact[key].integer(1, most, *limit));
    };
    read("max_at_one_instant", &scene->solver.contact.max_at_one_instant);
    read("max_events", &scene->solver.contact.max_events);
  }
  const int threads = static_cast<int>(solver["threads"].integer(0, most_threads, 0));
  scene->solver.threads = overrides.threads.value_or(threads);
  scene->certificate = read_certificate(solver["certificate"]);
}

}  // namespace tanor::scene
