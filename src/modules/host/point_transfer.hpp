#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/parallel.hpp"
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

}  // namespace tanor::detail
