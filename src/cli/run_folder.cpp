#include "cli/run_folder.hpp"

#include "cli/machine.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

namespace {

double seconds_since(RunPlan::Clock::time_point begin) {
  return std::chrono::duration<double>(RunPlan::Clock::now() - begin).count();
}

report::RunFacts collect_facts(const scene::Scene& scene, const Simulation& simulation) {
  report::RunFacts facts;
  facts.scene = scene.name;
  facts.source = scene.source;
  facts.threads = scene.solver.threads > 0 ? scene.solver.threads : count_threads();
  facts.t_end = scene.t_end;
  facts.has_started = simulation.outcome().ok();
  return facts;
}

/// A run that starts anew leaves nothing of an earlier one that could be taken for its own.
report::Trajectory open_trajectory(const RunPlan& plan, const scene::Scene& scene, const System& system) {
  if (plan.before) return {plan.directory, system, scene.output_points, plan.before->trajectory};
  report::make_folder(plan.directory);
  report::remove_checkpoint(plan.directory);
  report::remove_file(plan.directory / "summary.json");
  return {plan.directory, system, scene.output_points};
}

/// Part of the run that lists and checkpoints may take. Replacing a file can wait for the disk (milliseconds), which
/// would be most of the time of a small system with many frames.
constexpr int publishing_share = 20;  // one twentieth

}  // namespace

RunFolder::RunFolder(const RunPlan& plan, const scene::Scene& scene, const Simulation& simulation)
    : directory_(plan.directory),
      earlier_(plan.before ? plan.before->wall : report::WallTimes()),
      begin_(plan.begin),
      facts_(collect_facts(scene, simulation)),
      trajectory_(open_trajectory(plan, scene, simulation.system())),
      setup_(seconds_since(plan.begin)) {
  checkpoint_.scene = plan.fingerprint;
}

void RunFolder::write_frame(const Simulation& simulation) {
  const auto begin = RunPlan::Clock::now();
  trajectory_.write_frame(simulation);
  if (begin >= next_publication_) publish(simulation);
  output_ += seconds_since(begin);
}

std::string RunFolder::finish(const Simulation& simulation) {
  const auto begin = RunPlan::Clock::now();
  publish(simulation);
  output_ += seconds_since(begin);
  facts_.wall = measure_wall();
  report::write_summary(directory_, facts_, simulation);
  const std::string page = report::format_page(facts_, simulation);
  report::replace_file(directory_ / "report.txt",
                       [&](report::OutputFile* file) { file->write(std::string_view(page)); });
  return page;
}

void RunFolder::take_certificate(const Certificate& certificate) {
  if (!facts_.certificate || facts_.certificate->passed()) facts_.certificate = certificate;
}

void RunFolder::publish(const Simulation& simulation) {
  const auto begin = RunPlan::Clock::now();
  // The list first: a checkpoint promises that all its frames are there.
  trajectory_.write_collection();
  if (facts_.has_started) {
    checkpoint_.trajectory = trajectory_.mark();
    checkpoint_.wall = measure_wall();
    checkpoint_.snapshot = simulation.snapshot();
    report::write_checkpoint(directory_, checkpoint_);
  }
  const auto end = RunPlan::Clock::now();
  next_publication_ = end + publishing_share * (end - begin);
}

report::WallTimes RunFolder::measure_wall() const {
  return {.total = earlier_.total + seconds_since(begin_),
          .setup = earlier_.setup + setup_,
          .output = earlier_.output + output_};
}

}  // namespace tanor::cli
