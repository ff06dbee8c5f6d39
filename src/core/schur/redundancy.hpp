#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/groups.hpp"
#include "evaluate/family.hpp"
#include "factor/rank_solver.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Returns the largest mass over the smallest one of moving points that constraints join. S may be worse conditioned
/// than K by as much. `incidences` are those of K; `inverse_mass` [point] is 0 at supports.
double find_mass_ratio(std::span<const Incidence> incidences, std::span<const double> inverse_mass);

/// Says which rows of K depend on others, and what follows for S lambda = b. QR of M^-1/2 K decides, and also QR of K
/// if masses differ much, island by island, where S raises the suspicion. A decision is kept until somebody decides
/// anew, which costs nothing where K is the same. The class costs nothing if nothing was suspected.
///
/// Dependent rows take no part in S (their multipliers are 0) unless `minimize_norm` shares the load out again.
class Redundancy {
 public:
  /// Keeps references to all three. `incidences` are those of K; `inverse_mass` is [point].
  Redundancy(std::span<const Incidence> incidences, std::span<const double> inverse_mass, const Numbering& numbering);

  using Rows = std::pair<Index, Index>;  ///< [first, end), whole islands

  /// Decides for all islands in `rows` with K in `blocks`. Each row is known to its tolerance [d], as a unit column.
  /// Returns true if the dependent rows have changed.
  bool decide(const double* blocks, Rows rows, std::span<const double> tolerances);
  /// Does the same for the islands that have dependent rows.
  bool decide_again(const double* blocks, std::span<const double> tolerances);

  bool has_decided() const { return !islands_.empty(); }
  /// Returns true if some row depends on others.
  bool is_found() const { return num_dependent_ > 0; }
  std::size_t num_dependent() const { return num_dependent_; }
  bool is_dependent(std::size_t row) const { return num_dependent_ > 0 && dependent_[row] != 0; }
  /// Returns the smallest singular value of the independent unit columns over the decided islands; 1 if there are none.
  double smallest_singular_value() const;

  /// Lets QR factors solve the islands in `rows`, which were just decided, until `release_qr`.
  void take_qr(Rows rows);
  void release_qr();
  bool uses_qr() const { return num_qr_ > 0; }
  /// Returns the rows that are left to the factor of S, for GramSolver::set_active; it is empty if all of them are.
  std::span<const char> rows_for_gram();
  /// Computes x = -S^-1 b on the islands that QR solves and leaves the others alone. b and x are [d] and may be one.
  void solve_negative(const double* b, double* x);

  /// A dependent row and the rows that it is made of (inner rows, coefficients of unit columns).
  struct Found {
    Index row;
    std::vector<std::pair<Index, double>> terms;
  };
  std::vector<Found> list() const;

  /// The dependent row whose right side b [d] is farthest from what the other rows ask of it.
  struct Contradiction {
    Found found;
    double excess;  ///< unit of b
  };
  /// Returns nothing if that right side lies within `allowed` times its terms, or times `scale` [d], or within what
  /// rounding explains. It uses the K of the last decision.
  std::optional<Contradiction> find_contradiction(std::span<const double> b, std::span<const double> scale,
                                                  double allowed) const;

  /// Replaces lambda by the solution with the smallest Euclidean norm. `mark_unique` sets `is_unique` [row] to false
  /// where other values are as good. Both use the K of the last decision.
  void minimize_norm(double* lambda) const;
  void mark_unique(std::vector<bool>* is_unique) const;

 private:
  struct Island {
    Index first, end;
    std::unique_ptr<RankSolver> solver;
    bool by_qr = false;
    SparseColumns columns{};  ///< for which `solver` has decided, scaled by masses, …
    double tolerance = 0.0;   ///< … with this one
  };
  SparseColumns columns(const double* blocks, Rows rows, Scaling scaling);
  void stand_alone(Index first_row, SparseColumns* C) const;
  bool decide_island(const double* blocks, Rows rows, std::span<const double> tolerances);
  double mass_ratio_of(Rows rows) const;
  Found translate(const Island& island, const Dependence& dependence) const;

  std::span<const Incidence> incidences_;
  std::span<const double> inverse_mass_;
  const Numbering& numbering_;
  Groups<Index> by_row_;                    // places in incidences_; made at the first decision
  std::vector<Index> local_point_;          // [point] its number in the current island
  std::vector<Island> islands_;             // the decided ones, by rows
  std::vector<char> dependent_, for_gram_;  // [row]
  std::size_t num_dependent_ = 0, num_qr_ = 0;
};

}  // namespace tanor::detail
