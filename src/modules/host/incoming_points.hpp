#pragma once

#include <array>
#include <atomic>
#include <span>

#include <tanor/constrainer.hpp>

#include "dynamics/instant.hpp"
#include "host/point_transfer.hpp"

namespace tanor::detail {

/// The largest of the squares that threads find, or NaN if any of them is NaN.
class LargestSquare {
 public:
  void see(double square);
  double value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> value_{0.0};
};

/// Arrays of a host that are copied into arrays in the inner order. Whoever works on some points copies those points.
class IncomingPoints final : public GivenMotion {
 public:
  /// `transfer` outlives the object, as does `largest`, which keeps the largest measured square.
  IncomingPoints(const PointTransfer& transfer, LargestSquare* largest) : transfer_(transfer), largest_(*largest) {}

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

}  // namespace tanor::detail
