/// The program `mpirun -n P tanor-mpi run scene.json` runs one scene on P ranks. It reads the scenes of `tanor run`,
/// and writes the same summary.

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cli/command_line.hpp"
#include "cli/folder_lock.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "cli/output_times.hpp"
#include "mpi/program/division.hpp"
#include "mpi/program/together.hpp"
#include "mpi/program/trajectory.hpp"
#include "mpi/program/whole_run.hpp"
#include "mpi/tanor_mpi.hpp"
#include "report/output_file.hpp"
#include "report/summary.hpp"
#include "report/words.hpp"
#include "scene/cursor.hpp"
#include "scene/document.hpp"
#include "scene/scene.hpp"
#include "scene/text_file.hpp"

namespace tanor::mpi {

namespace {

namespace fs = std::filesystem;
using cli::ExitCode;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// One run, on this rank.
class Run {
 public:
  Run(MpiRanks& ranks, const cli::Options& options)
      : ranks_(ranks),
        options_(options),
        division_(ranks, options.scene, [&](const fs::path& name) { return read(name); }),
        scene_(division_.scene()),
        folder_(cli::choose_folder(options.out, name_run(options.scene))),
        checkpoint_(folder_ / cli::mpi_checkpoint_name),
        simulation_(cli::naming_file(options.scene, [&] {
          const RankSystem& part = division_.part();
          return Simulation(part.system, part.part, scene_.motion, scene_.solver, scene_.t_start);
        })) {
    take_folder();
    if (goes_on_) resume();
    setup_ = seconds_since(begin_);
  }

  ExitCode execute() {
    Outcome outcome = simulation_.outcome();
    if (outcome.ok() && !goes_on_) write_frame();
    while (outcome.ok() && simulation_.time() < scene_.t_end) {
      outcome = simulation_.advance_to(cli::next_output_time(simulation_.time(), scene_.output_every, scene_.t_end));
      if (outcome.ok()) write_frame();
    }
    ExitCode code = finish(outcome);
    MPI_Bcast(&code, sizeof code, MPI_BYTE, 0, ranks_.communicator());
    return code;
  }

 private:
  /// Reads a scene, and refuses what only `tanor run` can do. Ranks run side by side, so that each has one thread
  /// unless the environment asks for threads.
  scene::Scene read(const fs::path& name) const {
    if (options_.report) throw InputError("--report", "tanor-mpi makes no page; `tanor run` makes it");
    if (options_.checkpoint_every)
      throw InputError("--checkpoint-every", "tanor-mpi writes a checkpoint at every frame, see /motion/output_every");
    if (options_.overrides.trajectory)
      throw InputError("--trajectory", "tanor-mpi writes trajectory.npy alone; `tanor run` knows other formats");
    scene::Scene scene = cli::prepare(scene::load_moving_scene(name, options_.overrides));
    scene.t_end = cli::end_at_output(scene.t_end, scene.output_every);
    using When = scene::CertificatePolicy::When;
    if (scene.certificate.when == When::Always || scene.certificate.when == When::Every)
      throw InputError(scene.file.string() + ": /certificate",
                       "tanor-mpi makes one at the end alone; `tanor run` makes more");
    const scene::Document document(scene::read_text(scene.file), scene.file.string());
    const std::pair<const char*, bool> asked[] = {{"observe", !!scene::Cursor(document)["observe"]},
                                                  {"events", !scene.events.empty()}};
    for (const auto& [key, is_asked] : asked)
      if (is_asked) throw InputError(scene.file.string() + ": /" + key, "tanor-mpi has none; `tanor run` has");
    const bool has_own_wishes = scene.trajectory.files != scene::TrajectoryFormats().files ||
                                scene.trajectory.compression || !scene.output_points.empty();
    if (has_own_wishes && ranks_.rank() == 0)
      cli::print_message(scene.file.string() + ": warning: tanor-mpi writes all points, to trajectory.npy alone");
    if (scene.solver.threads == 0 && std::getenv("OMP_NUM_THREADS") == nullptr) scene.solver.threads = 1;
    return scene;
  }

  /// Makes the folder and locks it. If no run goes on there, removes what an earlier one has left, but not an
  /// interrupted one, so that a forgotten --resume does not cost a week. A run that ended, in whatever way, has a
  /// summary; a checkpoint that cannot be read is nobody's.
  void take_folder() {
    do_on_first(ranks_, [&] {
      report::make_folder(folder_);
      lock_.emplace(folder_, "run");
    });
    do_together(ranks_, [&] { cli::require_results_not_read(folder_, scene_.files); });
    do_on_first(ranks_, [&] { goes_on_ = options_.resume && fs::exists(checkpoint_); });
    MPI_Bcast(&goes_on_, sizeof goes_on_, MPI_BYTE, 0, ranks_.communicator());
    if (goes_on_) return;
    do_on_first(ranks_, [&] {
      if (options_.resume) cli::print_message("no checkpoint in " + folder_.string() + "; starts anew");
      const bool is_cut_off = fs::exists(checkpoint_) && !fs::exists(folder_ / report::summary_name);
      if (!options_.overwrite && is_cut_off && read_mark() == division_.mark())
        throw InputError(folder_.string(),
                         "has this run, which was interrupted; --resume goes on with it, --overwrite begins anew");
      cli::remove_results(folder_);
    });
  }

  std::optional<std::string> read_mark() const {
    try {
      return read_checkpoint_mark(checkpoint_);
    } catch (const InputError&) {
      return {};
    }
  }

  void resume() {
    do_together(ranks_, [&] {
      if (const std::string mark = read_checkpoint_mark(checkpoint_); mark != division_.mark())
        throw InputError(checkpoint_.string(), division_.name_difference(mark) + "; run without --resume");
    });
    read_checkpoint(ranks_, checkpoint_, division_.part(), division_.whole(), &simulation_);
    if (simulation_.time() > scene_.t_end)
      throw InputError(folder_.string(), fmt::format("the run already reached t = {}, its end was to be {}",
                                                     in_time(simulation_.time()), in_time(scene_.t_end)));
    do_on_first(ranks_, [&] { report::remove_file(folder_ / report::summary_name); });  // a new one comes at the end
    do_together(ranks_, [&] { times_ = read_frame_times(folder_, simulation_.time()); });
  }

  std::string in_time(double time) const {
    return report::with_unit(fmt::format("{:.9g}", time), division_.part().system.units.time);
  }

  void write_frame() {
    const auto begin = Clock::now();
    mpi::write_frame(ranks_, folder_, division_.part(), division_.num_points(), simulation_, &times_);
    write_checkpoint(ranks_, checkpoint_, division_.part(), division_.whole(), simulation_, division_.mark());
    output_ += seconds_since(begin);
  }

  /// Gathers the end of the run on the first rank, which certifies it and writes it down. Returns the exit code there.
  ExitCode finish(const Outcome& outcome) {
    const WholeRun whole(ranks_, division_, simulation_);
    if (ranks_.rank() != 0) return ExitCode::Done;
    const MotionReport& report = simulation_.report();
    report::RunFacts facts = report::facts_of(scene_, omp_get_max_threads(), outcome.ok() || report.steps > 0);
    facts.stopped_by = outcome.what;
    const Units& units = division_.part().system.units;
    facts.arrays = {{cli::mpi_trajectory_name, report::describe_array({"frame", "point", "x, y, z"}, units.length)},
                    {cli::mpi_times_name, report::describe_array({"frame"}, units.time)}};
    const auto write_summary = [&] {
      facts.certificates = facts.certificate ? 1 : 0;
      facts.wall = {seconds_since(begin_), setup_, output_};
      report::write_summary(folder_, facts, whole.end());
    };
    write_summary();  // the certificate, for which one rank holds the whole system, may end the program
    if (outcome.ok() && facts.wants_certificate) facts.certificate = prove(whole);
    if (facts.certificate) write_summary();
    if (!report.accuracy_warning.empty())
      cli::print_message(options_.scene.string() + ": warning: " + report.accuracy_warning);
    if (options_.json) cli::print_json_file(folder_ / report::summary_name);
    if (!outcome.ok())
      cli::print_message(fmt::format("stopped at t = {} of {}: {}; what was found until then is in {}",
                                     in_time(simulation_.time()), in_time(scene_.t_end), outcome.what,
                                     folder_.string()));
    else if (!options_.quiet)
      cli::print_message(fmt::format("t = {} reached in {} of {} on {}; results in {}", in_time(simulation_.time()),
                                     report::count_in_words(report.steps, "step"), name_of(report.method),
                                     report::count_in_words(ranks_.size(), "rank"), folder_.string()));
    const bool is_refuted = facts.certificate && !facts.certificate->passed();
    if (is_refuted) cli::print_message(facts.certificate->line());
    return outcome.ok() && !is_refuted ? ExitCode::Done : ExitCode::NoAnswer;
  }

  /// Returns nothing if one rank cannot hold the whole system, which is printed.
  std::optional<Certificate> prove(const WholeRun& whole) const {
    std::string why = "none of them has the whole system";
    try {
      if (division_.whole() != nullptr) return whole.prove();
    } catch (const std::bad_alloc&) {
      why = "the whole system does not fit into its memory";
    } catch (const std::length_error& error) {
      why = error.what();
    }
    cli::print_message(options_.scene.string() + ": warning: no certificate, which one rank makes: " + why);
    return {};
  }

  MpiRanks& ranks_;
  const cli::Options& options_;
  Clock::time_point begin_ = Clock::now();
  Division division_;
  const scene::Scene& scene_;
  fs::path folder_, checkpoint_;
  std::optional<cli::FolderLock> lock_;  ///< held by the first rank
  bool goes_on_ = false;
  Simulation simulation_;
  std::vector<double> times_;  ///< of the frames, s
  double setup_ = 0.0, output_ = 0.0;
};

/// Prints once what went wrong. An error that all ranks met ends them in order. An error of one rank also ends the
/// others, which wait for it.
ExitCode tell(const MpiRanks& ranks, const cli::Failure& failure) {
  constexpr double patience = 3.0;  // s
  MPI_Request all_are_here = MPI_REQUEST_NULL;
  MPI_Ibarrier(ranks.communicator(), &all_are_here);
  const auto begin = Clock::now();
  int done = 0;
  while (done == 0 && seconds_since(begin) < patience) {
    MPI_Test(&all_are_here, &done, MPI_STATUS_IGNORE);
    usleep(1000);
  }
  if (done != 0 && ranks.rank() != 0) return failure.code;
  cli::print_message(done != 0 ? failure.message : fmt::format("rank {}: {}", ranks.rank(), failure.message));
  if (done == 0) MPI_Abort(ranks.communicator(), static_cast<int>(failure.code));
  return failure.code;
}

/// Prints the help of tanor, and what is different here.
ExitCode print_help(const cli::Options& options) {
  const ExitCode code = cli::execute_help(options);
  if (!options.json) {
    cli::print_heading("On several ranks");
    cli::print_lines(
        "  mpirun -n 4 tanor-mpi run melt.json\n"
        "    every rank reads the scene and moves its part\n"
        "  mpirun -n 4 tanor-mpi run 'melt-{rank}.json'\n"
        "    each rank reads and moves a scene of its own, melt-0.json to melt-3.json\n"
        "  The other commands are those of tanor; docs/parallel.md tells what differs.\n");
  }
  return code;
}

/// Executes on the ranks what a command line asks for.
ExitCode execute(MpiRanks& ranks, const cli::Request& request) {
  const auto& [command, options] = request;
  if (command == "run") return Run(ranks, options).execute();
  if (command == "help") return print_help(options);
  if (command == "--version") return cli::execute_version(options);
  if (command == "--methods") return cli::execute_methods(options);
  throw InputError("", "tanor-mpi knows `run` alone; the other commands are those of tanor");
}

ExitCode run_command(MpiRanks& ranks, int argc, const char* const* argv) {
  try {
    const cli::Request request = cli::parse_command_line(argc, argv);
    if (ranks.rank() != 0 && std::freopen("/dev/null", "w", stdout) == nullptr) return ExitCode::MachineFailure;
    return execute(ranks, request);
  } catch (...) {
    return tell(ranks, cli::describe_current_exception());
  }
}

}  // namespace

}  // namespace tanor::mpi

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  int code = 0;
  {
    tanor::MpiRanks ranks(MPI_COMM_WORLD);
    code = static_cast<int>(tanor::mpi::run_command(ranks, argc, argv));
  }
  MPI_Finalize();
  return code;
}
