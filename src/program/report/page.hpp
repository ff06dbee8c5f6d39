#pragma once

#include <functional>
#include <span>
#include <string>

#include <tanor/motion.hpp>

#include "report/json_text.hpp"
#include "report/summary.hpp"

namespace tanor::report {

inline constexpr const char* page_name = "report.txt";
inline constexpr std::size_t page_column = 16;  ///< column at which the text of a row begins

/// Describes a run on one page of text: what it was, what it did, where the time went, and how accurate it is.
std::string format_page(const RunFacts& facts, Simulation& simulation);

/// Counts the rods, of which most scenes are made.
std::size_t count_rods(const System& system);

/// Returns what people see of an energy, J: 0 if it is rounding beside those of the motion.
double beyond_rounding(double energy, const MotionReport& report);
/// Returns a function that tells below which size numbers of an observable are rounding: beside its largest one, those
/// of all observables that measure the same, and the lengths and energies of the scene. `motion` is null at rest.
std::function<double(const Observed&)> measure_rounding(std::span<const Observed> all, const System& system,
                                                        const Simulation* motion);
/// Returns what people see of an observable.
Observed without_noise(Observed observed, double noise);
/// Returns the lines of the page about observables: the last number of each, the extremes, when and where. `motion` is
/// null at rest, which has no time.
std::string format_observables(std::span<const Observed> observables, const System& system, const Simulation* motion);

/// Writes report.txt, which begins with the observables and ends with what was left out, and observables.csv with one
/// row, of a state of rest. Returns the page.
std::string write_observables_at_rest(const std::filesystem::path& directory, const std::string& scene,
                                      const std::string& said, std::span<const Observed> observables,
                                      const System& system, double time, std::span<const std::string> left_out);

/// Returns lines about the first events that were met, with what they took out.
std::string format_passages(const Simulation& motion);
/// Returns one of them in words: "tears: links[3] breaks with 0.2 J; point 4 is without constraints". An energy that is
/// rounding beside those of the motion is left out.
std::string describe_passage(const Passage& passage, const Simulation& motion);

/// Returns `observables` of summary.json: all fields of each. Members and values are left out if they are many; the
/// tables over time have them.
Json describe_observables(std::span<const Observed> observables);
/// Returns what each summary begins with.
Json describe_head(const std::string& scene, const std::string& source, const Units& units,
                   std::span<const Observed> observables);

}  // namespace tanor::report
