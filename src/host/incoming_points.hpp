#pragma once

#include <array>
#include <atomic>
#include <span>

#include <tanor/constrainer.hpp>

#include "dynamics/instant.hpp"
#include "host/point_transfer.hpp"

namespace tanor {

/// The largest of the squares that threads find; NaN where any of them is.
class LargestSquare {
 public:
  void see(double square);
  double value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> value_{0.0};
};

/// Arrays of a host on their way into arrays in the inner order: whoever works on some points brings them there.
class IncomingPoints final : public GivenMotion {
 public:
  /// Transfer and `largest`, in which what is measured is kept, outlive the points.
  IncomingPoints(const PointTransfer& transfer, LargestSquare* largest) : transfer_(transfer), largest_(*largest) {}

  /// to [3n] := the host's points.
  void copy(const ConstPointArray& from, double* to) { arrays_[count_++] = {from, to, {}, false}; }
  /// The same; the largest of them is wanted.
  void measure(const ConstPointArray& from, double* to) { arrays_[count_++] = {from, to, {}, true}; }
  /// to := factor_i times the host's points, as far as there are factors; the largest of the products is wanted.
  void scale(const ConstPointArray& from, std::span<const double> factors, double* to) {
    arrays_[count_++] = {from, to, factors, true};
  }

  void bring(std::size_t first, std::size_t count) const override;
  /// Of those that were brought; NaN where any is not finite.
  double largest() const override;

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
  LargestSquare& largest_;
  std::array<Array, most_arrays> arrays_;
  std::size_t count_ = 0;
};

}  // namespace tanor
