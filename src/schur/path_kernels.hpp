#pragma once

#include <cstddef>

#include "base/vec3.hpp"

/// \file Arithmetic of PathSolver on a few rods at a time that follow one another: loops over neighbours in memory,
/// compiled for each instruction set, and the recurrences along the path, which are scalar.
///
/// Directions g point along the path, whatever the blocks of K do: block = sign g.
namespace tanor::paths {

/// Rods that are worked on at once: few enough for the first cache, many enough for the loops.
inline constexpr std::size_t chunk_size = 128;

/// Consecutive rows of S on their way through the elimination. Row k is joined to row k - 1 at its left point and to
/// row k + 1 at its right one. Slot k + 1 belongs to row k: slots 0 and count + 1 to the rows next to the chunk.
struct Chunk {
  std::size_t count = 0;
  double inverse_mass[chunk_size + 1];  // [k] of the left point of row k: 0 at a support or beyond an end
  double diagonal[chunk_size];          // S_kk
  double coupling[chunk_size];          // S with the row eliminated before
  double numerator[chunk_size], denominator[chunk_size];           // of the inverse pivot
  double x[chunk_size + 2], y[chunk_size + 2], z[chunk_size + 2];  // [slot] g
  double inverse_pivot[chunk_size + 2];                            // [slot]

  void set_direction(std::size_t slot, Vec3 g) {
    x[slot] = g.x;
    y[slot] = g.y;
    z[slot] = g.z;
  }
  Vec3 direction(std::size_t slot) const { return {x[slot], y[slot], z[slot]}; }
};

/// Rods between consecutive points from the first of r, v and w0 on.
struct Rods {
  const double* r;
  const double* v;          ///< where it is asked for
  const double* w0;         ///< null: the same for all, K'w0 = 0
  const double* offset;     ///< [3k] along the path; null: none
  const signed char* sign;  ///< [k]
  std::size_t count;
};
/// g into the chunk's slots from `slot` on; blocks [3k] and b = phi + K'w0 [k] with constant lengths.
void evaluate(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks, double* b);

/// Finds g alone.
void evaluate_directions(const Rods& rods, std::size_t slot, Chunk* chunk, double* blocks);
/// xi = |a| - length [k]; returns the largest |xi|/length, NaN where any number is.
double evaluate_values(const Rods& rods, const double* lengths, double* xi);
/// g.v [k]
void evaluate_rates(const Rods& rods, double* rates);
/// Finds b alone.
void evaluate_right_side(const Rods& rods, double* b);

/// Takes g from blocks.
void load_directions(const double* blocks, const signed char* sign, Chunk* chunk);

/// Finds S_kk, and the coupling with the row on the left or on the right, which was eliminated before.
enum class Towards { Right, Left };
void assemble(Towards towards, Chunk* chunk);

/// Memory that the next chunks want: it is fetched line by line while dependent operations wait for each other, since a
/// burst of misses would stop everything.
class Upcoming {
 public:
  void clear() { count_ = next_ = 0, at_ = end_ = nullptr; }
  void add(const void* from, std::size_t bytes) {
    if (bytes > 0) spans_[count_++] = {static_cast<const char*>(from), static_cast<const char*>(from) + bytes};
  }
  /// Fetches a few more lines, if there are any.
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

/// The recurrence of determinants over a half, D_k = S_kk D_{k-1} - S_{k,k-1}^2 D_{k-2}; pivots are ratios of
/// consecutive ones. No division stands in the way; both are scaled by the same number now and then.
struct Determinants {
  double before = 0.0, last = 1.0;
};
/// Numerators and denominators of two chunks, `right` from its first row on and `left` from its last one back; either
/// may be empty.
void find_pivots(Chunk* right, Determinants* to_right, Chunk* left, Determinants* to_left, Upcoming* upcoming);

/// Smallest and largest S_kk/pivot.
struct PivotRange {
  double smallest = 1.0, largest = 1.0;
};
/// Inverse pivots 1/d, and factors: coupling/d of the row before.
void finish_pivots(Towards towards, Chunk* chunk, double* inverse_pivots, double* factors, PivotRange* range);

/// Forward substitution y_k = b_k - factor_k y_before over n_right rows upwards and n_left rows downwards, `last` each:
/// y of the row before, and of the last one.
struct Substitution {
  const double *b, *factors;
  double* y;
  std::size_t count;
  double last;
};
void substitute_inwards(Substitution* right, Substitution* left);

/// Back substitution lambda_k = -y_k/d_k - factor lambda_before, with the factor of the row before, over rows
/// downwards (`left`) and upwards (`right`); lambda stands in y's place.
struct BackSubstitution {
  const double *inverse_pivots, *factors;
  double* lambda;
  std::size_t count;
  double factor, last;  ///< of the row before
};
void substitute_outwards(BackSubstitution* left, BackSubstitution* right, Upcoming* upcoming);

/// Points between `count` + 1 consecutive rods: dw = M^-1 K lambda of each, w := w0 + dw (`uniform`: of all), and the
/// largest |K'dw + b| of the rods between two of them. Returns dw of the first and of the last point.
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

/// Sum of x_k y_k d_k.
double sum_of_products(const double* x, const double* y, const double* d, std::size_t count);

/// y += factor x
void add(double factor, const double* x, std::size_t count, double* y);

/// max(so_far, |x_k|); NaN where any number is.
double largest_magnitude(const double* x, std::size_t count, double so_far);

}  // namespace tanor::paths
