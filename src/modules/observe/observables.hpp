#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include <tanor/observables.hpp>

#include "evaluate/definitions.hpp"
#include "observe/observed_text.hpp"

namespace tanor::detail {

/// The observables of a motion: their numbers at the last instant, and their extremes.
class Observables {
 public:
  /// The system and the names must outlive this.
  explicit Observables(const System& system, std::span<const Thing> absent = {}, const HostNames* host = nullptr)
      : system_(system), things_(system, absent, host) {}

  /// Adds one. Throws InputError with the text, the column and what would be right.
  std::size_t add(const Observable& what);
  /// Adds those of others, with their extremes.
  void add(const Observables& others);
  /// Removes one; those behind it move up by one.
  void remove(std::size_t number);
  bool empty() const { return found_.empty(); }
  /// Returns what all of them read, or those of every step alone.
  enum class Which { All, OfEveryStep };
  Needs needs(Which which) const;
  bool has_of_every_step() const;
  /// Evaluates them and takes their numbers into the extremes, if the instant counts.
  void take(const ObservedInstant& at, Which which, bool counts = true);
  /// Says of observables that are not known what was taken out, and `when(place)`: "broken at t = 2 s".
  void explain_gone(const std::function<std::string(const std::string& place)>& when);
  std::span<const Observed> found() const { return found_; }
  std::span<Observed> found() { return found_; }
  /// Returns the instant of the last look at all, s.
  double time() const { return time_; }

 private:
  const System& system_;
  Things things_;
  std::vector<ObservedText> texts_;
  std::vector<Observable> given_;
  std::vector<Observed> found_;
  std::unordered_map<std::string, std::size_t> numbers_;  // by names
  double time_ = std::numeric_limits<double>::quiet_NaN();
  std::unique_ptr<Definitions> definitions_;  // null before forces are not unique
};

/// Throws InputError if an observable has the name of the time, beside which results have it.
void refuse_name_of_time(const Observable& what);

/// Writes the energies of an answer, from the system alone. Its supports have no kinetic energy.
void find_energies(const System& system, const Solution& at, ObservedInstant* energies);

/// A condition on observables, "any tension(links) > 20": true where `value` is positive.
class Condition {
 public:
  /// Throws InputError as `Observables::add` does.
  Condition(const Things& things, const std::string& text, const Constants& parameters = {});

  Needs needs() const;
  double value(const ObservedInstant& at) const;
  /// Returns why it is not known at an instant; empty if it is, or if nobody knows.
  std::string explain(const ObservedInstant& at) const;
  /// Returns the thing of which the condition speaks, at the last value: the member that `any`, `max` or `min` took, or
  /// the only one; nothing if it speaks of several or of none. Before the first value it is the first member.
  std::optional<Thing> thing() const;
  /// Returns the name of the member that they took, which need not be a thing: a point; empty if they took none.
  const std::string& member() const { return seen_.member; }

 private:
  std::unique_ptr<ObservedText> left_, right_;
  double sign_ = 1.0;
  bool is_any_ = false;
  mutable Observed seen_;
  mutable std::size_t member_ = 0;
};

}  // namespace tanor::detail
