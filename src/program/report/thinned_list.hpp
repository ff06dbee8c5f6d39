#pragma once

#include <cstddef>
#include <utility>
#include <vector>

namespace tanor::report {

/// A list of instants with limited room. When it is full, every second one is dropped, but the last one stays. The item
/// before a dropped one can keep part of its information: absorb(Item* kept, const Item& later).
template <class Item>
class ThinnedList {
 public:
  ThinnedList() = default;
  explicit ThinnedList(std::size_t most) : most_(most) {}

  void add(Item item) {
    if (num_seen_++ % stride_ == 0) {
      kept_.push_back(item);
      if (kept_.size() > most_) thin();
    } else {
      leave_out(item, &kept_.back());
    }
    last_ = std::move(item);
  }
  /// Returns the items in the order of time, including the last one.
  std::vector<Item> items() const {
    std::vector<Item> result = kept_;
    if (!result.empty() && result.back().time < last_.time) result.push_back(last_);
    return result;
  }
  std::size_t num_seen() const { return num_seen_; }
  bool is_empty() const { return kept_.empty(); }
  double end() const { return last_.time; }  ///< s; the list must not be empty

  /// Removes the items after this time. The number of those seen is then known only approximately.
  void cut(double time) {
    if (is_empty() || last_.time <= time) return;
    std::erase_if(kept_, [&](const Item& item) { return item.time > time; });
    num_seen_ = kept_.size() * stride_;
    if (!is_empty()) last_ = kept_.back();
  }
  /// Visits everything except the room, to write and to read it (base/archive.hpp).
  template <class Visit>
  friend void visit_parts(const ThinnedList& list, const Visit& visit) {
    visit(list.num_seen_, list.stride_, list.kept_, list.last_);
  }
  template <class Visit>
  friend void visit_parts(ThinnedList& list, Visit& visit) {
    visit(list.num_seen_, list.stride_, list.kept_, list.last_);
  }
  /// Takes the content of a list that was read; the room stays.
  bool take(ThinnedList other) {
    if (other.stride_ == 0 || other.kept_.size() > most_) return false;
    other.most_ = most_;
    *this = std::move(other);
    return true;
  }

 private:
  static void leave_out([[maybe_unused]] const Item& item, [[maybe_unused]] Item* before) {
    if constexpr (requires { absorb(before, item); }) absorb(before, item);
  }
  void thin() {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < kept_.size(); k += 2) {
      if (k + 1 < kept_.size()) leave_out(kept_[k + 1], &kept_[k]);
      std::swap(kept_[kept++], kept_[k]);
    }
    kept_.resize(kept);
    stride_ *= 2;
  }

  std::size_t most_ = 0, num_seen_ = 0, stride_ = 1;
  std::vector<Item> kept_;
  Item last_;
};

}  // namespace tanor::report
