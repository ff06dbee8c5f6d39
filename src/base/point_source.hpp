#pragma once

#include <cstddef>

#include "base/parallel.hpp"

namespace tanor {

/// Points on their way into arrays [3n]. Whoever works on some of them brings these before he first reads them and then
/// has them in his first cache: no pass over the memory is made to copy them.
class PointSource {
 public:
  /// Writes the points [first, first + count). Threads bring different ones.
  virtual void bring(std::size_t first, std::size_t count) const = 0;

 protected:
  ~PointSource() = default;
};

/// Brings the points [begin, end), by all threads; null: they are there.
inline void bring(const Parallel& parallel, const PointSource* source, std::size_t begin, std::size_t end) {
  if (source == nullptr || begin >= end) return;
  parallel.for_ranges(end - begin,
                      [&](std::size_t first, std::size_t last) { source->bring(begin + first, last - first); });
}

}  // namespace tanor
