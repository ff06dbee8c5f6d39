#include "host/point_transfer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <type_traits>

#include "base/vec3.hpp"

namespace tanor {

namespace {

constexpr std::size_t ahead = 16;  // points that are fetched before they are needed, where their places jump

/// A host's numbers may stand at any address.
Vec3 read(const double* from) {
  double x[3];
  std::memcpy(x, from, sizeof(x));
  return {x[0], x[1], x[2]};
}

void write(Vec3 point, double* to) {
  const double x[3]{point.x, point.y, point.z};
  std::memcpy(to, x, sizeof(x));
}

}  // namespace

PointTransfer::PointTransfer(const Numbering& numbering, const Parallel& parallel)
    : numbering_(numbering), parallel_(parallel) {
  std::vector<Index> same(numbering.num_points());
  std::iota(same.begin(), same.end(), 0);
  set_points(same);
}

void PointTransfer::set_points(std::span<const Index> of_system) {
  host_point_.clear();
  for (const Index point : numbering_.user_point) host_point_.push_back(of_system[static_cast<std::size_t>(point)]);
  const auto does_not_follow = [](Index a, Index b) { return b != a + 1; };
  is_natural_ = std::ranges::adjacent_find(host_point_, does_not_follow) == host_point_.end();
}

template <class Number, class Each>
double PointTransfer::visit(const BasicPointArray<Number>& array, std::size_t count, std::size_t width,
                            const Each& each) const {
  using Byte = std::conditional_t<std::is_const_v<Number>, const std::byte, std::byte>;
  Byte* const bytes = reinterpret_cast<Byte*>(array.data);
  const auto stride = array.stride != 0 ? array.stride : static_cast<std::ptrdiff_t>(width * sizeof(double));
  const Index* const host_point = host_point_.data();
  const auto largest = [&](const auto& number_of, auto jumps) {
    return parallel_.max_over_ranges(count, [&](std::size_t begin, std::size_t end) {
      double worst = 0.0;
      bool is_unordered = false;
      for (std::size_t i = begin; i < end; ++i) {
        if constexpr (jumps) __builtin_prefetch(bytes + number_of(std::min(i + ahead, count - 1)) * stride);
        const double own = each(i, reinterpret_cast<Number*>(bytes + number_of(i) * stride));
        worst = own > worst ? own : worst;
        is_unordered |= own != own;
      }
      return is_unordered ? std::numeric_limits<double>::quiet_NaN() : worst;
    });
  };
  if (array.index != nullptr)
    return largest([&](std::size_t i) { return static_cast<std::ptrdiff_t>(array.index[host_point[i]]); },
                   std::true_type{});
  if (is_natural_) {
    const std::ptrdiff_t first = host_point_.empty() ? 0 : host_point_[0];
    return largest([first](std::size_t i) { return first + static_cast<std::ptrdiff_t>(i); }, std::false_type{});
  }
  return largest([&](std::size_t i) { return static_cast<std::ptrdiff_t>(host_point[i]); }, std::true_type{});
}

const double* PointTransfer::straight(const ConstPointArray& array) const {
  const bool is_packed = array.stride == 0 || array.stride == static_cast<std::ptrdiff_t>(3 * sizeof(double));
  const bool is_aligned = reinterpret_cast<std::uintptr_t>(array.data) % alignof(double) == 0;
  if (!is_natural_ || !is_packed || !is_aligned || array.index != nullptr) return nullptr;
  return array.data + (host_point_.empty() ? 0 : 3 * static_cast<std::ptrdiff_t>(host_point_[0]));
}

double PointTransfer::gather(const ConstPointArray& from, double* to) const {
  return std::sqrt(visit(from, numbering_.num_points(), 3, [&](std::size_t i, const double* point) {
    const Vec3 x = read(point);
    store(to, i, x);
    return dot(x, x);
  }));
}

bool PointTransfer::gather_changes(const ConstPointArray& from, double* to) const {
  constexpr std::size_t bytes = 3 * sizeof(double);
  const std::size_t count = numbering_.num_points();
  if (const double* const there = straight(from)) {
    return parallel_.max_over_ranges(count, [&](std::size_t begin, std::size_t end) {
      const std::size_t size = bytes * (end - begin);
      if (std::memcmp(there + 3 * begin, to + 3 * begin, size) == 0) return 0.0;
      std::memcpy(to + 3 * begin, there + 3 * begin, size);
      return 1.0;
    }) > 0.0;
  }
  return visit(from, count, 3, [&](std::size_t i, const double* point) {
           std::uint64_t now[3], before[3];
           std::memcpy(now, point, bytes);
           std::memcpy(before, to + 3 * i, bytes);
           std::memcpy(to + 3 * i, now, bytes);
           const std::uint64_t change = (now[0] ^ before[0]) | (now[1] ^ before[1]) | (now[2] ^ before[2]);
           return change != 0 ? 1.0 : 0.0;
         }) > 0.0;
}

double PointTransfer::scatter(const double* from, std::size_t count, const PointArray& to) const {
  return std::sqrt(visit(to, count, 3, [&](std::size_t i, double* point) {
    const Vec3 x = load(from, i), change = x - read(point);
    write(x, point);
    return dot(change, change);
  }));
}

double PointTransfer::add(const double* moves, std::size_t count, const PointArray& to) const {
  return std::sqrt(visit(to, count, 3, [&](std::size_t i, double* point) {
    const Vec3 move = load(moves, i);
    write(read(point) + move, point);
    return dot(move, move);
  }));
}

void PointTransfer::scatter_tensors(const double* from, std::size_t count, const PointArray& to) const {
  (void)visit(to, count, 9, [&](std::size_t i, double* point) {
    std::memcpy(point, from + 9 * i, 9 * sizeof(double));
    return 0.0;
  });
}

void PointTransfer::add_last(const double* from, std::size_t first, std::size_t width, const PointArray& to) const {
  const auto stride = to.stride != 0 ? to.stride : static_cast<std::ptrdiff_t>(width * sizeof(double));
  for (std::size_t i = first; i < host_point_.size(); ++i) {
    const Index number = to.index != nullptr ? to.index[host_point_[i]] : host_point_[i];
    std::byte* const point = reinterpret_cast<std::byte*>(to.data) + number * stride;
    double sum[9];
    std::memcpy(sum, point, width * sizeof(double));
    for (std::size_t k = 0; k < width; ++k) sum[k] += from[width * i + k];
    std::memcpy(point, sum, width * sizeof(double));
  }
}

}  // namespace tanor
