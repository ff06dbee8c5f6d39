#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include <tanor/error.hpp>

#include "base/vec3.hpp"

namespace tanor::detail {

/// The data that a running simulation keeps beside its state, as plain numbers. Each part has one function that
/// exchanges its members in a fixed order. The same function appends them to a snapshot and reads them back, so the two
/// cannot differ. Arrays are exchanged with the sizes that they have; `finish` refuses a snapshot of another system,
/// which does not fit.
class Memory {
 public:
  explicit Memory(std::vector<double>* appended) : appended_(appended) {}
  explicit Memory(std::span<const double> read) : read_(read) {}

  bool reads() const { return appended_ == nullptr; }

  void exchange(double& number) {
    if (!reads()) {
      appended_->push_back(number);
    } else if (next_ < read_.size()) {
      number = read_[next_++];
    } else {
      misses_some_ = true;
    }
  }
  /// Exchanges a flag, a count or a numbered choice.
  template <class Number>
  requires std::integral<Number> || std::is_enum_v<Number>
  void exchange(Number& number) {
    auto value = static_cast<double>(number);
    exchange(value);
    if (!reads()) return;
    if (!(std::abs(value) <= largest_count) || value != std::floor(value)) refuse();
    if (std::is_unsigned_v<Number> && value < 0.0) refuse();
    number = static_cast<Number>(value);
  }
  void exchange(Vec3& vector) {
    for (double* const component : {&vector.x, &vector.y, &vector.z}) exchange(*component);
  }
  void exchange(std::vector<double>& array) {
    if (!reads()) {
      appended_->insert(appended_->end(), array.begin(), array.end());
      return;
    }
    const std::size_t there = std::min(array.size(), read_.size() - next_);
    std::copy_n(read_.begin() + static_cast<std::ptrdiff_t>(next_), there, array.begin());
    next_ += there;
    misses_some_ = misses_some_ || there < array.size();
  }
  template <class Number>
  void exchange(std::vector<Number>& array) {
    for (Number& number : array) exchange(number);
  }
  template <class Number, std::size_t N>
  void exchange(std::array<Number, N>& array) {
    for (Number& number : array) exchange(number);
  }
  template <class... Members>
  requires(sizeof...(Members) > 1) void exchange(Members&... members) { (exchange(members), ...); }

  /// Refuses numbers that no part can have written.
  [[noreturn]] static void refuse() {
    throw InputError("/snapshot/memory", "is of another system, or of other options");
  }
  /// Refuses a snapshot that had too few or too many numbers.
  void finish() const {
    if (misses_some_ || (reads() && next_ != read_.size())) refuse();
  }

 private:
  static constexpr double largest_count = 1e9;

  std::vector<double>* appended_ = nullptr;
  std::span<const double> read_;
  std::size_t next_ = 0;
  bool misses_some_ = false;
};

}  // namespace tanor::detail
