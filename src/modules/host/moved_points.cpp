#include "host/moved_points.hpp"

#include <algorithm>

namespace tanor::detail {

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
