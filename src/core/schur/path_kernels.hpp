#pragma once

#include <cstddef>

#include "base/vec3.hpp"
#include "plan/thresholds.hpp"

/// \file Arithmetic of PathSolver on a few consecutive rods at a time: loops over neighbours in memory, compiled for
/// each instruction set, and the recurrences along the path, which are scalar.
///
/// Directions g point along the path, whatever the signs of the blocks of K: block = sign g.
namespace tanor::detail::paths {

/// Number of rods that are worked on at once.
inline constexpr std::size_t chunk_size = plan::rods_of_chunk;

/// Consecutive rows of S during the elimination. Row k is joined to row k - 1 at its left point and to row k + 1 at its
/// right one. Slot k + 1 belongs to row k; slots 0 and count + 1 belong to the rows next to the chunk.
struct Chunk {
  std::size_t count = 0;
  double inverse_mass[chunk_size + 1];  // [k] for the left point of row k; 0 at a support or beyond an end
  double diagonal[chunk_size];          // S_kk
  double coupling[chunk_size];          // S with the row eliminated before
  double numerator[chunk_size], denominator[chunk_size];           // those of the inverse pivot
  double x[chunk_size + 2], y[chunk_size + 2], z[chunk_size + 2];  // [slot] g
  double inverse_pivot[chunk_size + 2];                            // [slot]

  void set_direction(std::size_t slot, Vec3 g) {
    x[slot] = g.x;
    y[slot] = g.y;
    z[slot] = g.z;
  }
  Vec3 direction(std::size_t slot) const { return {x[slot], y[slot], z[slot]}; }
};

/// Rods between consecutive points. r, v and w0 begin at the first point.
struct Rods {
  const double* r;
  const double* v;          ///< null if it is not needed
  const double* w0;         ///< null if it is the same for all, so that K'w0 = 0
  const double* offset;     ///< [3k] along the path; null if there are none
  const signed char* sign;  ///< [k]
  std::size_t count;
};
/// Evaluates g into the chunk's slots from `slot` on, blocks [3k] and b = phi + K'w0 [k] with constant lengths.
void evaluate(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks, double* b);

/// Evaluates g alone.
void evaluate_directions(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks);
/// Evaluates xi = |a| - length [k]. Returns the largest |xi|/length, or NaN if any number is not finite.
double evaluate_values(const Rods& rods, const double* lengths, double* xi);
/// Evaluates g.v [k]. Returns the largest magnitude, or NaN if any number is not finite.
double evaluate_rates(const Rods& rods, double* rates);
/// Evaluates b alone.
void evaluate_right_side(const Rods& rods, double* b);

/// Takes g from blocks.
void load_directions(const double* blocks, const signed char* sign, Chunk* chunk);

/// Finds S_kk and the coupling with the row eliminated before: the one on the left if the elimination goes `Right`.
enum class Towards { Right, Left };
void assemble(Towards towards, Chunk* chunk);

/// Memory that the next chunks need. It is prefetched line by line while dependent operations wait for each other,
/// since a burst of misses would stop everything.
class Upcoming {
 public:
  void clear() { count_ = next_ = 0, at_ = end_ = nullptr; }
  void add(const void* from, std::size_t bytes) {
    if (bytes > 0) spans_[count_++] = {static_cast<const char*>(from), static_cast<const char*>(from) + bytes};
  }
  /// Prefetches a few more lines, if there are any.
  [[gnu::always_inline]] void fetch() {
    for (std::size_t k = 0; k < lines_a_step; ++k, at_ += line) {
      if (at_ >= end_) {
        if (next_ == count_) return;
        at_ = spans_[next_].begin;
        end_ = spans_[next_++].end;
      }
      __builtin_prefetch(at_, 0, 2);
    }
  }

 private:
  static constexpr std::size_t most_spans = 20, line = 64, lines_a_step = 4;
  struct Span {
    const char *begin, *end;
  };
  Span spans_[most_spans];
  std::size_t count_ = 0, next_ = 0;
  const char *at_ = nullptr, *end_ = nullptr;
};

/// The recurrence of determinants over a half, D_k = S_kk D_{k-1} - S_{k,k-1}^2 D_{k-2}. Pivots are ratios of
/// consecutive determinants, so that no operation waits for a division. Both are scaled by the same number now and
/// then.
struct Determinants {
  double before = 0.0, last = 1.0;
};
/// Computes numerators and denominators of the inverse pivots of two chunks, `right` from its first row on and `left`
/// from its last one back. Either chunk may be empty.
void find_pivots(Chunk* right, Determinants* to_right, Chunk* left, Determinants* to_left, Upcoming* upcoming);

/// The smallest and the largest S_kk/pivot.
struct PivotRange {
  double smallest = 1.0, largest = 1.0;
};
/// Computes inverse pivots 1/d, and factors: coupling/d of the row before.
void finish_pivots(Towards towards, Chunk* chunk, double* inverse_pivots, double* factors, PivotRange* range);

/// The forward substitution y_k = b_k - factor_k y_before, over the rows of `right` upwards and of `left` downwards.
/// `last` is y of the row before, then y of the last row.
struct Substitution {
  const double *b, *factors;
  double* y;
  std::size_t count;
  double last;
};
void substitute_forward(Substitution* right, Substitution* left);

/// The back substitution lambda_k = -y_k/d_k - factor lambda_before, with the factor of the row before, over rows
/// downwards (`left`) and upwards (`right`). lambda replaces y.
struct BackSubstitution {
  const double *inverse_pivots, *factors;
  double* lambda;
  std::size_t count;
  double factor, last;  ///< those of the row before
};
void substitute_backward(BackSubstitution* left, BackSubstitution* right, Upcoming* upcoming);

/// The points between `count` + 1 consecutive rods. `accelerate` computes dw = M^-1 K lambda of each, w := w0 + dw (w0
/// is `uniform` unless that is null), and the largest |K'dw + b| of the rods between two of them. It returns dw of the
/// first and of the last point.
struct Between {
  const double *blocks, *lambda, *b, *inverse_mass;
  const signed char* sign;
  std::size_t count;
  const Vec3* uniform;
  double* w;
};
struct Ends {
  Vec3 first, last;
};
Ends accelerate(const Between& between, double* residual);

/// Returns the sum of x_k y_k d_k.
double sum_of_products(const double* x, const double* y, const double* d, std::size_t count);

/// Computes y += factor x.
void add(double factor, const double* x, std::size_t count, double* y);

/// Returns max(so_far, |x_k|), or NaN if any x_k is not finite.
double largest_magnitude(const double* x, std::size_t count, double so_far);

}  // namespace tanor::detail::paths
