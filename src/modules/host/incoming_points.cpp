#include "host/incoming_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/parallel.hpp"
#include "host/point_norms.hpp"

namespace tanor::detail {

void IncomingPoints::bring(std::size_t first, std::size_t count) const {
  double square = 0.0;
  for (const Array& array : std::span(arrays_).first(count_)) {
    for (std::size_t k = 0; k < count; k += PointTransfer::piece) {
      const double of_piece = bring_piece(array, first + k, std::min(PointTransfer::piece, count - k));
      square = larger(square, of_piece);
    }
  }
  largest_.see(square);
}

/// Copies a piece of the array. Returns the largest square of its points if that is measured, else 0.
double IncomingPoints::bring_piece(const Array& array, std::size_t first, std::size_t count) const {
  double* const own = array.to + 3 * first;
  if (!array.factors.empty()) {
    if (first >= array.factors.size()) return 0.0;
    const std::size_t size = std::min(count, array.factors.size() - first);
    const double* const x = transfer_.load(array.from, first, size, own);
    return detail::scale(x, &array.factors[first], size, own);
  }
  const double* const x = transfer_.load(array.from, first, count, own);
  if (x == own) return array.is_measured ? largest_square(own, count) : 0.0;
  if (array.is_measured) return detail::copy(x, count, own);
  std::memcpy(own, x, 3 * sizeof(double) * count);
  return 0.0;
}

void LargestSquare::see(double square) {
  double seen = value_.load(std::memory_order_relaxed);
  while ((square > seen || std::isnan(square)) && !std::isnan(seen)) {
    if (value_.compare_exchange_weak(seen, square, std::memory_order_relaxed)) return;
  }
}

double IncomingPoints::largest() const {
  return std::sqrt(largest_.value());
}

}  // namespace tanor::detail
