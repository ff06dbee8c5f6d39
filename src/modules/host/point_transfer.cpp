#include "host/point_transfer.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <type_traits>

#include "base/scattered.hpp"
#include "host/point_address.hpp"
#include "host/point_norms.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t bytes_of_point = 3 * sizeof(double);

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

template <class Number, class At>
void PointTransfer::visit(const BasicPointArray<Number>& array, std::size_t width, std::size_t first, std::size_t count,
                          const At& at) const {
  using Byte = std::conditional_t<std::is_const_v<Number>, const std::byte, std::byte>;
  Byte* const bytes = reinterpret_cast<Byte*>(array.data);
  const auto stride = array.stride != 0 ? array.stride : static_cast<std::ptrdiff_t>(width * sizeof(double));
  const Index* const host_point = host_point_.data();
  const auto go = [&](const auto& number_of) {
    const auto address = [&](std::size_t i) { return bytes + number_of(i) * stride; };
    visit_scattered(first, first + count, host_point_.size(), width * sizeof(double), address,
                    [&](std::size_t i) { at(i, address(i)); });
  };
  if (array.index != nullptr)
    go([&](std::size_t i) { return static_cast<std::ptrdiff_t>(array.index[host_point[i]]); });
  else
    go([&](std::size_t i) { return static_cast<std::ptrdiff_t>(host_point[i]); });
}

template <class Piece>
double PointTransfer::largest(std::size_t count, const Piece& of_piece) const {
  return parallel_.max_over_ranges(count, [&](std::size_t begin, std::size_t end) {
    double result = 0.0;
    for (std::size_t first = begin; first < end; first += piece)
      result = larger(result, of_piece(first, std::min(piece, end - first)));
    return result;
  });
}

bool PointTransfer::is_straight(const ConstPointArray& array) const {
  const bool is_packed = array.stride == 0 || array.stride == static_cast<std::ptrdiff_t>(3 * sizeof(double));
  const bool is_aligned = reinterpret_cast<std::uintptr_t>(array.data) % alignof(double) == 0;
  return is_natural_ && is_packed && is_aligned && array.index == nullptr;
}

/// The points are copied bytewise, since a host's numbers may stand at any address.
const double* PointTransfer::load(const ConstPointArray& array, std::size_t first, std::size_t count,
                                  double* scratch) const {
  if (const double* const there = straight(array)) return there + 3 * first;
  visit(array, 3, first, count,
        [&](std::size_t i, const std::byte* point) { std::memcpy(scratch + 3 * (i - first), point, bytes_of_point); });
  return scratch;
}

void PointTransfer::store(const double* from, std::size_t first, std::size_t count, const PointArray& array) const {
  if (double* const there = straight(array)) {
    std::memcpy(there + 3 * first, from, bytes_of_point * count);
    return;
  }
  visit(array, 3, first, count,
        [&](std::size_t i, std::byte* point) { std::memcpy(point, from + 3 * (i - first), bytes_of_point); });
}

void PointTransfer::gather(const ConstPointArray& from, double* to) const {
  parallel_.for_ranges(host_point_.size(), [&](std::size_t begin, std::size_t end) {
    double* const own = to + 3 * begin;
    const double* const x = load(from, begin, end - begin, own);
    if (x != own) std::memcpy(own, x, bytes_of_point * (end - begin));
  });
}

void PointTransfer::gather_last(const ConstPointArray& from, std::size_t first, double* to) const {
  visit(from, 3, first, host_point_.size() - first,
        [&](std::size_t i, const std::byte* point) { std::memcpy(to + 3 * i, point, bytes_of_point); });
}

bool PointTransfer::differ(const ConstPointArray& from, const double* than) const {
  std::atomic<bool> result{false};
  parallel_.for_ranges(host_point_.size(), [&](std::size_t begin, std::size_t end) {
    double scratch[3 * piece];  // NOLINT: filled where needed
    for (std::size_t first = begin; first < end && !result.load(std::memory_order_relaxed); first += piece) {
      const std::size_t count = std::min(piece, end - first);
      if (std::memcmp(load(from, first, count, scratch), than + 3 * first, bytes_of_point * count) != 0) result = true;
    }
  });
  return result;
}

double PointTransfer::scatter(const double* from, std::size_t count, const PointArray& to) const {
  return std::sqrt(largest(count, [&](std::size_t first, std::size_t size) {
    double scratch[3 * piece];  // NOLINT: filled where needed
    const double* const own = from + 3 * first;
    const double change = largest_squared_distance(own, load(to, first, size, scratch), size);
    store(own, first, size, to);
    return change;
  }));
}

double PointTransfer::largest_change(const double* x, const double* y, std::size_t count) const {
  return std::sqrt(largest(count, [&](std::size_t first, std::size_t size) {
    return largest_squared_distance(x + 3 * first, y + 3 * first, size);
  }));
}

void PointTransfer::write(const double* from, std::size_t count, const PointArray& to) const {
  parallel_.for_ranges(count,
                       [&](std::size_t begin, std::size_t end) { store(from + 3 * begin, begin, end - begin, to); });
}

double PointTransfer::add(const double* moves, std::size_t count, const PointArray& to) const {
  return std::sqrt(largest(count, [&](std::size_t first, std::size_t size) {
    double sums[3 * piece];  // NOLINT: filled before use
    const double* const own = moves + 3 * first;
    const double* const x = load(to, first, size, sums);
    for (std::size_t k = 0; k < 3 * size; ++k) sums[k] = x[k] + own[k];
    store(sums, first, size, to);
    return largest_square(own, size);
  }));
}

void PointTransfer::scatter_tensors(const double* from, std::size_t count, const PointArray& to) const {
  parallel_.for_ranges(count, [&](std::size_t begin, std::size_t end) {
    visit(to, 9, begin, end - begin,
          [&](std::size_t i, std::byte* point) { std::memcpy(point, from + 9 * i, 9 * sizeof(double)); });
  });
}

void PointTransfer::add_last(const double* from, std::size_t first, std::size_t width, const PointArray& to) const {
  for (std::size_t i = first; i < host_point_.size(); ++i) {
    std::byte* const point = address_of(to, static_cast<std::size_t>(host_point_[i]), width);
    double sum[9];
    std::memcpy(sum, point, width * sizeof(double));
    for (std::size_t k = 0; k < width; ++k) sum[k] += from[width * i + k];
    std::memcpy(point, sum, width * sizeof(double));
  }
}

// ---- into the inner order ----

void IncomingPoints::bring(std::size_t first, std::size_t count) const {
  double square = 0.0;
  for (const Array& array : std::span(arrays_).first(count_)) {
    for (std::size_t k = 0; k < count; k += PointTransfer::piece) {
      const double of_piece = bring_piece(array, first + k, std::min(PointTransfer::piece, count - k));
      square = larger(square, of_piece);
    }
  }
  double seen = largest_.load(std::memory_order_relaxed);
  while ((square > seen || std::isnan(square)) && !std::isnan(seen)) {
    if (largest_.compare_exchange_weak(seen, square, std::memory_order_relaxed)) return;
  }
}

/// Copies a piece of the array. Returns the largest square of its points if that is measured, else 0.
double IncomingPoints::bring_piece(const Array& array, std::size_t first, std::size_t count) const {
  double* const own = array.to + 3 * first;
  if (!array.factors.empty()) {
    if (first >= array.factors.size()) return 0.0;
    const std::size_t size = std::min(count, array.factors.size() - first);
    const double* const x = transfer_.load(array.from, first, size, own);
    return detail::scale(x, &array.factors[first], size, own);
  }
  const double* const x = transfer_.load(array.from, first, count, own);
  if (x == own) return array.is_measured ? largest_square(own, count) : 0.0;
  if (array.is_measured) return detail::copy(x, count, own);
  std::memcpy(own, x, bytes_of_point * count);
  return 0.0;
}

// ---- moved points ----

double* MovedPoints::use_copy() {
  has_moved_ = false;
  return moved_ = copy_.data();
}

void MovedPoints::take(const PointArray& host, bool in_place, IncomingPoints* incoming, bool measures) {
  double* const there = in_place && !keeps_copy_ ? transfer_.straight(host) : nullptr;
  use_copy();
  measures ? incoming->measure(host, copy_.data()) : incoming->copy(host, copy_.data());
  if (there != nullptr) moved_ = there;
}

double MovedPoints::give_back(const PointArray& host, std::size_t count, bool measures) {
  const double* const moved = moved_;
  double* const copy = use_copy();
  if (moved != copy) return measures ? transfer_.largest_change(moved, copy, count) : 0.0;
  if (measures) return transfer_.scatter(copy, count, host);
  transfer_.write(copy, count, host);
  return 0.0;
}

void MovedPoints::restore() {
  if (has_moved_ && moved_ != copy_.data()) std::ranges::copy(copy_, moved_);
  use_copy();
}

}  // namespace tanor::detail
