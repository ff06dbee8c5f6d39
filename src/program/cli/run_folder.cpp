#include "cli/run_folder.hpp"

#include <algorithm>
#include <utility>

#include "cli/output_folder.hpp"
#include "cli/process.hpp"
#include "report/html_page.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"
#include "report/progress.hpp"
#include "report/recording.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

namespace {

double seconds_since(RunPlan::Clock::time_point begin) {
  return std::chrono::duration<double>(RunPlan::Clock::now() - begin).count();
}

report::RunFacts collect_facts(const RunPlan& plan, const scene::Scene& scene, const Simulation& simulation) {
  report::RunFacts facts = report::facts_of(scene, count_threads(), simulation.outcome().ok());
  facts.scene_checksum = plan.scene_checksum;
  facts.cell = simulation.system().cell;
  return facts;
}

std::unique_ptr<FolderLock> take_folder(RunPlan* plan) {
  if (!plan->lock) {
    report::make_folder(plan->directory);
    plan->lock = std::make_unique<FolderLock>(plan->directory, "run");
  }
  if (!plan->before) remove_results(plan->directory);
  return std::move(plan->lock);
}

report::Trajectory open_trajectory(const RunPlan& plan, const scene::Scene& scene, Simulation& simulation) {
  report::TrajectoryOptions options = choose_trajectory(scene);
  options.cell = simulation.system().cell;
  options.units = simulation.system().units;
  const std::span<const Observed> observed = simulation.observe(false);
  options.observables.assign(observed.begin(), observed.end());
  if (plan.before) return {plan.directory, simulation.system(), options, plan.before->trajectory};
  return {plan.directory, simulation.system(), options};
}

/// Returns the friction forces [3n], N; empty if the system has no friction.
std::vector<double> find_friction(Simulation& simulation) {
  return simulation.system().friction.empty() ? std::vector<double>() : simulation.friction_forces();
}

/// A checkpoint may take one part in this many of the run's time. Replacing a file can wait for the disk
/// (milliseconds), which would be most of the time of a small system with many frames.
constexpr int publishing_share = 20;  // one twentieth
/// The page of a running simulation has a share likewise. It need not be newer than a second.
constexpr int page_share = 50;
constexpr std::chrono::milliseconds shortest_page_interval(1000);

}  // namespace

report::TrajectoryOptions choose_trajectory(const scene::Scene& scene) {
  return {.points = scene.output_points,
          .formats = scene.trajectory,
          .cell = scene.system.cell,
          .title = scene.name,
          .t_start = scene.t_start};
}

RunFolder::RunFolder(RunPlan* plan, const scene::Scene& scene, Simulation& simulation)
    : directory_(plan->directory),
      lock_(take_folder(plan)),
      earlier_(plan->before ? plan->before->wall : report::WallTimes()),
      begin_(plan->begin),
      checkpoint_every_(plan->checkpoint_every),
      facts_(collect_facts(*plan, scene, simulation)),
      trajectory_(open_trajectory(*plan, scene, simulation)),
      due_(RunPlan::Clock::now() + plan->checkpoint_every),
      setup_(seconds_since(plan->begin)) {
  if (plan->before) checkpoint_ = std::move(*plan->before);
  checkpoint_.scene = plan->fingerprint;
  checkpoint_.t_end = scene.t_end;
  if (plan->has_html_page)
    recording_.emplace(
        simulation.system(), scene.output_points,
        report::OutputTimes{
            .start = scene.t_start, .duration = scene.t_end - scene.t_start, .every = scene.output_every});
}

void RunFolder::append_frame(Simulation& simulation) {
  const auto begin = RunPlan::Clock::now();
  const std::vector<double> friction = find_friction(simulation);
  trajectory_.write_frame(simulation, friction);
  if (!recording_) return;
  recording_->take_frame(simulation, friction, simulation.observe(false));
  if (begin >= next_page_) show(simulation);
}

void RunFolder::write_frame(Simulation& simulation) {
  const auto begin = RunPlan::Clock::now();
  append_frame(simulation);
  last_frame_ = simulation.time();
  if (begin >= next_publication_) publish(simulation);
  output_ += seconds_since(begin);
}

void RunFolder::write_stop(Simulation& simulation) {
  const auto begin = RunPlan::Clock::now();
  publish(simulation);  // marks the end of the frames that are kept
  append_frame(simulation);
  output_ += seconds_since(begin);
}

void RunFolder::take_resumed(Simulation& simulation) {
  facts_.t_resumed = simulation.time();
  if (!recording_) return;
  report::read_recording(directory_, checkpoint_.scene, simulation, &*recording_);
  const Solution now = simulation.solution();
  if (now.outcome.ok())
    recording_->take_frame(simulation.system(), now, find_friction(simulation), simulation.observe(false));
}

/// Removes what was written just now if another folder has taken the place of ours.
void RunFolder::remove_from_strange_folder(const char* file) const {
  std::error_code failed;
  if (!is_in_place()) std::filesystem::remove(directory_ / file, failed);
}

bool RunFolder::is_in_place() const {
  return lock_->is_in_place();
}

/// Throws if somebody has put another folder in the place of ours, which stays as it is.
void RunFolder::require_folder(const std::string& file) const {
  if (!is_in_place()) throw report::WriteError((directory_ / file).string(), "its folder is gone");
}

void RunFolder::show(const Simulation& simulation) {
  require_folder(report::html_page_name);
  const auto begin = RunPlan::Clock::now();
  facts_.wall = measure_wall();
  facts_.tensions = report::choose_tension_scale(recording_->tensions());
  report::write_running_page(directory_, facts_, simulation, *recording_);
  remove_from_strange_folder(report::html_page_name);
  const auto end = RunPlan::Clock::now();
  next_page_ = end + std::max<RunPlan::Clock::duration>(page_share * (end - begin), shortest_page_interval);
}

std::string RunFolder::finish(Simulation& simulation, const std::string& stopped_by, bool can_go_on) {
  require_folder(report::summary_name);
  const auto begin = RunPlan::Clock::now();
  if (can_go_on && last_frame_ == simulation.time())
    publish(simulation);
  else
    trajectory_.synchronize();
  output_ += seconds_since(begin);
  facts_.wall = measure_wall();
  facts_.stopped_by = stopped_by;
  if (recording_) facts_.tensions = report::choose_tension_scale(recording_->tensions());
  report::write_summary(directory_, facts_, simulation);
  std::string page = report::format_page(facts_, simulation);
  report::replace_file(directory_ / report::page_name,
                       [&](report::OutputFile* file) { file->write(std::string_view(page)); });
  if (recording_) report::write_html_page(directory_, facts_, simulation, *recording_);
  return page;
}

void RunFolder::give_up() {
  if (checkpoint_.state.empty()) return;
  checkpoint_.t_end = checkpoint_.time;
  report::write_checkpoint(directory_, checkpoint_, report::Wait::No);
}

void RunFolder::take_step(const MotionReport& report, Simulation* between_frames) {
  const auto now = report::read_rough_clock();
  if (recording_) {
    recording_->take_step(report);
    if (between_frames != nullptr && recording_->wants_frame(between_frames->time())) {
      const auto begin = RunPlan::Clock::now();
      const Solution between = between_frames->solution();
      if (between.outcome.ok())
        recording_->take_frame(between_frames->system(), between, find_friction(*between_frames),
                               between_frames->observe(false));
      if (now >= next_page_) show(*between_frames);
      output_ += seconds_since(begin);
    }
  }
  if (between_frames == nullptr || now < due_ || now < next_publication_) return;
  const auto begin = RunPlan::Clock::now();
  publish(*between_frames);
  output_ += seconds_since(begin);
}

void RunFolder::take_certificate(const Certificate& certificate) {
  ++facts_.certificates;
  if (!facts_.certificate || facts_.certificate->passed()) facts_.certificate = certificate;
}

void RunFolder::publish(Simulation& simulation) {
  require_folder(report::checkpoint_name);
  const auto begin = RunPlan::Clock::now();
  if (facts_.has_started) {
    checkpoint_.trajectory = trajectory_.mark();
    checkpoint_.wall = measure_wall();
    checkpoint_.time = simulation.time();
    checkpoint_.state = simulation.save();
    // The recording is written first, since the checkpoint is never ahead of it.
    if (recording_) {
      report::write_recording(directory_, checkpoint_.scene, checkpoint_.time, *recording_);
      remove_from_strange_folder(report::recording_name);
    }
    // There is nothing worth the wait before the first step.
    const auto wait = simulation.report().steps > 0 ? report::Wait::ForDisk : report::Wait::No;
    // The frames are written first, since a checkpoint promises that they are there.
    if (wait == report::Wait::ForDisk) trajectory_.synchronize();
    require_folder(report::checkpoint_name);  // the folder may have been replaced while the disk was busy
    report::write_checkpoint(directory_, checkpoint_, wait);
    remove_from_strange_folder(report::checkpoint_name);
    require_folder(report::checkpoint_name);
  }
  last_frame_.reset();
  const auto end = RunPlan::Clock::now();
  next_publication_ = end + publishing_share * (end - begin);
  due_ = end + checkpoint_every_;
}

report::WallTimes RunFolder::measure_wall() const {
  return {.total = earlier_.total + seconds_since(begin_),
          .setup = earlier_.setup + setup_,
          .output = earlier_.output + output_};
}

}  // namespace tanor::cli
