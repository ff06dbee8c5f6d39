#include "assembly/reactions.hpp"

#include <numeric>

namespace tanor {

ReactionGather::ReactionGather(std::span<const Incidence> incidences, std::size_t num_points)
    : start_(num_points + 1, 0), entries_(incidences.size()) {
  for (const Incidence& incidence : incidences) ++start_[incidence.point + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  std::vector<Index> next(start_.begin(), start_.end() - 1);
  for (const auto& [point, row, block, sign] : incidences) {
    entries_[static_cast<std::size_t>(next[point]++)] = {row, sign < 0.0 ? ~block : block};
  }
}

void ReactionGather::reactions(const Parallel& parallel, const double* blocks, const double* lambda,
                               double* out) const {
  parallel.for_ranges(start_.size() - 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(out, i, reaction(i, blocks, lambda));
  });
}

void ReactionGather::add_scaled(const Parallel& parallel, const double* blocks, const double* lambda,
                                const double* scale, std::size_t count, double* out) const {
  parallel.for_ranges(count, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(out, i, load(out, i) + scale[i] * reaction(i, blocks, lambda));
  });
}

void ReactionGather::add_scaled(const Parallel& parallel, const double* blocks, const double* lambda,
                                const double* scale, const Runs& points, double* out) const {
  points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(out, i, load(out, i) + scale[i] * reaction(i, blocks, lambda));
  });
}

void ReactionGather::write_scaled(const Parallel& parallel, const double* blocks, const double* lambda,
                                  const double* scale, std::size_t count, double* out) const {
  parallel.for_ranges(count, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(out, i, scale[i] * reaction(i, blocks, lambda));
  });
}

void ReactionGather::write_scaled(const Parallel& parallel, const double* blocks, const double* lambda,
                                  const double* scale, const Runs& points, double* out) const {
  points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(out, i, scale[i] * reaction(i, blocks, lambda));
  });
}

}  // namespace tanor
