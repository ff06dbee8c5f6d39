#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/block3.hpp"
#include "evaluate/family.hpp"

namespace tanor::detail {

/// The compliance of a row: multiplier = -stiffness xi - damping dxi/dt.
struct Compliance {
  double stiffness, damping;
};

/// Writes Newton's matrix of an implicit step straight into the pattern that the factorization reads. The unknowns are
/// 3 numbers for each moving point, then one for each row:
///
///   [ N  -K ]     N = a M - b df/dv - c (df/dr + d(K lambda)/dr)
///   [ K'  E ]     E = 1/(b damping + c stiffness), diagonal
///
/// E is 0 for the rows of constraints. Where rows may depend on each other, E is a tiny compliance instead, so that the
/// matrix has a factor. Newton's iteration then still converges if the rows are consistent, but slowly if mass ratios
/// come near the inverse of the compliance. A plan is made once for each topology; every entry knows its slot.
class NewtonPlan {
 public:
  /// Supports, which are the points from `masses.size()` on, take no part. The first rows are those of constraints;
  /// `compliances` belong to the rows behind them.
  NewtonPlan(std::span<const double> masses, std::size_t num_rows, std::span<const Coupling> couplings,
             std::span<const Influence> influences, std::span<const Incidence> incidences,
             std::span<const Compliance> compliances, bool rows_may_depend);

  /// Returns the pattern by columns, with increasing rows.
  const std::vector<int>& column_start() const { return start_; }
  const std::vector<int>& rows() const { return rows_; }

  template <class T>
  struct Weights {
    T mass, velocity, position;  // a, b, c
  };
  struct Values {
    const Block3 *point_positions, *point_velocities;          // [moving point]
    const Block3 *coupling_positions, *coupling_velocities;    // [coupling]
    const Block3 *influence_positions, *influence_velocities;  // [influence]
    const double* blocks;                                      // blocks of K
  };
  /// Writes the entries of the matrix, for T = double or std::complex<double>.
  template <class T>
  void assemble(const Weights<T>& weights, const Values& values, T* entries) const;

  /// Adds (df/dr + d(K lambda)/dr) x to y on moving points, 3 numbers a point.
  void add_stiffness(const Values& values, const double* x, double* y) const;

 private:
  using Columns = std::array<int, 3>;  // slots of a block's first entry in each of its three columns

  struct CoupledPoints {
    Coupling points;  // -1 for an end that does not move
    Columns ij, ji;   // df_i/dr_j and df_j/dr_i
  };
  struct InfluencedPoint {
    Influence points;  // both points move
    std::size_t number;
    Columns at;
  };
  struct RowEntry {
    int point, row, block;
    double sign;
    int below;           // slot of the first entry of K; the others follow
    Columns transposed;  // slots of K'
  };

  int first_row() const { return 3 * static_cast<int>(masses_.size()); }
  void list_entries(std::span<const Coupling> couplings, std::span<const Influence> influences,
                    std::span<const Incidence> incidences);
  void make_pattern();
  void find_slots();

  std::vector<double> masses_;
  std::vector<Columns> own_;  // [moving point]
  std::vector<CoupledPoints> couplings_;
  std::vector<InfluencedPoint> influences_;
  std::vector<RowEntry> entries_;
  std::vector<int> diagonal_;  // [row] slot
  std::vector<Compliance> compliances_;
  bool rows_may_depend_;
  std::vector<int> start_, rows_;
};

}  // namespace tanor::detail
