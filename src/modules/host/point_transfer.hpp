#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/parallel.hpp"
#include "dynamics/instant.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Transfers points between the arrays of a host and arrays in the inner order.
class PointTransfer {
 public:
  static constexpr std::size_t piece = 128;  ///< points of which several arrays fit into the first cache

  /// Both arguments outlive the transfer. The host's points are those of the system, until `set_points`.
  PointTransfer(const Numbering& numbering, const Parallel& parallel);
  /// Sets the host's number of each point of the system, in the system's order.
  void set_points(std::span<const Index> of_system);

  /// Returns the host's points in place if they are packed in the inner order, else null.
  template <class Number>
  Number* straight(const BasicPointArray<Number>& array) const {
    return is_straight(array) ? array.data + (host_point_.empty() ? 0 : 3 * static_cast<std::ptrdiff_t>(host_point_[0]))
                              : nullptr;
  }
  /// Returns some of the host's points, one after the other, in place or copied to `scratch` [3 count].
  const double* load(const ConstPointArray& array, std::size_t first, std::size_t count, double* scratch) const;
  /// Copies the host's points to `to` [3n].
  void gather(const ConstPointArray& from, double* to) const;
  /// Does the same for the inner points from `first` on.
  void gather_last(const ConstPointArray& from, std::size_t first, double* to) const;
  /// Returns true if any bit of the host's points differs from `than` [3n].
  bool differ(const ConstPointArray& from, const double* than) const;
  /// Writes `from` [3n] to the host's points, for the first `count` inner points. Returns the largest |change|.
  double scatter(const double* from, std::size_t count, const PointArray& to) const;
  /// Returns the largest |x - y| over the first `count` inner points.
  double largest_change(const double* x, const double* y, std::size_t count) const;
  /// Does the same as `scatter` without measuring the change.
  void write(const double* from, std::size_t count, const PointArray& to) const;
  /// Adds `moves` [3n] to the host's points, likewise. Returns the largest |move|.
  double add(const double* moves, std::size_t count, const PointArray& to) const;
  /// Writes `from` [9n], nine numbers each, to the host's points, likewise.
  void scatter_tensors(const double* from, std::size_t count, const PointArray& to) const;
  /// Adds `from` [width n], `width` numbers each, to the host's points, for the inner points from `first` on.
  void add_last(const double* from, std::size_t first, std::size_t width, const PointArray& to) const;
  /// Returns the host's number of an inner point.
  Index host_point(std::size_t inner) const { return host_point_[inner]; }

 private:
  /// Calls at(i, address of the host's point) for the inner points [first, first + count).
  template <class Number, class At>
  void visit(const BasicPointArray<Number>& array, std::size_t width, std::size_t first, std::size_t count,
             const At& at) const;
  bool is_straight(const ConstPointArray& array) const;
  void store(const double* from, std::size_t first, std::size_t count, const PointArray& array) const;
  /// Returns the largest piece(first, count) over pieces of the first `count` inner points. Several arrays of a piece
  /// fit into the first cache.
  template <class Piece>
  double largest(std::size_t count, const Piece& piece) const;

  const Numbering& numbering_;
  const Parallel& parallel_;
  std::vector<Index> host_point_;  // [inner point]
  bool is_natural_ = false;        // the inner order is the host's, from its point `host_point_[0]` on
};

/// Arrays of a host that are copied into arrays in the inner order. Whoever works on some points copies those points.
class IncomingPoints final : public GivenMotion {
 public:
  /// `transfer` outlives the object.
  explicit IncomingPoints(const PointTransfer& transfer) : transfer_(transfer) {}

  /// Copies the host's points to `to` [3n].
  void copy(const ConstPointArray& from, double* to) { arrays_[count_++] = {from, to, {}, false}; }
  /// Does the same and measures the largest of them.
  void measure(const ConstPointArray& from, double* to) { arrays_[count_++] = {from, to, {}, true}; }
  /// Sets `to` to factor_i times the host's points, for as many points as there are factors, and measures the largest
  /// product.
  void scale(const ConstPointArray& from, std::span<const double> factors, double* to) {
    arrays_[count_++] = {from, to, factors, true};
  }

  void bring(std::size_t first, std::size_t count) const override;
  /// Returns the largest measured length of the points copied so far, or NaN if any is not finite.
  double largest() const override { return std::sqrt(largest_.load(std::memory_order_relaxed)); }

 private:
  struct Array {
    ConstPointArray from;
    double* to = nullptr;
    std::span<const double> factors;
    bool is_measured = false;
  };
  static constexpr std::size_t most_arrays = 3;

  double bring_piece(const Array& array, std::size_t first, std::size_t count) const;

  const PointTransfer& transfer_;
  std::array<Array, most_arrays> arrays_;
  std::size_t count_ = 0;
  mutable std::atomic<double> largest_{0.0};  // square that threads have found; NaN if one of them is NaN
};

/// Points of a host that a call moves. Those that are packed in the inner order may be moved in place, and a copy keeps
/// what they were; else the copy is moved, and written to the host once the call has succeeded.
class MovedPoints {
 public:
  /// `transfer` outlives the object. If `keeps_copy` is true, nothing is moved in place.
  MovedPoints(const PointTransfer& transfer, std::size_t size, bool keeps_copy)
      : transfer_(transfer), keeps_copy_(keeps_copy), copy_(size) {}

  /// The points that are moved, [3n] in the inner order.
  double* data() { return moved_; }
  /// Moves the copy, which the caller fills. Returns it.
  double* use_copy();
  /// Moves the host's points. `incoming` copies them, and measures the largest one if `measures` is true.
  void take(const PointArray& host, bool in_place, IncomingPoints* incoming, bool measures = false);
  /// Tells that points were moved, all of which had been copied before.
  void note_moved() { has_moved_ = true; }
  /// Leaves the first `count` inner points in the host's array as they were moved. Returns the largest change if that
  /// is wanted, else 0.
  double give_back(const PointArray& host, std::size_t count, bool measures);
  /// Undoes a move in place. Does nothing after `give_back`.
  void restore();

 private:
  const PointTransfer& transfer_;
  const bool keeps_copy_;
  std::vector<double> copy_;
  double* moved_ = copy_.data();  // that, or the host's
  bool has_moved_ = false;
};

}  // namespace tanor::detail
