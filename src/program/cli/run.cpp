#include <fmt/format.h>

#include <array>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <utility>

#include <tanor/motion.hpp>

#include "base/text.hpp"
#include "cli/command_line.hpp"
#include "cli/cost.hpp"
#include "cli/folder_lock.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "cli/output_times.hpp"
#include "cli/process.hpp"
#include "cli/run_folder.hpp"
#include "report/html_page.hpp"
#include "report/progress.hpp"
#include "report/shared_parts.hpp"
#include "report/words.hpp"
#include "scene/memory.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {
using namespace detail;
using report::with_unit;

namespace fs = std::filesystem;

namespace {

/// Refuses to replace an interrupted run, so that a forgotten --resume does not cost a week.
void require_no_interrupted(const RunPlan& plan, double t_start, const std::string& unit) {
  std::optional<report::Checkpoint> before;
  try {
    before = report::read_checkpoint(plan.directory, plan.fingerprint);
  } catch (const InputError&) {  // the checkpoint is of another run, or damaged
  }
  if (before && before->time > t_start && before->time < before->t_end) {
    const auto [time, end] = texts_apart(std::array{before->time, before->t_end});
    throw InputError(plan.directory.string(),
                     fmt::format("has this run, which was interrupted at t = {} of {}; --resume goes on with it, "
                                 "--overwrite begins anew",
                                 with_unit(time, unit), with_unit(end, unit)));
  }
}

/// Plans a run. A folder that exists is locked before its checkpoint is read.
RunPlan plan_run(const Options& options, const scene::Scene& scene, RunPlan::Clock::time_point begin) {
  RunPlan plan;
  plan.begin = begin;
  plan.directory = choose_folder(options.out, scene.file);
  const std::chrono::duration<double> checkpoint_every(options.checkpoint_every.value_or(60.0));
  plan.checkpoint_every = std::chrono::duration_cast<RunPlan::Clock::duration>(checkpoint_every);
  plan.has_html_page = options.report && report::has_html_page();
  plan.fingerprint = report::make_fingerprint(scene.files, scene.system, scene.motion);
  plan.scene_checksum = report::make_scene_checksum(plan.fingerprint);
  if (!fs::exists(plan.directory)) return plan;
  require_results_not_read(plan.directory, scene.files);
  plan.lock = std::make_unique<FolderLock>(plan.directory, "run");
  if (!options.resume) {
    if (!options.overwrite) require_no_interrupted(plan, scene.t_start, scene.system.units.time);
    return plan;
  }
  plan.before = report::read_checkpoint(plan.directory, plan.fingerprint);
  if (plan.before && plan.before->time > scene.t_end) {
    const auto [time, end] = texts_apart(std::array{plan.before->time, scene.t_end});
    throw InputError(plan.directory.string(),
                     fmt::format("the run already reached t = {}, its end was to be {}",
                                 with_unit(time, scene.system.units.time), with_unit(end, scene.system.units.time)));
  }
  return plan;
}

/// Makes the simulation at the scene's start, or where an interrupted run stopped. Takes the scene's system.
Simulation make_simulation(scene::Scene* scene, const RunPlan& plan) {
  Simulation simulation = naming_file(
      scene->file, [&] { return Simulation(std::move(scene->system), scene->motion, scene->solver, scene->t_start); });
  for (const Observable& observable : scene->observables) simulation.add_observable(observable);
  naming_file(scene->file, [&] { add_events(*scene, &simulation); });
  if (plan.before) {
    naming_file(plan.directory / report::checkpoint_name, [&] { simulation.restore(plan.before->state); });
  }
  return simulation;
}

/// Refuses a run that surely does not fit into memory, before its folder is touched.
void require_memory(const scene::Scene& scene, const Simulation& simulation) {
  constexpr double most_overrated = 1.4;  // largest ratio of prediction to use, src/program/cli/cost.cpp
  const bool is_certified = scene.certificate.when != scene::CertificatePolicy::When::Off;
  const std::size_t num_points = simulation.positions().size() / 3;
  const Method method = simulation.report().method;
  const double needed = predict_run({simulation.plan(), num_points, is_certified, scene.motion}, method).bytes;
  const double there = scene::measure_memory();
  if (needed <= most_overrated * there) return;
  throw std::length_error(
      fmt::format("a run with {} needs about {:.3g} GB of memory; there are {:.3g} GB for this program (`tanor info` "
                  "names other methods)",
                  name_of(method), 1e-9 * needed, 1e-9 * there));
}

/// Throws unless this program can write the formats of the frames and has room for all of them.
void require_output(const scene::Scene& scene, std::size_t num_points) {
  const double frames = scene.output_every > 0.0 ? (scene.t_end - scene.t_start) / scene.output_every + 2.0 : 2.0;
  try {
    report::require_formats(choose_trajectory(scene), num_points, frames);
  } catch (const InputError& error) {
    throw InputError(scene.file.string() + ": " + error.where(), error.what());
  }
}

/// The reason why a run ended; `why` is empty if it reached its end.
struct Ending {
  ExitCode code = ExitCode::Done;
  std::string why;
  bool is_between_steps = true;  ///< the simulation stands at a state of the motion; no exception came out of it
};

/// True if the answer after this step is to be certified. The last one is in any case.
bool is_due(const scene::CertificatePolicy& policy, std::size_t step) {
  using When = scene::CertificatePolicy::When;
  return policy.when == When::Always ||
         (policy.when == When::Every && step % static_cast<std::size_t>(policy.every) == 0);
}

/// Certifies the present state. Returns why that failed, or nothing if it passed.
std::string prove(Simulation* simulation, RunFolder* folder) {
  const Certificate certificate = simulation->certify();
  folder->take_certificate(certificate);
  return certificate.passed() ? std::string() : certificate.line();
}

/// Advances from output time to output time until t_end, a failure, or a signal. Passages before the `first_passage`
/// are those of the run that this one goes on from.
Ending advance(const scene::Scene& scene, std::size_t first_passage, Simulation* simulation, RunFolder* folder,
               report::Progress* progress) {
  std::string not_proven, why;
  double target = 0.0;
  const auto observe = [&](const MotionReport& report) {
    progress->update(report);
    folder->take_step(report, simulation->time() < target ? simulation : nullptr);
    if (is_due(scene.certificate, report.steps)) not_proven = prove(simulation, folder);
    return not_proven.empty() && !caught_interrupt();
  };
  const auto is_stopped = [&] {
    const std::span<const Passage> all = simulation->passages().subspan(first_passage);
    const auto stop = std::ranges::find(all.rbegin(), all.rend(), EventAction::Stop, &Passage::action);
    if (stop == all.rend() || stop->time != simulation->time()) return false;
    why = fmt::format("the event \"{}\" stops the run", stop->name);
    return true;
  };
  while (!is_stopped() && simulation->time() < scene.t_end) {
    const double begin = simulation->time();
    target = next_output_time(begin, scene.output_every, scene.t_end);
    const Outcome outcome = simulation->advance_to(target, observe);
    if (outcome.ok() && not_proven.empty() && simulation->time() < target && caught_interrupt())
      folder->write_stop(*simulation);
    else if (simulation->time() > begin)
      folder->write_frame(*simulation);
    if (!outcome.ok()) return {ExitCode::NoAnswer, outcome.what};
    if (!not_proven.empty()) return {ExitCode::NoAnswer, not_proven};
    if (const auto interrupt = caught_interrupt(); interrupt && simulation->time() < scene.t_end) {
      return {interrupt->code, fmt::format("{} came", interrupt->name)};
    }
  }
  if (scene.certificate.when != scene::CertificatePolicy::When::Off) not_proven = prove(simulation, folder);
  if (!not_proven.empty()) return {ExitCode::NoAnswer, not_proven};
  return {ExitCode::Done, why};
}

/// Runs the start and all that follows; trouble of any kind is an ending.
Ending simulate(const scene::Scene& scene, bool is_new, Simulation* simulation, RunFolder* folder,
                report::Progress* progress) {
  try {
    if (!simulation->outcome().ok()) return {ExitCode::NoAnswer, simulation->outcome().what};
    const std::size_t first_passage = simulation->passages().size();
    if (is_new) {
      // The state of a frame is the one behind the events at its time.
      const Outcome begun = simulation->advance_to(simulation->time());
      folder->write_frame(*simulation);
      if (!begun.ok()) return {ExitCode::NoAnswer, begun.what};
    } else {
      folder->take_resumed(*simulation);
    }
    return advance(scene, first_passage, simulation, folder, progress);
  } catch (...) {
    const Failure failure = describe_current_exception();
    return {failure.code, failure.message, false};
  }
}

/// Finishes the folder and returns the page of the run. After a failure of the machine this is only tried.
std::string finish(const Ending& ending, Simulation& simulation, RunFolder* folder) {
  try {
    std::string page = folder->finish(simulation, ending.why, ending.is_between_steps);
    if (ending.code == ExitCode::NoAnswer || (ending.code == ExitCode::Done && !ending.why.empty())) folder->give_up();
    return page;
  } catch (const std::exception&) {
    if (ending.code != ExitCode::MachineFailure) throw;
    return {};
  }
}

/// Prints redundant equations, which are no fault but should be known.
void tell_redundancy(const Options& options, Simulation& simulation) {
  if (const std::string redundancy = report::describe_redundancy(simulation.rank()); !redundancy.empty())
    print_message(options.scene.string() + ": " + redundancy);
}

std::string describe_end(const Ending& ending, const Simulation& simulation, double t_end, const fs::path& directory) {
  const MotionReport& report = simulation.report();
  const std::string& unit = simulation.system().units.time;
  if (ending.code != ExitCode::Done) {
    const bool can_go_on = caught_interrupt().has_value();
    const std::string left = holds_results(directory) ? "what was found until then is in " + typed(directory)
                                                      : "nothing of it is left in " + typed(directory);
    const auto [time, end] = texts_apart(std::array{simulation.time(), t_end});
    return fmt::format("stopped at t = {} of {}: {}; {}{}", with_unit(time, unit), with_unit(end, unit), ending.why,
                       left, can_go_on ? "; the same command with --resume goes on" : "");
  }
  return fmt::format("t = {} reached in {} of {}{}; results in {}", with_unit(detail::text(simulation.time()), unit),
                     report::count_in_words(report.steps, "step"), name_of(report.method),
                     ending.why.empty() ? "" : ", where " + ending.why, typed(directory));
}

}  // namespace

ExitCode execute_run(const Options& options) {
  const auto begin = RunPlan::Clock::now();
  scene::Scene scene = prepare(scene::load_moving_scene(options.scene, options.overrides));
  scene.t_end = end_at_output(scene.t_end, scene.output_every);
  require_output(scene, scene.system.num_points());
  RunPlan plan = plan_run(options, scene, begin);
  Simulation simulation = make_simulation(&scene, plan);
  naming_file(options.scene, [&] { require_memory(scene, simulation); });

  // Nothing was written so far.
  RunFolder folder(&plan, scene, simulation);
  if (options.resume && !plan.before) print_message("no checkpoint in " + typed(plan.directory) + "; starts anew");
  if (options.report && !plan.has_html_page)
    print_message("this tanor was built without node and npm: there is no report.html, report.txt has the numbers",
                  Tone::Warning);
  catch_interrupts();
  report::Progress progress(report::Progress::choose_style(options.quiet), simulation.time(), scene.t_end,
                            simulation.system().units.time);
  const Ending ending = simulate(scene, !plan.before, &simulation, &folder, &progress);
  progress.end();
  if (simulation.outcome().ok() && !options.quiet) tell_redundancy(options, simulation);
  const std::string page = finish(ending, simulation, &folder);
  if (const std::string& warning = simulation.report().accuracy_warning; !warning.empty())
    print_message(options.scene.string() + ": warning: " + warning, Tone::Warning);

  if (const std::string several = report::describe_several(simulation.report().friction, simulation.system().units);
      !several.empty())
    print_message(options.scene.string() + ": " + several, Tone::Warning);
  if (options.json) {
    print_json_file(plan.directory / report::summary_name);
  } else if (!options.quiet) {
    print_page(page);
    if (options.verbose && folder.certificate()) print_checks(*folder.certificate(), true);
  }
  if (ending.code != ExitCode::Done || !options.quiet) {
    print_message(describe_end(ending, simulation, scene.t_end, plan.directory),
                  ending.code == ExitCode::Done ? Tone::Note : Tone::Error);
  }
  return ending.code;
}

}  // namespace tanor::cli
