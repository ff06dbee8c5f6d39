#pragma once

#include <vector>

#include "mpi/program/division.hpp"
#include "mpi/tanor_mpi.hpp"
#include "report/summary.hpp"

namespace tanor::mpi {

/// The end of a run of all ranks, gathered as if it had run on one rank. The first rank has the arrays, in the order of
/// the whole system; there are none if no rank holds it.
class WholeRun {
 public:
  /// `division` outlives it. Collective.
  WholeRun(MpiRanks& ranks, const Division& division, Simulation& simulation);

  /// Returns the end of the run. Valid on the first rank.
  report::RunEnd end() const;
  /// Certifies the state at the end. The first rank solves the whole system there once more, without the others,
  /// certifies that solution, and compares the accelerations of all ranks with it. Valid on the first rank. Throws
  /// std::bad_alloc or std::length_error if one rank cannot hold the whole system.
  Certificate prove() const;

 private:
  void merge_plan();
  void merge_friction();
  enum class OfSupports { AreTheFirstRanks, AreSummed };
  std::vector<double> gather_points(std::span<const double> own,
                                    OfSupports of_supports = OfSupports::AreTheFirstRanks) const;
  std::vector<double> gather_rows(std::span<const double> own) const;
  std::vector<double> add_on_first(const std::vector<double>& packed, std::size_t width, std::size_t size) const;

  MpiRanks& ranks_;
  const Division& division_;
  const RankSystem& part_;
  std::size_t contacts_;
  PlanSummary plan_;
  MotionReport report_;
  RankReport rank_;
  std::vector<double> positions_, velocities_, accelerations_, multipliers_, reactions_, support_forces_;
};

}  // namespace tanor::mpi
