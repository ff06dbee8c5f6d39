#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>
#include <tanor/ranks.hpp>

#include "dynamics/power.hpp"

namespace tanor::detail {

/// Things that each process has some of, numbered one process behind the other.
struct Share {
  std::vector<std::size_t> start{0};  ///< [process + 1] number of each one's first, then the number of all
  std::size_t first = 0;              ///< number of this process's first one

  std::size_t all() const { return start.back(); }
};

/// Numbers of all processes that have parts of one system. What decides and was found from local arrays goes through
/// these functions, so that every process takes the same branch; all of them must call them, in the same order. To a
/// process that is alone every answer is its own.
class Decisions {
 public:
  Decisions() = default;
  virtual ~Decisions() = default;
  /// `ranks` outlive it; null if this process is alone.
  explicit Decisions(Ranks* ranks) : ranks_(ranks) {}
  /// The processes of a part, unless one has the whole system.
  explicit Decisions(const Part& part) : Decisions(part.is_whole() ? nullptr : part.ranks) {}

  /// True if no other process takes part, as none does in the work of `together`.
  bool is_alone() const { return ranks_ == nullptr || is_apart_; }

  /// Returns the largest number of all processes. Among several, a NaN somewhere is infinite everywhere.
  double largest(double own) {
    if (!is_alone()) take_largest({&own, 1});
    return own;
  }
  /// Does the same with each of these numbers.
  void take_largest(std::span<double> numbers);
  double smallest(double own) { return -largest(-own); }
  bool any(bool own) { return largest(own ? 1.0 : 0.0) > 0.0; }
  bool all(bool own) { return !any(!own); }
  double sum(double own) {
    add({&own, 1});
    return own;
  }
  /// Replaces each number by its sum over all processes.
  void add(std::span<double> numbers) {
    if (!is_alone()) ranks_->sum(numbers);
  }
  Power sum(const Power& own);
  Share share(std::size_t own);
  /// Returns the text of the first process that has one.
  std::string first_text(std::string own);

  /// Runs work() -> Outcome, which calls no collective function of this object. Returns the worst outcome of all
  /// processes, as the first that has it explains it; `numbers`, which the work may set, become the largest ones. What
  /// is thrown on one process is thrown on all.
  template <class Work>
  Outcome together(const Work& work, std::span<double> numbers = {}) {
    return is_alone() ? work() : agree(work, numbers);
  }

 protected:
  void join(Ranks& ranks) { ranks_ = &ranks; }
  virtual Outcome agree(const std::function<Outcome()>& work, std::span<double> numbers);

 private:
  struct Report {
    int code = 0;  // a Status, or an exception
    std::string what;
  };
  Outcome conclude(Report own, std::span<double> numbers);

  Ranks* ranks_ = nullptr;
  bool is_apart_ = false;  // in the work of `together`
};

}  // namespace tanor::detail
