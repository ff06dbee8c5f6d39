#pragma once

#include <cstddef>

#include "base/parallel.hpp"

namespace tanor::detail {

/// A source of points that are to be written into arrays [3n]. A caller brings the points that it works on right before
/// it first reads them, and then has them in its first cache. No separate pass over the memory copies them.
class PointSource {
 public:
  /// Writes the points [first, first + count). Threads may call this at the same time for different points.
  virtual void bring(std::size_t first, std::size_t count) const = 0;

 protected:
  ~PointSource() = default;
};

/// Brings the points [begin, end) with all threads. Does nothing if `source` is null, since the points are there then.
inline void bring(const Parallel& parallel, const PointSource* source, std::size_t begin, std::size_t end) {
  if (source == nullptr || begin >= end) return;
  parallel.for_ranges(end - begin,
                      [&](std::size_t first, std::size_t last) { source->bring(begin + first, last - first); });
}

}  // namespace tanor::detail
