#include "assembly/reactions.hpp"

namespace tanor::detail {

ReactionGather::ReactionGather(std::span<const Incidence> incidences, std::size_t num_points)
    : by_point_(num_points, [&](const auto& add) {
        for (const auto& [point, row, block, sign] : incidences) add(point, Entry{row, sign < 0.0 ? ~block : block});
      }) {}

void ReactionGather::reactions(const Parallel& parallel, const double* blocks, const double* lambda,
                               double* out) const {
  parallel.for_ranges(by_point_.size(), [&](std::size_t begin, std::size_t end) {
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
                                const double* scale, const IndexRanges& points, double* out) const {
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
                                  const double* scale, const IndexRanges& points, double* out) const {
  points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) store(out, i, scale[i] * reaction(i, blocks, lambda));
  });
}

void ReactionGather::write_sums(const Parallel& parallel, const double* blocks, double factor, const double* scale,
                                const IndexRanges& points, double* out) const {
  points.for_ranges(parallel, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum{};
      for (const auto [row, block] : by_point_[i])
        sum = block >= 0 ? sum + load(blocks, block) : sum - load(blocks, ~block);
      store(out, i, (factor * scale[i]) * sum);
    }
  });
}

}  // namespace tanor::detail
