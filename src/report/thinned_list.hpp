#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace tanor::report {

/// A list of instants that has room for so many: where it is full every second one goes, again and again, and the last
/// one stays.
template <class Item>
class ThinnedList {
 public:
  explicit ThinnedList(std::size_t most) : most_(most) {}

  void add(Item item) {
    if (num_seen_++ % stride_ == 0) {
      kept_.push_back(item);
      if (kept_.size() > most_) thin();
    }
    last_ = std::move(item);
  }
  /// In the order of time, with the last one.
  std::vector<Item> items() const {
    std::vector<Item> result = kept_;
    if (!result.empty() && result.back().time < last_.time) result.push_back(last_);
    return result;
  }
  std::size_t num_seen() const { return num_seen_; }

 private:
  void thin() {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < kept_.size(); k += 2) std::swap(kept_[kept++], kept_[k]);
    kept_.resize(kept);
    stride_ *= 2;
  }

  std::size_t most_, num_seen_ = 0, stride_ = 1;
  std::vector<Item> kept_;
  Item last_;
};

}  // namespace tanor::report
