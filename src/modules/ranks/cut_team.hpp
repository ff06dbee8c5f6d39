#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"
#include "ranks/cut_energies.hpp"
#include "ranks/cut_factor.hpp"
#include "ranks/point_exchange.hpp"
#include "ranks/shared_neighbourhoods.hpp"

namespace tanor::detail {

/// The ranks that have parts of one system, where ideal constraints or forces reach from rank to rank.
///
/// Guests are supports on a rank that does not own them. Their positions and velocities are fetched after a projection
/// has moved them, their accelerations after these were found. In between a step does the same arithmetic to both.
class CutTeam final : public Team {
 public:
  /// `work` is being made; both arguments outlive it. Collective.
  CutTeam(Workspace& work, const Part& part);

  void find_largest(std::span<double> numbers) override { neighbourhoods_.find_largest(numbers); }

  void fetch_guests(double* points) override;
  void add_to_guests(const double* x, double* y) const override;
  const double* without_guests(const double* points, std::vector<double>* copy) const override;

  std::span<const std::size_t> rows_elsewhere() const override { return energies_.rows_elsewhere(); }
  double potential_elsewhere(double t, const double* r) override { return energies_.potential_elsewhere(t, r); }
  double rate_elsewhere(const Kinematics& at) override { return energies_.rate_elsewhere(at); }

  std::unique_ptr<RankRevealingFactor> make_factor(Workspace& work, const SolverOptions& options,
                                                   const std::vector<double>& blocks, Contacts* contacts) override;
  bool may_lose_rank(bool) const override { return part_.may_lose_rank; }
  Outcome check_start(EquationsOfMotion& form, const Kinematics& at) override;

 private:
  const Part& part_;
  Workspace& work_;
  std::vector<Index> guests_;  // inner
  PointExchange exchange_;     // with the owners of guests, by inner numbers
  CutEnergies energies_;
  SharedNeighbourhoods neighbourhoods_;
  const CutRank* rank_ = nullptr;  // of the factor that was made last
};

}  // namespace tanor::detail
