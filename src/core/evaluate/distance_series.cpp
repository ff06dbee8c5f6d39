#include "evaluate/distance_series.hpp"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.hpp"

namespace tanor::detail {

void DistanceSeries::append(const Member& member, const Extra& extra) {
  if (extra.is_there()) extras_.resize(members_.size());
  members_.push_back(member);
  if (extra.is_there() || !extras_.empty()) extras_.push_back(extra);
}

void DistanceSeries::resize(int order) {
  order_ = order;
  lanes_.resize((members_.size() + series_width - 1) / series_width * lanes_per_chunk());
}

/// Loads coefficient k of a.
void DistanceSeries::load(Series::Coefficient* c, std::size_t chunk, int k, std::span<double* const> coefficients,
                          const TimeSeriesTable& table) const {
  const double* const r = coefficients[static_cast<std::size_t>(k)];
  for (std::size_t lane = 0; lane < series_width; ++lane) {
    const std::size_t m = std::min(chunk * series_width + lane, members_.size() - 1);
    const Member& member = members_[m];
    Vec3 d = detail::load(r, member.j);
    if (member.i >= 0) d = d - detail::load(r, member.i);
    if (!extras_.empty()) {
      if (k == 0) d = d + extras_[m].offset;
      if (const std::optional<std::size_t> slot = extras_[m].center)
        d = d - Vec3{table[*slot][k], table[*slot + 1][k], table[*slot + 2][k]};
    }
    set_lane(&c[k].a, lane, d);
  }
}

void DistanceSeries::advance_chunk(std::size_t chunk, int k, std::span<double* const> coefficients,
                                   const TimeSeriesTable& table, const double* last, double* blocks, double* rows) {
  Pack<>* const lanes = lanes_.data() + chunk * lanes_per_chunk();
  auto* const c = reinterpret_cast<Series::Coefficient*>(lanes);
  auto* const kept = reinterpret_cast<Series::Known*>(lanes + 4 * (order_ + 1));
  Pack<>& inverse = lanes[4 * (order_ + 2)];
  if (k == 0) {
    load(c, chunk, 0, coefficients, table);
    const Pack<> square = dot(c[0].a, c[0].a);
    for (std::size_t lane = 0; lane < series_width; ++lane) inverse[lane] = 1.0 / std::sqrt(square[lane]);
  }
  load(c, chunk, k + 1, coefficients, table);
  if (k == 0) return;
  const std::size_t first = chunk * series_width, count = std::min(series_width, members_.size() - first);
  for (std::size_t lane = 0; lane < count; ++lane) c[k - 1].mu[lane] = last[members_[first + lane].row] * inverse[lane];
  Series::Known products;
  dispatch([=, to = &products] { *to = Series::multiply(c, k, kept); });
  for (std::size_t lane = 0; lane < count; ++lane) {
    const Member& member = members_[first + lane];
    store(blocks, member.block, {products.force.x[lane], products.force.y[lane], products.force.z[lane]});
    // The row is (a.a - l^2)/(2 |a_0|), and the center's own coefficient k + 2 enters it.
    double xi = products.half_square[lane];
    if (!extras_.empty()) {
      const Extra& extra = extras_[first + lane];
      if (extra.length) {
        const double* const l = table[*extra.length];
        for (int j = 0; j <= k + 2; ++j) xi -= 0.5 * l[j] * l[k + 2 - j];
      }
      if (extra.center) {
        const Vec3 next{table[*extra.center][k + 2], table[*extra.center + 1][k + 2], table[*extra.center + 2][k + 2]};
        xi -= dot(Vec3{c[0].a.x[lane], c[0].a.y[lane], c[0].a.z[lane]}, next);
      }
    }
    rows[member.row] = xi * inverse[lane];
  }
}

void DistanceSeries::scale_rates(double s, int terms, double* rates) const {
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const Pack<>* const lanes = lanes_.data() + m / series_width * lanes_per_chunk();
    const auto coefficient = [&](std::size_t number) { return lanes[number][m % series_width]; };
    Vec3 a{};
    for (int k = terms - 1; k >= 0; --k) {
      const auto first = 4 * static_cast<std::size_t>(k);
      a = s * a + Vec3{coefficient(first), coefficient(first + 1), coefficient(first + 2)};
    }
    rates[members_[m].row] *= norm(a) * coefficient(lanes_per_chunk() - 1);
  }
}

void DistanceSeries::advance(const Parallel& parallel, int k, std::span<double* const> coefficients,
                             const TimeSeriesTable& table, const double* last, double* blocks, double* rows) {
  const std::size_t num_chunks = (members_.size() + series_width - 1) / series_width;
  parallel.for_ranges(
      num_chunks,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t chunk = begin; chunk < end; ++chunk)
          advance_chunk(chunk, k, coefficients, table, last, blocks, rows);
      },
      64);
}

}  // namespace tanor::detail
