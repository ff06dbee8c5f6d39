#include "host/point_norms.hpp"

#include <algorithm>

#include "base/instruction_sets.hpp"
#include "base/pack.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t numbers = 3 * num_lanes;  // numbers of eight points

[[gnu::always_inline]] inline Pack3<> load_pack(const double* from) {
  Pack3<> points;
  load_points(from, &points.x, &points.y, &points.z);
  return points;
}

}  // namespace

double largest_square(const double* x, std::size_t count) {
  return dispatch([=] {
    Largest seen;
    std::size_t k = 0;
    for (; k + numbers <= 3 * count; k += numbers) {
      const Pack3<> points = load_pack(x + k);
      seen.see(dot(points, points));
    }
    double rest[numbers] = {};
    std::copy(x + k, x + 3 * count, rest);
    const Pack3<> points = load_pack(rest);
    seen.see(dot(points, points));
    return seen.read();
  });
}

double copy(const double* x, std::size_t count, double* y) {
  return dispatch([=] {
    Largest seen;
    const auto copy_pack = [&](const double* from, double* to) __attribute__((always_inline)) {
      const Pack3<> points = load_pack(from);
      seen.see(dot(points, points));
      for (std::size_t k = 0; k < numbers; k += num_lanes) pack_to(to + k) = pack_at(from + k);
    };
    std::size_t k = 0;
    for (; k + numbers <= 3 * count; k += numbers) copy_pack(x + k, y + k);
    double rest[numbers] = {};
    std::copy(x + k, x + 3 * count, rest);
    copy_pack(rest, rest);
    std::copy(rest, rest + (3 * count - k), y + k);
    return seen.read();
  });
}

double largest_squared_distance(const double* x, const double* y, std::size_t count) {
  return dispatch([=] {
    Largest seen;
    std::size_t k = 0;
    for (; k + numbers <= 3 * count; k += numbers) {
      const Pack3<> change = load_pack(x + k) - load_pack(y + k);
      seen.see(dot(change, change));
    }
    double rest[2][numbers] = {};
    std::copy(x + k, x + 3 * count, rest[0]);
    std::copy(y + k, y + 3 * count, rest[1]);
    const Pack3<> change = load_pack(rest[0]) - load_pack(rest[1]);
    seen.see(dot(change, change));
    return seen.read();
  });
}

double scale(const double* x, const double* factors, std::size_t count, double* y) {
  return dispatch([=] {
    Largest seen;
    const auto scale_pack = [&](const double* from, const double* by, double* to) __attribute__((always_inline)) {
      const Pack<> factor = pack_at(by);
      const Pack3<> points = factor * load_pack(from);
      seen.see(dot(points, points));
      store_points(points.x, points.y, points.z, to);
    };
    std::size_t i = 0;
    for (; i + num_lanes <= count; i += num_lanes) scale_pack(x + 3 * i, factors + i, y + 3 * i);
    double rest[numbers] = {}, of_rest[num_lanes] = {};
    std::copy(x + 3 * i, x + 3 * count, rest);
    std::copy(factors + i, factors + count, of_rest);
    scale_pack(rest, of_rest, rest);
    std::copy(rest, rest + 3 * (count - i), y + 3 * i);
    return seen.read();
  });
}

}  // namespace tanor::detail
