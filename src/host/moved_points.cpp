#include "host/moved_points.hpp"

#include <algorithm>
#include <utility>

namespace tanor {

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
  has_moved_ = false;
  if (is_in_place()) return measures ? transfer_.largest_change(moved_, copy_.data(), count) : 0.0;
  if (measures) return transfer_.scatter(copy_.data(), count, host);
  transfer_.write(copy_.data(), count, host);
  return 0.0;
}

void MovedPoints::restore() {
  if (std::exchange(has_moved_, false) && is_in_place()) std::ranges::copy(copy_, moved_);
}

}  // namespace tanor
