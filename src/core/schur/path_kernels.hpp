#pragma once

#include <cstddef>

#include <tanor/system.hpp>

#include "base/pack.hpp"

/// \file Arithmetic of eight pieces of a path of rods, side by side in lanes. Rod i of a piece joins its points i and
/// i + 1, and the last rod is a separator (path_separators.hpp); pieces have it last of all. Each lane is computed by
/// itself, and narrow registers take some lanes after the others. See instruction_sets.hpp.
namespace tanor::detail::paths {

/// Arrays of points or directions that are needed next, eight a rod of the lanes. They are prefetched little by little,
/// since a burst of misses would stop everything.
struct Upcoming {
  const double* arrays[3] = {nullptr, nullptr, nullptr};

  [[gnu::always_inline]] void fetch(std::size_t i) const {
    for (const double* const array : arrays) {
      for (std::size_t line = 0; array != nullptr && line < 3; ++line)
        __builtin_prefetch(array + num_lanes * (3 * i + line), 0, 2);
    }
  }
};
/// The motion of the points [length + 1] of pieces.
struct Motion {
  const Pack3<>*r = nullptr, *v = nullptr;
  const Pack3<>* w0 = nullptr;             ///< null if all points have the same
  const Pack3<>* offset = nullptr;         ///< [length] from point i to i + 1; null if there are none
  const Pack<>* length_changes = nullptr;  ///< [length] l' or l''; null if 0
  Upcoming upcoming;
};
/// The rods of pieces and the factor of S = K'M^-1K there, S = L D L'.
struct Pieces {
  std::size_t length;
  const Pack<>* inverse_mass;  ///< [length + 1] 1/kg
  Pack3<>* u;                  ///< [length] directions
  Pack<>*l, *inverse_pivot;    ///< [length] L of the next row, 1/D; the last ones are not set
  Pack<>*b, *y;                ///< [length] a right side, and y = -L^-1 b
};
/// The numbers that separators get from their pieces; see Separator.
struct Border {
  Pack<> diagonal, pivot, spread, taken, taken_y, y;
};
/// The largest numbers that were found.
struct Found {
  Pack<> largest_inverse{};  ///< S_aa/pivot, infinite if a pivot is not positive
  Largest row;               ///< |b| or a violation
  Largest residual;          ///< |K'dw + b|

  void include(const Found& other) {
    largest_inverse = other.largest_inverse > largest_inverse ? other.largest_inverse : largest_inverse;
    row.include(other.row);
    residual.include(other.residual);
  }
};

/// Evaluates u and b = phi + K'w0 of all rods.
void evaluate(const Pieces& pieces, const Motion& motion, Found* found);
/// Evaluates u alone.
void find_directions(const Pieces& pieces, const Motion& motion);
/// Evaluates xi in b's place for rods of the lengths [length], and |xi|/length.
void evaluate_values(const Pieces& pieces, const Motion& motion, const Pack<>* lengths, Found* found);
/// Evaluates K'v + xi_t in b's place.
void evaluate_rates(const Pieces& pieces, const Motion& motion, Found* found);

/// Eliminates the rods but for the separators.
void eliminate(const Pieces& pieces, Border* border, Found* found);
/// Evaluates, eliminates, and computes y in one pass, so that one rod's evaluation runs while another one's pivot is
/// waited for.
void evaluate_and_eliminate(const Pieces& pieces, const Motion& motion, Border* border, Found* found);
/// Computes y, and y and taken_y of the separators.
void substitute_forward(const Pieces& pieces, Border* border);
/// Computes x [length]. `border` has x of the separators in `y`, the couplings with those before in `spread`, and x of
/// those in `taken_y`.
void substitute_backward(const Pieces& pieces, const Border& border, Pack<>* spikes, Pack<>* x);
/// Computes dw [length] = M^-1 K x of each point but the last, with the force of the rods before, and the largest
/// |K'dw + b| of all rods but the separators unless `found` is null.
void accelerate(const Pieces& pieces, const Pack<>* x, const Pack3<>& force_before, const Upcoming& upcoming,
                Pack3<>* dw, Found* found);

/// Computes dw += w0 [length].
void move(std::size_t length, Vec3 w0, Pack3<>* dw);

}  // namespace tanor::detail::paths
