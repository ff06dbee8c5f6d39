#pragma once

#include <span>

#include <tanor/system.hpp>

#include "base/pack.hpp"

namespace tanor::detail::lanes {

/// The rods of a path that are eliminated after its pieces: the last one of each. They are a path themselves.
///
/// A piece is eliminated as if its first rod had the product 1 with the separator before it, so that it needs to know
/// nothing of that one. The true product is `coupling`.
struct BorderFactor {
  Pack3<> first, u;            ///< directions of the first rod of the piece, and of this one
  Pack<> inverse_mass_before;  ///< of the point between the separator before and that first rod
  Pack<> inverse_mass_behind;  ///< of the point behind this one
  Pack<> diagonal, pivot;      ///< S_aa, and what the piece leaves of it
  Pack<> spread;               ///< what the elimination of the piece makes of the product 1
  Pack<> taken, taken_y;       ///< what the piece takes from the separator before, for that product
  Pack<> coupling;
  Pack<> l, inverse_pivot;  ///< of the separators' factor L D L'
  Pack<> spike;             ///< product with the last one
};
/// Such a rod with its numbers of one right side.
struct Border : BorderFactor {
  Pack<> b, y;                      ///< its own, and what the piece leaves of it
  Pack<> x;                         ///< the solution
  Pack<> joined;                    ///< what the points that the piece before moves add to b of the first rod
  Pack<> b_of_first;                ///< the same with what the separator before adds
  Pack3<> force_before;             ///< of the separator before, on the first point
  Pack3<> dw_of_first, dw_of_last;  ///< of the points of the piece
  Pack3<> r_of_first;               ///< of its first point
  Pack3<> r_before, r_behind;       ///< what the piece adds to r of the points before and behind it
  Pack3<> r_joined;                 ///< what the piece before adds to r of the first point
};

/// The separators of one path, which stand in lanes of borders: number q in the lane slots[q] of all.
class Separators {
 public:
  Separators(Border* borders, std::span<const Index> slots, bool is_ring)
      : borders_(borders), slots_(slots), is_ring_(is_ring) {}

  /// Factorizes S, after the pieces, the last one after all others: that of a ring is coupled with the first one; the
  /// coupling is 0 in an open path. Returns the largest S_aa/pivot, infinite if a pivot is not positive.
  double factorize() const;
  /// Lets each piece know r of the points between pieces, to which the pieces on both sides add.
  void join_points() const;
  /// Computes x from y, for S x = -b.
  void solve() const;
  /// Hands x of each one to the piece behind it.
  void hand_on() const;
  /// Returns the largest |K'dw + b|.
  double residual() const;

 private:
  using B = Border;
  /// A separator. Its numbers are members of its border.
  struct One {
    Border* border;
    std::size_t lane;

    double& operator()(Pack<> Border::*number) const { return reinterpret_cast<double*>(&(border->*number))[lane]; }
    Vec3 operator()(Pack3<> Border::*point) const { return lane_of(border->*point, lane); }
    void set(Pack3<> Border::*point, Vec3 value) const { set_lane(&(border->*point), lane, value); }
    Vec3 force() const { return (*this)(&Border::x) * (*this)(&Border::u); }
  };
  std::size_t size() const { return slots_.size(); }
  One at(std::size_t q) const {
    const auto slot = static_cast<std::size_t>(slots_[q]);
    return {borders_ + slot / num_lanes, slot % num_lanes};
  }
  /// Calls visit(before, own) for each one that another one stands before.
  template <class Visit>
  void for_pairs(const Visit& visit) const;

  Border* borders_;
  std::span<const Index> slots_;
  bool is_ring_;
};

}  // namespace tanor::detail::lanes
