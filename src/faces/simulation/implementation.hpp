#pragma once

#include <memory>
#include <vector>

#include "observe/observables.hpp"
#include "simulation/simulated_motion.hpp"

namespace tanor {
using namespace detail;

/// The implementation of Simulation: a motion with what users ask of it, observables and events. An event that takes
/// something out of the system replaces the object by one of the changed system.
struct Simulation::Implementation final : SimulatedMotion {
  using SimulatedMotion::SimulatedMotion;

  // Observables, in observing.cpp.
  std::size_t add_observable(const Observable& what);
  std::span<const Observed> observe(bool counts);
  std::vector<Observed> observe(std::span<const Observable> wanted);
  void explain_gone(Observables* which) const;
  void observe_step() override;
  void verify_observables(const Reactions& anew, Certificate* certificate) override;
  ObservedInstant describe(const Solution& at, double t, const Energy& energy) const;
  ObservedInstant look_at(Needs needs);
  /// Returns an answer with NaN for forces that prestress leaves open.
  const Solution& without_unknown(const Solution& at);
  ObservedInstant look_inside(double t, const double* x, const double* x_dot, Needs needs);
  void look_on_the_way(Needs needs);

  // Events.
  std::size_t add_event(Event event);
  void refuse_unknown(const Event& event);
  /// Adds the events by which members break that have `breaks_at`, before those of users.
  void add_breaks();
  std::span<const Passage> list_passages();
  void collect_passages() override { list_passages(); }
  bool has_taken_its_thing(std::size_t event) const;
  /// Notes conditions that have become true at the present state. Returns what they ask for.
  struct Acts {
    std::vector<std::pair<Thing, std::size_t>> taken{};  // with the number of its passage
    bool stops = false;
  };
  Acts act();
  /// Advances and acts on conditions on the way.
  static Outcome advance_through_events(std::unique_ptr<Implementation>* at, double t_end, const Observer& observer);

  // Systems that change, in changed_system.cpp.
  /// Replaces a simulation by one of its system without one more thing, at the same state, and tells its passage.
  static Outcome take_out(std::unique_ptr<Implementation>* at, const Thing& thing, std::size_t passage);
  /// Fails if points of the system that was left are held rigid by prestress.
  Outcome check_rest() const;
  /// Makes the simulation of a system without some things, at its start.
  static std::unique_ptr<Implementation> make_without(const Implementation& of, std::vector<Thing> things);
  /// Takes over requests, passages and extremes from a simulation of the same system with other things taken out.
  void continue_from(const Implementation& before);
  void keep_signs();
  void give_up_noise();
  /// Returns the points that no constraint joins, [point].
  std::vector<char> find_free_points() const;
  using SimulatedMotion::restore;
  /// Restores a state, out of whose system events may have taken other things than out of this one.
  static void restore(std::unique_ptr<Implementation>* at, std::span<const std::byte> saved);
  /// Returns the system with the names of all that was taken out; else with points that prestress holds as supports.
  const System& observed_system() const { return taken.empty() ? model.system : system(); }
  /// Finds by their names what the system has, and knows what was taken out.
  const Things& things() const {
    if (!names) names.emplace(observed_system(), taken);
    return *names;
  }
  /// Returns the equations of constraints that were taken out.
  std::vector<std::size_t> rows_taken_out() const;
  /// Makes the multipliers of what was taken out NaN, as its observables are.
  void forget_what_is_gone(Solution* at) const;
  static std::vector<std::size_t> numbers_of(std::span<const Thing> things);
  void write_requests(Snapshot* snapshot) override;
  void read_requests(const Snapshot& snapshot) override;

  std::unique_ptr<Observables> observables;  // null if there are none
  struct {
    Solution at, known;
    std::vector<double> friction, self_stress;
  } seen;  // what observables read on the way
  std::vector<Event> events;
  std::vector<std::unique_ptr<Condition>> conditions;  // [event] null for a function
  std::vector<Truth> truths;                           // [event]
  std::vector<Passage> passages;
  std::size_t seen_passages = 0;  // of those of `integration`, in `passages`
  std::vector<Thing> taken;       // out of `given`
  mutable std::optional<Things> names;
};

}  // namespace tanor
