#include "report/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include <tanor/enum_names.hpp>
#include <tanor/version.hpp>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "report/field_json.hpp"
#include "report/output_file.hpp"
#include "report/shared_parts.hpp"
#include "report/shown_parts.hpp"
#include "report/text_formats.hpp"
#include "report/words.hpp"

namespace tanor::report {
using namespace detail;

namespace {

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

constexpr double beside_itself = 1e-10, beside_others = 1e-13;  // parts of a size that are rounding

double rounding_of_energy(const MotionReport& report) {
  return beside_itself * report.energy.scale;
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
  const auto energy = [&](double number) {
    return with_unit(in_words(beyond_rounding(number, report), "{:.10g}"), units.energy);
  };
  return text +
         line("energy", fmt::format("{} at the start, {} at the end, relative drift {}", energy(report.energy.start),
                                    energy(report.energy.now), in_words(report.energy.drift_relative(), "{:.1e}")));
}

}  // namespace

double beyond_rounding(double energy, const MotionReport& report) {
  return std::abs(energy) <= rounding_of_energy(report) ? 0.0 : energy;
}

std::size_t count_rods(const System& system) {
  std::size_t count = 0;
  for (const Constraint& constraint : system.constraints) {
    if (const auto* rods = std::get_if<Rods>(&constraint)) count += rods->pairs.size();
  }
  return count;
}

std::string format_page(const RunFacts& facts, Simulation& simulation) {
  const MotionReport& report = simulation.report();
  const PlanSummary& plan = simulation.plan();
  const PhaseTimes& times = report.times;
  const Units& units = simulation.system().units;
  std::string page = facts.scene + "\n";
  if (facts.has_started) {
    page += format_observables(simulation.observe(false), simulation.system(), &simulation);
    page += format_passages(simulation) + "\n";
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
    page += line("rigid", fmt::format("{} without motion, held rigid by prestress, by rods under tension between "
                                      "supports; the forces in these rods are not determined",
                                      count_in_words(plan.prestress_rigid_points.size(), "point")));
  }
  page += line("forces", list_forces(simulation.system()));
  const bool has_friction = !simulation.system().friction.empty();
  if (has_friction) {
    const std::string last =
        report.last_change.empty()
            ? ""
            : fmt::format("; last change at t = {}: {}", with_unit(fmt::format("{:g}", report.last_event), units.time),
                          report.last_change);
    page +=
        line("friction",
             fmt::format(
                 "{}; {}{}; work {}", describe_friction(simulation.system()), describe_friction(report.friction), last,
                 with_unit(in_words(beyond_rounding(report.energy.work_of_friction, report), "{:.6g}"), units.energy)));
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
                                     iterations > 0 ? " (" + count_in_words(iterations, "iteration") + ")" : "",
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
  if (const std::vector<std::string> left_out = list_left_out(facts.left_out, plan.left_out); !left_out.empty())
    page += line("left out", fmt::format("{}", fmt::join(left_out, "; ")));
  return page;
}

namespace {

std::string number_with_unit(double number, const std::string& unit) {
  constexpr int digits = 6;
  return with_unit(text(number, digits), unit);
}

/// Returns "12.3 N at t = 0.5 s in links[3]"; without a motion there is no time.
std::string describe_extreme(const Extreme& extreme, const std::string& unit, const Simulation* motion) {
  std::string text = number_with_unit(extreme.value, unit);
  if (motion != nullptr) text += " at t = " + number_with_unit(extreme.time, motion->system().units.time);
  return extreme.member.empty() ? text : text + " in " + extreme.member;
}

std::string describe_part(const Observed& observed, std::size_t part, const Simulation* motion, double noise) {
  const Extreme &least = observed.least[part], &largest = observed.largest[part];
  std::string line;
  bool is_known = false;  // any of its numbers
  for (std::size_t k = part; k < observed.values.size(); k += std::max<std::size_t>(observed.parts.size(), 1))
    is_known = is_known || !std::isnan(observed.values[k]);
  if (observed.members.empty() && !is_known) {
    line = observed.unknown.empty() ? "not known" : observed.unknown;
  } else if (observed.members.empty()) {
    line = number_with_unit(observed.values[part], observed.unit);
    if (!observed.member.empty()) line += " in " + observed.member;
  } else {
    line = text_of_count(observed.members.size(), "number") +
           (observed.unknown.empty() ? "" : (is_known ? ", some" : ", all") + (" unknown (" + observed.unknown + ")"));
  }
  const std::string least_text = number_with_unit(least.value, observed.unit);
  if (std::isnan(least.value) || largest.value - least.value <= noise ||
      least_text == number_with_unit(largest.value, observed.unit)) {
    if (std::isnan(least.value)) return line;
    if (!is_known) return line + ", before " + least_text;
    if (observed.members.empty()) return line;
    return line + (observed.unknown.empty() ? ", all " : ", others ") + least_text;
  }
  return line + "; least " + describe_extreme(least, observed.unit, motion) + ", largest " +
         describe_extreme(largest, observed.unit, motion);
}

double size_of(const Observed& one) {
  double size = 0.0;
  for (const auto* const list : {&one.least, &one.largest})
    for (const Extreme& each : *list) size = std::max(size, std::abs(each.value));
  return size;
}

/// Returns what an observable measures; empty if that is not known.
std::string name_kind(const std::string& unit, Dimension dimension) {
  return !unit.empty() || dimension == Dimension::None ? unit : std::to_string(static_cast<int>(dimension));
}

}  // namespace

std::function<double(const Observed&)> measure_rounding(std::span<const Observed> all, const System& system,
                                                        const Simulation* motion) {
  std::map<std::string, double> sizes;
  const auto take = [&](const std::string& kind, double size) { sizes[kind] = std::max(sizes[kind], size); };
  for (const Observed& each : all) take(name_kind(each.unit, each.dimension), beside_others * size_of(each));
  const double diagonal = measure_diagonal(system.positions);
  take(name_kind(system.units.length, Dimension::Length), beside_others * diagonal);
  // The force of a spring is a difference of lengths times its stiffness.
  for (const Force& force : system.forces)
    if (const auto* springs = std::get_if<Springs>(&force))
      take(name_kind(system.units.force, Dimension::Forces), beside_others * springs->stiffness * diagonal);
  // A moment cancels forces at their arms, and the weight is there where no force is observed.
  double& largest_force = sizes[name_kind(system.units.force, Dimension::Forces)];
  double weight = 0.0, arm = 0.0;
  for (const double mass : system.masses) weight += mass * norm(make_vec3(find_gravity(system)));
  for (std::size_t i = 0; i < system.num_points(); ++i) arm = std::max(arm, norm(load(system.positions.data(), i)));
  take(name_kind(system.units.letters(Dimension::Moment), Dimension::Moment),
       std::max(largest_force, beside_others * weight) * arm);
  if (motion != nullptr) {
    const double energy = rounding_of_energy(motion->report());
    take(name_kind(system.units.energy, Dimension::Energy), energy);
    // An acceleration cancels forces, and velocities may end as they began.
    double fastest = 0.0, total_mass = 0.0;
    for (std::size_t i = 0; i < system.num_points(); ++i) {
      const double mass = system.masses[i], reaction = norm(load(motion->reactions().data(), i));
      if (mass > 0.0) fastest = std::fmax(fastest, reaction / mass);
      total_mass += mass;
    }
    take(name_kind(system.units.letters(Dimension::Acceleration), Dimension::Acceleration), beside_others * fastest);
    take(name_kind(system.units.letters(Dimension::Velocity), Dimension::Velocity),
         beside_others * std::sqrt(2.0 * motion->report().energy.scale / std::max(total_mass, 1e-300)));
    const PlanSummary& plan = motion->plan();
    const double freedom =
        3.0 * static_cast<double>(plan.points - plan.supports) - static_cast<double>(motion->report().rank_changes.now);
    // T = 2 K/(k f)
    take(name_kind(system.units.temperature, Dimension::Temperature),
         2.0 * energy / (system.units.boltzmann * std::max(1.0, freedom)));
  }
  sizes[""] = 0.0;  // what is not known to measure the same
  return [sizes](const Observed& observed) {
    const auto others = sizes.find(name_kind(observed.unit, observed.dimension));
    return std::max(beside_itself * size_of(observed), others == sizes.end() ? 0.0 : others->second);
  };
}

Observed without_noise(Observed observed, double noise) {
  const auto drop = [noise](double& number) {
    if (std::abs(number) <= noise) number = 0.0;
  };
  std::ranges::for_each(observed.values, drop);
  for (auto* const list : {&observed.least, &observed.largest}) std::ranges::for_each(*list, drop, &Extreme::value);
  return observed;
}

std::string format_observables(std::span<const Observed> observables, const System& system, const Simulation* motion) {
  const auto rounding = measure_rounding(observables, system, motion);
  std::vector<std::pair<std::string, std::string>> lines;
  for (const Observed& given : observables) {
    const double noise = rounding(given);
    const Observed each = without_noise(given, noise);
    const std::string zero = number_with_unit(0.0, each.unit);
    std::string zeros;  // parts that are 0 all the time, which share a line
    for (std::size_t part = 0; part < each.least.size(); ++part) {
      const std::string name = each.parts.empty() ? "" : "." + each.parts[part];
      if (std::string text = describe_part(each, part, motion, noise); text != zero || name.empty())
        lines.emplace_back(each.name + name, std::move(text));
      else
        zeros += (zeros.empty() ? "" : ", ") + name;
    }
    if (!zeros.empty()) lines.emplace_back(each.name + zeros, zero);
  }
  std::size_t width = 0;
  for (const auto& [name, line] : lines) width = std::max(width, name.size());
  std::string result;
  for (const auto& [name, line] : lines) result += fmt::format("  {:{}}  {}\n", name, width, line);
  return result;
}

std::string write_observables_at_rest(const std::filesystem::path& directory, const std::string& scene,
                                      const std::string& said, std::span<const Observed> observables,
                                      const System& system, double time, std::span<const std::string> left_out) {
  const std::string page = scene + "\n" + format_observables(observables, system, nullptr),
                    last = left_out.empty() ? "" : line("left out", fmt::format("{}", fmt::join(left_out, "; ")));
  replace_file(directory / page_name,
               [&](OutputFile* file) { file->write(page + "\n" + line("at rest", said) + last); });
  open_observables({.path = directory / observables_name, .observables = observables, .units = system.units})
      ->write({.time = time, .observables = observables});
  return last.empty() ? page : page + "\n" + last;
}

std::string describe_passage(const Passage& passage, const Simulation& motion) {
  std::string line = passage.member;
  if (passage.action == EventAction::Break) line += " breaks";
  if (passage.action == EventAction::Release) line += " is released";
  if (passage.action == EventAction::Stop) line += line.empty() ? "the run stops" : "; the run stops";
  if (const double lost = beyond_rounding(passage.energy_lost, motion.report()); lost != 0.0)
    line += " with " + number_with_unit(lost, motion.system().units.energy);
  if (!passage.rest.empty()) line += "; " + passage.rest;
  return passage.name + (line.empty() ? "" : ": " + line);
}

std::string format_passages(const Simulation& motion) {
  const std::span<const Passage> passages = motion.passages();
  constexpr std::size_t most = 10;
  std::string result;
  for (const Passage& each : passages.first(std::min(most, passages.size()))) {
    result += fmt::format("  event at t = {}: {}\n", number_with_unit(each.time, motion.system().units.time),
                          describe_passage(each, motion));
  }
  return result + (passages.size() > most ? fmt::format("  … {} events in all\n", passages.size()) : "");
}

Json describe_observables(std::span<const Observed> observables) {
  constexpr std::size_t many = 1000;
  return list_of(observables, [](const Observed& each) {
    Json object = json_of(each);
    if (each.values.size() > many) {
      object.erase("members");
      object.erase("values");
    }
    return object;
  });
}

Json describe_head(const std::string& scene, const std::string& source, const Units& units,
                   std::span<const Observed> observables) {
  return {{"scene", scene},
          {"source", source},
          {"tanor_version", TANOR_VERSION},
          {"units", json_of(units)},
          {"observables", describe_observables(observables)}};
}

}  // namespace tanor::report
