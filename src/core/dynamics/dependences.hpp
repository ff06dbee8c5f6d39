#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/groups.hpp"
#include "dynamics/workspace.hpp"
#include "factor/rank_solver.hpp"

namespace tanor::detail {

/// Says which rows of K depend on others, and what follows for S lambda = b, for residuals and for reports. QR of
/// M^-1/2 K decides, and also QR of K if masses differ much, island by island, where S raises the suspicion. A decision
/// is kept until somebody decides anew, which costs nothing where K is the same. The class costs nothing if nothing was
/// suspected.
///
/// Dependent rows take no part in S (their multipliers are 0) unless `minimize_norm` shares the load out again. The
/// columns of a Dependence are rows of the model here.
class Dependences {
 public:
  /// Keeps references to both. `inverse_mass` [point] is 1/m of S, or the weights of another K'WK.
  Dependences(const Workspace& work, std::span<const double> inverse_mass);
  explicit Dependences(const Workspace& work) : Dependences(work, work.model().inverse_mass) {}
  virtual ~Dependences() = default;

  // ---- decisions ----

  using Rows = std::pair<Index, Index>;  ///< [first, end), whole islands

  /// Decides for all islands in `rows` with K in `blocks`. Each row is known to its tolerance [d], as a unit column.
  /// Returns true if the dependent rows have changed.
  bool decide(const double* blocks, Rows rows, std::span<const double> tolerances);
  /// Does the same for the islands that have dependent rows.
  bool decide_again(const double* blocks, std::span<const double> tolerances);
  /// Notes that the dependent rows have changed with K in `blocks`.
  void note_change(const std::vector<double>& blocks);

  /// Returns true if some row depends on others.
  virtual bool is_found() const { return num_dependent_ > 0; }
  std::size_t num_dependent() const { return num_dependent_; }
  virtual bool is_dependent(std::size_t row) const { return num_dependent_ > 0 && dependent_[row] != 0; }

  // ---- solutions ----

  /// Lets QR factors solve the islands in `rows`, which were just decided, until `release_qr`.
  void take_qr(Rows rows);
  void release_qr();
  bool uses_qr() const { return num_qr_ > 0; }
  /// Returns the rows that are left to the factor of S, for GramSolver::set_active; it is empty if all of them are.
  std::span<const char> rows_for_gram();
  /// Computes x = -S^-1 b on the islands that QR solves and leaves the others alone. b and x are [d] and may be one.
  void solve_negative(const double* b, double* x);
  /// Replaces lambda by the solution with the smallest Euclidean norm, by the K of the last decision.
  virtual void minimize_norm(double* lambda) const;

  // ---- residuals ----

  /// Return the largest |row|/|gradient|/unit of rows that do not depend on others, and of those that do; `units`
  /// [neighbourhood].
  double largest_active(const std::vector<double>& rows, const std::vector<double>& units) const;
  double largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const;
  /// Names the dependent row that contradicts the others most, if one lies farther from what they ask of it than
  /// `allowed` times its terms or its scale, and than rounding explains. `rows` are xi, K'v + xi_t or phi + K'w0, and
  /// `sizes` their scale for unit gradients in each neighbourhood. `dimension` is theirs.
  virtual Outcome explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                        double allowed, Dimension dimension) const;

  // ---- reports ----

  /// Lists the dependent rows with the rows that they are made of.
  std::vector<Dependence> list() const;
  /// Lists those that concern constraints, and the rows that join supports alone, in the user's numbers.
  std::vector<RowDependence> list_rows() const;
  /// Describes the rank of K by the last decision. It is d if nothing was decided.
  RankReport report() const;

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
  double gradient_norm(std::size_t row) const { return gradient_norms_.empty() ? 1.0 : gradient_norms_[row]; }
  Dependence translate(const Island& island, Dependence dependence) const;
  std::string describe(const Dependence& found, const char* verb) const;

  const Workspace& work_;
  const Model& model_;
  std::span<const double> inverse_mass_;
  Groups<Index> by_row_;                    // places in the incidences; made at the first decision
  std::vector<Index> local_point_;          // [point] its number in the current island
  std::vector<Island> islands_;             // the decided ones, by rows
  std::vector<char> dependent_, for_gram_;  // [row]
  std::size_t num_dependent_ = 0, num_qr_ = 0;
  std::vector<double> gradient_norms_;  // [d] when the dependent rows changed last; empty before
};

}  // namespace tanor::detail
