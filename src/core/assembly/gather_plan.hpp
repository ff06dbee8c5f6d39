#pragma once

#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/family.hpp"
#include "evaluate/product.hpp"

namespace tanor::detail {

/// Returns the incidences of points with a nonzero weight, grouped by point.
std::vector<Incidence> group_by_point(std::span<const Incidence> incidences, std::span<const double> weights);

/// Lists all products of one triangle (row >= column) in a fixed order. GatherPlan joins products of the same two
/// blocks, such as those at the two ends of a rod. `incidences` are grouped by point, `weights` has one number a point,
/// and `first_row` is subtracted from the rows. Throws std::length_error if there are more than 2^31 - 1 products.
std::vector<Product> list_products(std::span<const Incidence> incidences, std::span<const double> weights,
                                   int first_row);

enum class Triangle { Lower, Upper };

/// Writes S straight into the triangle that the factorization reads, with its rows in the order of elimination. Every
/// entry is a gather over the blocks of K: there is no search and no sparse product. A plan is made once for each
/// topology.
///
///   values[slot] = scale_i scale_j * sum over its products of weight * (g_a . g_b)
///
/// S is scaled to a unit diagonal: scale_i = 1/sqrt(S_ii). Where the lengths of the blocks never change, the scale is
/// part of the weights from the start, so that results do not depend on the states that were seen before.
class GatherPlan {
 public:
  /// `place` gives the position of each row in the elimination; if it is empty, the rows keep their order.
  /// `squared_norms` has |g|^2 of each block, and is empty if these change.
  GatherPlan(std::span<const Product> products, std::size_t num_rows, std::span<const int> place, Triangle triangle,
             std::span<const double> squared_norms = {});

  const std::vector<int>& column_start() const { return start_; }
  const std::vector<int>& rows() const { return rows_; }

  /// Writes the scaled entries of S. A slot costs 6 numbers read, 1 written and 6 flops, and without constant norms 2
  /// more reads and flops. Every number of threads gives the same bits.
  void assemble(const double* blocks, double* values, const Parallel& parallel = Parallel(1));

  /// Returns scale_i of the last `assemble`, in the order of elimination.
  const std::vector<double>& scale() const { return scale_; }

 private:
  struct Term {
    int block_a, block_b;
    double weight;
  };
  struct ExtraTerm {
    int slot;
    Term term;
  };
  struct Placed {
    int row, product;
  };
  void append_column(std::span<const Product> products, std::span<Placed> column);
  void scale_weights();

  std::vector<int> start_, rows_;
  std::vector<int> diagonal_;      // [column] its slot
  std::vector<Term> terms_;        // [slot] the first product; nearly always the only one
  std::vector<ExtraTerm> extras_;  // the further products, by slot
  std::vector<double> scale_;
  bool weights_are_scaled_ = false;
};

}  // namespace tanor::detail
