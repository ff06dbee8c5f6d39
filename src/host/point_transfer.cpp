#include "host/point_transfer.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/vec3.hpp"

namespace tanor {

namespace {

bool is_natural(const Numbering& numbering) {
  for (std::size_t i = 0; i < numbering.num_points(); ++i) {
    if (numbering.user_point[i] != static_cast<Index>(i)) return false;
  }
  return true;
}

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
    : numbering_(numbering), parallel_(parallel), is_natural_(is_natural(numbering)) {}

template <class Number, class Each>
double PointTransfer::visit(const BasicPointArray<Number>& array, std::size_t count, std::size_t width,
                            const Each& each) const {
  const auto stride = array.stride != 0 ? array.stride : static_cast<std::ptrdiff_t>(width * sizeof(double));
  const Index* const user_point = numbering_.user_point.data();
  const auto largest = [&](const auto& number_of) {
    return parallel_.max_over_ranges(count, [&](std::size_t begin, std::size_t end) {
      using Byte = std::conditional_t<std::is_const_v<Number>, const std::byte, std::byte>;
      Byte* const bytes = reinterpret_cast<Byte*>(array.data);
      double worst = 0.0;
      for (std::size_t i = begin; i < end; ++i)
        worst = larger(worst, each(i, reinterpret_cast<Number*>(bytes + number_of(i) * stride)));
      return worst;
    });
  };
  if (array.index != nullptr)
    return largest([&](std::size_t i) { return static_cast<std::ptrdiff_t>(array.index[user_point[i]]); });
  if (is_natural_) return largest([](std::size_t i) { return static_cast<std::ptrdiff_t>(i); });
  return largest([&](std::size_t i) { return static_cast<std::ptrdiff_t>(user_point[i]); });
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
  return visit(from, numbering_.num_points(), 3, [&](std::size_t i, const double* point) {
           if (std::memcmp(point, to + 3 * i, bytes) == 0) return 0.0;
           std::memcpy(to + 3 * i, point, bytes);
           return 1.0;
         }) > 0.0;
}

double PointTransfer::scatter(const double* from, std::size_t count, const PointArray& to) const {
  return std::sqrt(visit(to, count, 3, [&](std::size_t i, double* point) {
    const Vec3 x = load(from, i), change = x - read(point);
    write(x, point);
    return dot(change, change);
  }));
}

void PointTransfer::scatter_tensors(const double* from, const PointArray& to) const {
  (void)visit(to, numbering_.num_points(), 9, [&](std::size_t i, double* point) {
    std::memcpy(point, from + 9 * i, 9 * sizeof(double));
    return 0.0;
  });
}

}  // namespace tanor
