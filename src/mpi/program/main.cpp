/// mpirun -n P tanor-mpi run scene.json: one scene on P ranks. It reads the scenes of `tanor run`, and writes the same
/// summary.

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <optional>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "cli/output_times.hpp"
#include "mpi/program/trajectory.hpp"
#include "mpi/program/whole_run.hpp"
#include "mpi/tanor_mpi.hpp"
#include "report/output_file.hpp"
#include "report/summary.hpp"
#include "scene/scene.hpp"

namespace tanor::mpi {

namespace {

namespace fs = std::filesystem;
using cli::ExitCode;
using Clock = std::chrono::steady_clock;

constexpr const char* checkpoint_name = "checkpoint.mpi";

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Ranks are what runs side by side, unless the environment asks for threads.
void choose_threads(scene::Scene* scene) {
  if (scene->solver.threads == 0) scene->solver.threads = std::getenv("OMP_NUM_THREADS") != nullptr ? 0 : 1;
}

/// One run, on this rank.
class Run {
 public:
  Run(MpiRanks& ranks, const cli::RunOptions& options)
      : ranks_(ranks),
        options_(options),
        scene_(cli::prepare(scene::load_moving_scene(options.scene, options.overrides))),
        folder_(cli::choose_folder(options.out, scene_)) {
    choose_threads(&scene_);
    refuse_what_is_missing();
    part_ = take_part(scene_.system, assign_owners(scene_.system, ranks.size()), ranks);
    simulation_.emplace(cli::naming_file(
        scene_.file, [&] { return Simulation(part_.system, part_.part, scene_.motion, scene_.solver); }));
    if (ranks.rank() == 0) fs::create_directories(folder_);
    MPI_Barrier(ranks.communicator());
    trajectory_.emplace(ranks, folder_, part_, scene_.system.num_points());
    setup_ = seconds_since(begin_);
  }

  ExitCode execute() {
    const bool goes_on = options_.resume && fs::exists(folder_ / checkpoint_name);
    if (goes_on) {
      read_checkpoint(ranks_, folder_ / checkpoint_name, part_, scene_.system.num_points(), &*simulation_);
      trajectory_->keep_until(simulation_->time());
    }
    Outcome outcome = simulation_->outcome();
    if (outcome.ok() && !goes_on) write_frame();
    while (outcome.ok() && simulation_->time() < scene_.t_end) {
      const double next = cli::next_output_time(simulation_->time(), scene_.output_every, scene_.t_end);
      outcome = simulation_->advance_to(next);
      if (outcome.ok()) write_frame();
    }
    finish(outcome);
    return outcome.ok() ? ExitCode::Done : ExitCode::NoAnswer;
  }

 private:
  void refuse_what_is_missing() const {
    using When = scene::CertificatePolicy::When;
    const When when = scene_.certificate.when;
    if (ranks_.size() > 1 && (when == When::Always || when == When::Every))
      throw InputError(scene_.file.string() + ": /certificate", "is found on one rank alone; `tanor run` finds it");
  }

  void write_frame() {
    const auto begin = Clock::now();
    trajectory_->write_frame(*simulation_);
    write_checkpoint(ranks_, folder_ / checkpoint_name, part_, scene_.system.num_points(), *simulation_);
    output_ += seconds_since(begin);
  }

  void finish(const Outcome& outcome) {
    const WholeRun whole(ranks_, scene_.system, part_, *simulation_);
    if (ranks_.rank() != 0) return;
    report::RunFacts facts;
    facts.scene = scene_.name;
    facts.source = scene_.source;
    facts.threads = scene_.solver.threads > 0 ? scene_.solver.threads : omp_get_max_threads();
    facts.t_end = scene_.t_end;
    facts.has_started = outcome.ok() || simulation_->report().steps > 0;
    facts.wall = {seconds_since(begin_), setup_, output_};
    report::write_summary(folder_, facts, whole.end());
    if (const std::string& warning = simulation_->report().accuracy_warning; !warning.empty())
      cli::print_message(options_.scene.string() + ": warning: " + warning);
    const std::string end = outcome.ok()
                                ? fmt::format("t = {} s reached in {} steps of {} on {} ranks; results in {}",
                                              simulation_->time(), simulation_->report().steps,
                                              name_of(simulation_->report().method), ranks_.size(), folder_.string())
                                : fmt::format("stopped at t = {} s of {} s: {}; what was found until then is in {}",
                                              simulation_->time(), scene_.t_end, outcome.what, folder_.string());
    if (!outcome.ok() || !options_.quiet) cli::print_message(end);
  }

  MpiRanks& ranks_;
  const cli::RunOptions& options_;
  Clock::time_point begin_ = Clock::now();
  scene::Scene scene_;
  fs::path folder_;
  RankSystem part_;
  std::optional<Simulation> simulation_;
  std::optional<Trajectory> trajectory_;
  double setup_ = 0.0, output_ = 0.0;
};

/// Says once what went wrong. What all ranks met ends them in order; what one rank met alone ends the others, too,
/// which wait for it.
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

[[noreturn]] void refuse_command() {
  throw InputError("", "tanor-mpi knows `run` alone; the other commands are those of tanor");
}

/// The ranks of this program, while it runs.
MpiRanks* all_ranks = nullptr;

ExitCode run_command(int argc, const char* const* argv) {
  try {
    const std::function<ExitCode()> command = cli::parse_command_line(argc, argv);
    if (all_ranks->rank() != 0 && std::freopen("/dev/null", "w", stdout) == nullptr) return ExitCode::MachineFailure;
    return command();
  } catch (...) {
    return tell(*all_ranks, cli::describe_current_exception());
  }
}

}  // namespace

}  // namespace tanor::mpi

// What the table of commands executes here.
namespace tanor::cli {

ExitCode execute(const RunOptions& options) {
  return mpi::Run(*mpi::all_ranks, options).execute();
}
ExitCode execute(const SolveOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const ForcesOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const InfoOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const CheckOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const ErrorTimeOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const EquilibriumCommand&) {
  mpi::refuse_command();
}
ExitCode execute(const ModesCommand&) {
  mpi::refuse_command();
}
ExitCode execute(const SelftestOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const ViewOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const PictureOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const ManualOptions&) {
  mpi::refuse_command();
}
ExitCode execute(const CompletionOptions&) {
  mpi::refuse_command();
}

}  // namespace tanor::cli

int main(int argc, char** argv) {
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  int code = 0;
  {
    tanor::MpiRanks ranks(MPI_COMM_WORLD);
    tanor::mpi::all_ranks = &ranks;
    code = static_cast<int>(tanor::mpi::run_command(argc, argv));
  }
  MPI_Finalize();
  return code;
}
