#include "report/page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include <tanor/enum_names.hpp>

#include "base/text.hpp"
#include "report/friction_parts.hpp"
#include "report/observed_words.hpp"
#include "report/shared_parts.hpp"
#include "report/words.hpp"

namespace tanor::report {
using namespace detail;

namespace {

/// Counts the rods, of which most scenes are made.
std::size_t count_rods(const System& system) {
  std::size_t count = 0;
  for (const Constraint& constraint : system.constraints) {
    if (const auto* rods = std::get_if<Rods>(&constraint)) count += rods->pairs.size();
  }
  return count;
}

/// Returns "gravity, pair (wca)".
std::string list_forces(const System& system) {
  std::string list;
  for (const Force& force : system.forces) {
    list += fmt::format("{}{}", list.empty() ? "" : ", ", kind_name(force));
    if (const auto* pairs = std::get_if<PairForces>(&force)) {
      list += fmt::format(" ({}", name_of(pairs->law));
      if (pairs->box != Vector3{})
        list += fmt::format(", box {} x {} x {}", text(pairs->box[0]), text(pairs->box[1]),
                            with_unit(text(pairs->box[2]), system.units.length));
      list += pairs->exclude_rods ? ", not along rods)" : ")";
    }
  }
  return list.empty() ? "none" : list;
}

/// Returns the first of `count` instants at which something happened, each in words.
template <class Instant, class Describe>
std::string list_instants(const std::vector<Instant>& first, std::size_t count, const Describe& describe) {
  constexpr std::size_t most_named = 5;
  std::string list;
  for (std::size_t k = 0; k < std::min(first.size(), most_named); ++k) list += (k > 0 ? ", " : "") + describe(first[k]);
  return list + (count > most_named ? fmt::format(", … ({} in all)", count) : "");
}

std::string line(const std::string& key, const std::string& text) {
  return fmt::format("  {:{}}{}\n", key, page_column - 2, text);
}

/// Tells how near the motion came to a singular configuration, and how well it keeps the constraints and its energy.
std::string describe_quality(const MotionReport& report, const Units& units) {
  std::string text =
      line("condition", fmt::format("reciprocal condition {} (estimate), smallest at t = {}",
                                    in_words(report.nearest_to_singular.reciprocal_condition, "{:.1e}"),
                                    with_unit(in_words(report.nearest_to_singular.time, "{:g}"), units.time)));
  text += line("violation",
               fmt::format("{} positions, {} velocities, {} accelerations (largest, relative)",
                           in_words(report.violation.position, "{:.1e}"), in_words(report.violation.velocity, "{:.1e}"),
                           in_words(report.violation.acceleration, "{:.1e}")));
  return text + line("energy", fmt::format("{} at the start, {} at the end, relative drift {}",
                                           with_unit(in_words(report.energy.start, "{:.10g}"), units.energy),
                                           with_unit(in_words(report.energy.now, "{:.10g}"), units.energy),
                                           in_words(report.energy.drift_relative(), "{:.1e}")));
}

}  // namespace

std::string format_page(const RunFacts& facts, Simulation& simulation) {
  const MotionReport& report = simulation.report();
  const PlanSummary& plan = simulation.plan();
  const PhaseTimes& times = report.times;
  const Units& units = simulation.system().units;
  std::string page = facts.scene + "\n";
  if (facts.has_started) {
    page += format_observables(simulation.observe(false), units);
    page += format_passages(simulation.passages(), units) + "\n";
  }
  page += line("source", facts.source);
  page +=
      line("system",
           fmt::format("{}, {}, {}, {}, {}", count_in_words(plan.points, "point"),
                       count_in_words(plan.supports, "support"), count_in_words(count_rods(simulation.system()), "rod"),
                       count_in_words(plan.equations, "equation"), count_in_words(plan.islands, "island")));
  if (facts.has_started) {
    if (const std::string redundancy = describe_redundancy(simulation.rank()); !redundancy.empty())
      page += line("rank", redundancy);
  }
  const auto time_of = [&](const auto& instant) { return with_unit(fmt::format("{:g}", instant.time), units.time); };
  if (const RankChanges& changes = report.rank_changes; !changes.first.empty())
    page += line("rank changes", list_instants(changes.first, changes.count, [&](const RankChange& change) {
                   return fmt::format("at t = {} to {}", time_of(change), change.rank);
                 }));
  if (const SingularPassages& passages = report.singular_passages; !passages.first.empty())
    page += line("singular", "passed at t = " + list_instants(passages.first, passages.count, time_of) +
                                 ": constraints depend on each other there");
  if (!plan.prestress_rigid_points.empty()) {
    page += line("rigid", fmt::format("{} points are held rigid by prestress, by rods under tension between supports; "
                                      "they do not move; the forces in "
                                      "these rods are not determined",
                                      plan.prestress_rigid_points.size()));
  }
  page += line("forces", list_forces(simulation.system()));
  const bool has_friction = !simulation.system().friction.empty();
  if (has_friction) {
    page += line("friction", fmt::format("{}; {}; work {}", describe_friction(simulation.system()),
                                         describe_friction(report.friction),
                                         with_unit(in_words(report.energy.work_of_friction, "{:.6g}"), units.energy)));
  }
  if (facts.has_started) {
    page += line("start", fmt::format("positions corrected by {} at most, velocities by {}",
                                      with_unit(in_words(report.start.position_correction, "{:.2g}"), units.length),
                                      with_unit(in_words(report.start.velocity_correction, "{:.2g}"),
                                                units.letters(Dimension::Velocity))));
  }
  page += line("time",
               fmt::format("{:g} of {}", simulation.time(), with_unit(fmt::format("{:g}", facts.t_end), units.time)));
  if (!facts.stopped_by.empty()) page += line("stopped by", facts.stopped_by);
  const std::size_t iterations = report.counters.iterations;
  page += line("method", fmt::format("{}, {}, {} rejected, {} ({}, {}), {}{}, {}", name_of(report.method),
                                     count_in_words(report.steps, "step"), report.rejected,
                                     count_in_words(report.counters.factorizations, "factorization"), plan.ordering(),
                                     plan.factorization(), count_in_words(report.counters.solves, "solve"),
                                     iterations > 0 ? fmt::format(" ({} iterations)", iterations) : "",
                                     count_in_words(static_cast<std::size_t>(facts.threads), "thread")));
  page +=
      line("wall time",
           fmt::format("{:.3g} s: set-up {:.3g}, evaluate {:.3g}, assemble {:.3g}, factor {:.3g}, "
                       "solve {:.3g}, {}output {:.3g}",
                       facts.wall.total, facts.wall.setup, times.evaluate, times.assemble, times.factor, times.solve,
                       has_friction ? fmt::format("friction {:.3g}, ", times.friction) : "", facts.wall.output));
  if (facts.has_started) page += describe_quality(report, units);
  if (!report.accuracy_warning.empty()) page += line("warning", report.accuracy_warning);
  if (facts.certificate) page += line("certificate", facts.certificate->line());
  return page;
}

}  // namespace tanor::report
