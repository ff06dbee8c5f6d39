#pragma once

#include <omp.h>

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <utility>
#include <vector>

#include "base/quiet_traps.hpp"

namespace tanor::detail {

/// Runs tasks that wait for others with a given number of threads. One thread runs them in the order in which they were
/// added, or backwards. Several threads take the tasks that are ready, those with the longest path to the end first. A
/// thread without a task sleeps. Results must depend only on the tasks that a task waits for. A run allocates no
/// memory, as OpenMP's tasks would.
class TaskGraph {
 public:
  enum class Direction { Forwards, Backwards };

  /// Adds a task of some cost (in any unit) and returns its number.
  int add(double cost) {
    costs_.push_back(cost);
    return static_cast<int>(costs_.size()) - 1;
  }
  /// Lets a task wait for one that was added before it. In a backward run the earlier task waits for the later one.
  void link(int earlier, int later) { links_.emplace_back(earlier, later); }
  /// Completes the graph. Call this after the last task and link.
  void finish() {
    for (const bool backwards : {false, true}) {
      Side& side = sides_[backwards ? 1 : 0];
      side.start.assign(size() + 1, 0);
      side.num_before.assign(size(), 0);
      for (auto [from, to] : links_) {
        if (backwards) std::swap(from, to);
        ++side.start[static_cast<std::size_t>(from) + 1];
        ++side.num_before[static_cast<std::size_t>(to)];
      }
      for (std::size_t k = 0; k < size(); ++k) side.start[k + 1] += side.start[k];
      side.after.resize(links_.size());
      std::vector<std::size_t> next(side.start.begin(), side.start.end() - 1);
      for (auto [from, to] : links_) {
        if (backwards) std::swap(from, to);
        side.after[next[static_cast<std::size_t>(from)]++] = to;
      }
      side.way = costs_;
      for (std::size_t i = 0; i < size(); ++i) {
        const std::size_t k = backwards ? i : size() - 1 - i;
        double longest = 0.0;
        for (std::size_t e = side.start[k]; e < side.start[k + 1]; ++e)
          longest = std::max(longest, side.way[static_cast<std::size_t>(side.after[e])]);
        side.way[k] += longest;
      }
    }
    links_ = {};
    waiting_.resize(size());
    ready_.reserve(size());
  }
  std::size_t size() const { return costs_.size(); }

  /// Calls body(task, thread) for all tasks. The body must not throw. Inside a parallel region there is one thread.
  template <class Body>
  void run(int threads, Direction direction, const Body& body) {
    if (threads <= 1 || size() <= 1 || omp_in_parallel() != 0) {
      for (std::size_t i = 0; i < size(); ++i)
        body(static_cast<int>(direction == Direction::Forwards ? i : size() - 1 - i), 0);
      return;
    }
    const Side& side = sides_[direction == Direction::Forwards ? 0 : 1];
    start(side);
#pragma omp parallel num_threads(threads)
    {
      const QuietTraps quiet;
      const int thread = omp_get_thread_num();
      for (int task = take(side); task >= 0; task = take(side)) {
        body(task, thread);
        give_back(side, task);
      }
    }
  }

 private:
  struct Side {
    std::vector<std::size_t> start;  // [task + 1] into `after`
    std::vector<int> after, num_before;
    std::vector<double> way;  // cost of the longest path to the end
  };

  void start(const Side& side) {
    waiting_ = side.num_before;
    ready_.clear();
    num_left_ = size();
    for (std::size_t k = 0; k < size(); ++k) {
      if (waiting_[k] == 0) push(side, static_cast<int>(k));
    }
  }
  static auto later_in(const Side& side) {
    return [&side](int a, int b) {
      const double way_a = side.way[static_cast<std::size_t>(a)], way_b = side.way[static_cast<std::size_t>(b)];
      return way_a < way_b || (way_a == way_b && a > b);
    };
  }
  void push(const Side& side, int task) {
    ready_.push_back(task);
    std::push_heap(ready_.begin(), ready_.end(), later_in(side));
  }
  /// Sleeps until a task is ready and returns it, or -1 if all are done.
  int take(const Side& side) {
    std::unique_lock lock(mutex_);
    ++num_idle_;
    changed_.wait(lock, [&] { return !ready_.empty() || num_left_ == 0; });
    --num_idle_;
    if (ready_.empty()) return -1;
    std::pop_heap(ready_.begin(), ready_.end(), later_in(side));
    const int task = ready_.back();
    ready_.pop_back();
    return task;
  }
  void give_back(const Side& side, int task) {
    const auto k = static_cast<std::size_t>(task);
    std::size_t to_wake = 0;
    {
      const std::scoped_lock lock(mutex_);
      for (std::size_t e = side.start[k]; e < side.start[k + 1]; ++e) {
        if (--waiting_[static_cast<std::size_t>(side.after[e])] == 0) push(side, side.after[e]);
      }
      // This thread takes one of the new tasks itself.
      if (num_idle_ > 0 && ready_.size() > 1) to_wake = std::min(num_idle_, ready_.size() - 1);
      if (--num_left_ == 0) to_wake = num_idle_;
    }
    for (; to_wake > 0; --to_wake) changed_.notify_one();
  }

  std::vector<double> costs_;
  std::vector<std::pair<int, int>> links_;
  Side sides_[2];
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<int> waiting_, ready_;
  std::size_t num_left_ = 0, num_idle_ = 0;
};

}  // namespace tanor::detail
