#include "evaluate/distance_series.hpp"

#include <algorithm>
#include <cmath>

#include "base/instruction_sets.hpp"

namespace tanor {

namespace {

using Lane = SeriesLane;

/// The products that order k needs of the series of 8 members: force = sum over j = 1 … k of a_j mu_{k-j}, and
/// half_square = 1/2 coefficient k + 2 of a.a without a_{k+2}.
struct Products {
  Lane force[3], half_square;
};

void multiply(const Lane* a, const Lane* mu, int k, Products* products) {
  dispatch([=] {
    Lane x{}, y{}, z{};
    for (int j = 1; j <= k; ++j) {
      const Lane m = mu[k - j];
      x += a[3 * j] * m;
      y += a[3 * j + 1] * m;
      z += a[3 * j + 2] * m;
    }
    products->force[0] = x;
    products->force[1] = y;
    products->force[2] = z;
    // The sum of a_j.a_{k+2-j} over j = 1 … k + 1 takes each pair once.
    Lane square{};
    int j = 1;
    for (; 2 * j < k + 2; ++j) {
      const Lane *const b = a + 3 * j, *const c = a + 3 * (k + 2 - j);
      square += b[0] * c[0] + b[1] * c[1] + b[2] * c[2];
    }
    if (2 * j == k + 2) {
      const Lane* const b = a + 3 * j;
      square += 0.5 * (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    }
    products->half_square = square;
  });
}

}  // namespace

void DistanceSeries::append(const Member& member, const Extra& extra) {
  if (extra.is_there()) extras_.resize(members_.size());
  members_.push_back(member);
  if (extra.is_there() || !extras_.empty()) extras_.push_back(extra);
}

void DistanceSeries::resize(int order) {
  order_ = order;
  lanes_.resize((members_.size() + series_width - 1) / series_width * lanes_per_chunk() * series_width);
}

/// Loads coefficient k of a.
void DistanceSeries::load(SeriesLane* a, std::size_t chunk, int k, std::span<double* const> coefficients,
                          const TimeSeriesTable& table) const {
  const double* const r = coefficients[static_cast<std::size_t>(k)];
  for (std::size_t lane = 0; lane < series_width; ++lane) {
    const std::size_t m = std::min(chunk * series_width + lane, members_.size() - 1);
    const Member& member = members_[m];
    Vec3 d = tanor::load(r, member.j);
    if (member.i >= 0) d = d - tanor::load(r, member.i);
    if (!extras_.empty()) {
      if (k == 0) d = d + extras_[m].offset;
      if (const std::optional<std::size_t> slot = extras_[m].center)
        d = d - Vec3{table[*slot][k], table[*slot + 1][k], table[*slot + 2][k]};
    }
    a[3 * k][lane] = d.x;
    a[3 * k + 1][lane] = d.y;
    a[3 * k + 2][lane] = d.z;
  }
}

void DistanceSeries::advance_chunk(std::size_t chunk, int k, std::span<double* const> coefficients,
                                   const TimeSeriesTable& table, const double* last, double* blocks, double* rows) {
  SeriesLane* const a = reinterpret_cast<SeriesLane*>(lanes_.data()) + chunk * lanes_per_chunk();
  SeriesLane* const mu = a + 3 * (order_ + 1);
  SeriesLane& inverse = mu[order_ + 1];
  if (k == 0) {
    load(a, chunk, 0, coefficients, table);
    const SeriesLane square = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    for (std::size_t lane = 0; lane < series_width; ++lane) inverse[lane] = 1.0 / std::sqrt(square[lane]);
  }
  load(a, chunk, k + 1, coefficients, table);
  const std::size_t first = chunk * series_width, count = std::min(series_width, members_.size() - first);
  if (k > 0) {
    for (std::size_t lane = 0; lane < count; ++lane) mu[k - 1][lane] = last[members_[first + lane].row] * inverse[lane];
  }
  Products products;
  multiply(a, mu, k, &products);
  for (std::size_t lane = 0; lane < count; ++lane) {
    const Member& member = members_[first + lane];
    store(blocks, member.block, {products.force[0][lane], products.force[1][lane], products.force[2][lane]});
    // The row is (a.a - l^2)/(2 |a_0|), and the center's own coefficient k + 2 enters it.
    double xi = products.half_square[lane];
    if (!extras_.empty()) {
      const Extra& extra = extras_[first + lane];
      if (extra.length) {
        const double* const l = table[*extra.length];
        for (int j = 0; j <= k + 2; ++j) xi -= 0.5 * l[j] * l[k + 2 - j];
      }
      for (std::size_t c = 0; c < 3 && extra.center; ++c) xi -= a[c][lane] * table[*extra.center + c][k + 2];
    }
    rows[member.row] = xi * inverse[lane];
  }
}

void DistanceSeries::scale_rates(double s, int terms, double* rates) const {
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const double* const lane = lanes_.data() + m / series_width * lanes_per_chunk() * series_width + m % series_width;
    const auto coefficient = [&](std::size_t number) { return lane[number * series_width]; };
    Vec3 a{};
    for (int k = terms - 1; k >= 0; --k) {
      const auto first = 3 * static_cast<std::size_t>(k);
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

}  // namespace tanor
