#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/dynamics.hpp>

#include "dynamics/decisions.hpp"
#include "dynamics/instant.hpp"

namespace tanor::detail {

class Contacts;
class EquationsOfMotion;
class RankRevealingFactor;
class Workspace;

/// The processes that have parts of one system, as this room sees them where equations or forces reach from one to
/// another. It is asked wherever a number of all parts decides, so that every process takes the same branch, and where
/// points of others are needed: the guests, which are supports here. This class is a process that is alone: every
/// answer is its own. All functions but the const ones must be called by all processes, in the same order.
class Team : public Decisions {
 public:
  using Decisions::Decisions;

  // ---- decisions ----

  /// Replaces one number for each neighbourhood here by the largest one of all its points.
  virtual void find_largest(std::span<double> /*of_neighbourhoods*/) {}

  // ---- guests ----

  /// Fetches the numbers of guests in an array [3n] from their owners.
  virtual void fetch_guests(double* /*points*/) {}
  /// Adds x to y [3n] at guests.
  virtual void add_to_guests(const double* /*x*/, double* /*y*/) const {}
  /// Returns these numbers [3n] with 0 at the guests, which may take a copy; that may be `points` itself.
  virtual const double* without_guests(const double* points, std::vector<double>* /*copy*/) const { return points; }

  // ---- what others count ----

  /// The rows here whose power another process counts.
  virtual std::span<const std::size_t> rows_elsewhere() const { return {}; }
  /// The part of the potential of the forces here that others count, J, and its explicit rate, W.
  virtual double potential_elsewhere(double /*t*/, const double* /*r*/) { return 0.0; }
  virtual double rate_elsewhere(const Kinematics& /*at*/) { return 0.0; }

  // ---- S and the rank of K ----

  /// Makes the factor of S for all rows together. `contacts` is null if constraints are ideal.
  virtual std::unique_ptr<RankRevealingFactor> make_factor(Workspace& work, const SolverOptions& options,
                                                           const std::vector<double>& blocks, Contacts* contacts);
  /// Returns true if K of all processes may lose rank.
  virtual bool may_lose_rank(bool own) const { return own; }
  /// Refuses what no process can solve on its own after a start at this state.
  virtual Outcome check_start(EquationsOfMotion& /*form*/, const Kinematics& /*at*/) { return {}; }
};

}  // namespace tanor::detail
