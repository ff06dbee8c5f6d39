#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "host/host_parts.hpp"
#include "observe/observables.hpp"

namespace tanor::detail {

/// The observables of a host. Their texts are read for the constraints and points that it has, again after each edit.
class HostObservables {
 public:
  /// The parts outlive it.
  explicit HostObservables(HostParts& parts) : parts_(parts), now_(std::make_unique<Reading>(parts)) {}

  /// Adds one. Throws InputError, after which nothing has changed, if its text cannot be read.
  std::size_t add(const Observable& what);
  /// Throws InputError if there is no such observable. Those behind it move up by one.
  void remove(std::size_t number);

  /// Reads the texts again if an edit came since, and returns what they need. Throws InputError if a thing is gone.
  Needs prepare(const ConstPointArray& positions);
  /// Returns `at` with the arrays that `take` reads in place of the host's.
  HostState own_arrays(HostState at);
  /// Evaluates the observables. find_rank() returns the rank of K, for which the first one after an edit stands.
  template <class FindRank>
  void take(const HostState& at, const FindRank& find_rank) {
    if (now_->observables->needs(Observables::Which::All).freedoms && !now_->rank) now_->rank = find_rank();
    evaluate(at);
  }
  std::span<const Observed> observed() const { return now_->observables->found(); }

 private:
  /// The texts, and the system for which they were read.
  struct Reading {
    System system;
    HostNames names;
    std::optional<PeriodicImages> images;      // in a cell, once positions are known
    std::optional<Observables> observables{};  // of `system`
    std::size_t num_edits;
    std::optional<std::size_t> rank{};

    explicit Reading(const HostParts& parts, const ConstPointArray& positions = {});
  };

  void read(const ConstPointArray& positions);
  void evaluate(const HostState& at);

  HostParts& parts_;
  std::unique_ptr<Reading> now_;
  std::vector<double> positions_, velocities_, accelerations_;  // [3n]
  std::vector<double> multipliers_, reactions_, loads_, wrapped_;
};

}  // namespace tanor::detail
