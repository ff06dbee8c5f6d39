#include "evaluate/point_sums.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"

namespace tanor::detail {

namespace {

/// Fewer points are added one by one (found by bench/compare_builds.py: chain.json by rattle, 10 rods; nothing between
/// these and 256 was tried).
constexpr std::size_t fewest_in_lanes = 32;

/// Returns the end of the packs of points from `begin` on.
[[gnu::always_inline]] inline std::size_t end_of_packs(std::size_t begin, std::size_t end) {
  return end - begin < fewest_in_lanes ? begin : end - (end - begin) % num_lanes;
}

[[gnu::always_inline]] inline double add_lanes(const Pack<>& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5])) + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]));
}

[[gnu::always_inline]] inline double sum_squares(const double* mass, const double* v, std::size_t begin,
                                                 std::size_t end) {
  Pack<> sums{};
  const std::size_t packs_end = end_of_packs(begin, end);
  for (std::size_t i = begin; i < packs_end; i += num_lanes) {
    Pack<> x, y, z;
    load_points(v + 3 * i, &x, &y, &z);
    sums += pack_at(mass + i) * (x * x + y * y + z * z);
  }
  double result = add_lanes(sums);
  for (std::size_t i = packs_end; i < end; ++i) result += mass[i] * dot(load(v, i), load(v, i));
  return result;
}

[[gnu::always_inline]] inline Vec3 sum_moments(const double* mass, const double* r, std::size_t begin,
                                               std::size_t end) {
  Pack<> sum_x{}, sum_y{}, sum_z{};
  const std::size_t packs_end = end_of_packs(begin, end);
  for (std::size_t i = begin; i < packs_end; i += num_lanes) {
    Pack<> x, y, z;
    load_points(r + 3 * i, &x, &y, &z);
    const Pack<> m = pack_at(mass + i);
    sum_x += m * x;
    sum_y += m * y;
    sum_z += m * z;
  }
  Vec3 result{add_lanes(sum_x), add_lanes(sum_y), add_lanes(sum_z)};
  for (std::size_t i = packs_end; i < end; ++i) result = result + mass[i] * load(r, i);
  return result;
}

/// Returns what part(begin, end) adds up, over at most 64 parts in their order. How many there are follows from the
/// count alone, so that the sum does not depend on the threads.
template <class Sum, class Part>
Sum add_parts(const Parallel& parallel, std::size_t count, const Part& part) {
  constexpr std::size_t most_parts = 64, grain = 2048, least_points = 256;
  const std::size_t num_parts = std::clamp<std::size_t>(count / least_points, 1, most_parts);
  if (num_parts == 1) return part(0, count);
  std::array<Sum, most_parts> sums;
  parallel.for_ranges(
      num_parts,
      [&](std::size_t begin, std::size_t end) {
        dispatch([=, &part, &sums] {
          for (std::size_t p = begin; p < end; ++p) sums[p] = part(count * p / num_parts, count * (p + 1) / num_parts);
        });
      },
      std::max<std::size_t>(1, num_parts * grain / (count + 1)));
  return std::accumulate(sums.begin(), sums.begin() + static_cast<std::ptrdiff_t>(num_parts), Sum{});
}

}  // namespace

double sum_squares(const Parallel& parallel, std::size_t count, const double* mass, const double* v) {
  return add_parts<double>(parallel, count,
                           [&](std::size_t begin, std::size_t end) { return sum_squares(mass, v, begin, end); });
}

Vec3 sum_moments(const Parallel& parallel, std::size_t count, const double* mass, const double* r) {
  return add_parts<Vec3>(parallel, count,
                         [&](std::size_t begin, std::size_t end) { return sum_moments(mass, r, begin, end); });
}

}  // namespace tanor::detail
