#pragma once

#include <memory>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/workspace.hpp"
#include "ranks/cut_factor.hpp"
#include "ranks/point_exchange.hpp"

namespace tanor::detail {

/// The ranks that have parts of one system, where ideal constraints or forces reach from rank to rank.
///
/// Guests are supports on a rank that does not own them. Their positions and velocities are fetched after a projection
/// has moved them, their accelerations after these were found. In between a step does the same arithmetic to both. Of
/// forces that reach from rank to rank, one rank counts the energy. Errors in neighbourhoods that lie on several ranks
/// are measured against all of their points.
class CutTeam final : public Team {
 public:
  /// `work` is being made; both arguments outlive it. Collective.
  CutTeam(Workspace& work, const Part& part);

  void find_largest(std::span<double> of_neighbourhoods) override;

  void fetch_guests(double* points) override;
  void add_to_guests(const double* x, double* y) const override;
  const double* without_guests(const double* points, std::vector<double>* copy) const override;

  std::span<const std::size_t> rows_elsewhere() const override { return rows_elsewhere_; }
  double potential_elsewhere(double t, const double* r) override;
  double rate_elsewhere(const Kinematics& at) override;

  std::unique_ptr<RankRevealingFactor> make_factor(Workspace& work, const SolverOptions& options,
                                                   const std::vector<double>& blocks, Contacts* contacts) override;
  bool may_lose_rank(bool) const override { return part_.may_lose_rank; }
  Outcome check_start(EquationsOfMotion& form, const Kinematics& at) override;

 private:
  void list_elsewhere();
  void add_pairs_with_guests(std::size_t entry, const PairForces& pairs);
  void measure_lengths();
  void list_neighbourhoods();

  /// Pair forces without a cutoff between own points and guests.
  struct PairsWithGuests {
    std::size_t entry;    // among the pair forces of the system
    PairField among_own;  // those between own points, which no other rank has
  };
  struct Neighbourhood {
    std::size_t here, of_all;
  };

  const Part& part_;
  Workspace& work_;
  const Model& model_;
  std::vector<Index> guests_;                  // inner
  PointExchange exchange_;                     // with the owners of guests, by inner numbers
  std::unique_ptr<Forces> counted_elsewhere_;  // forces whose energies other ranks count; null if there are none
  std::vector<PairsWithGuests> pairs_with_guests_;
  std::vector<std::size_t> rows_elsewhere_;
  std::vector<Neighbourhood> neighbourhoods_;  // those that are shared, ascending
  const CutRank* rank_ = nullptr;              // of the factor that was made last
};

}  // namespace tanor::detail
