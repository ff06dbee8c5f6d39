#pragma once

#include <span>
#include <string>
#include <utility>

#include <tanor/error.hpp>
#include <tanor/ranks.hpp>

namespace tanor::detail {

/// Decisions that ranks take together, so that every rank takes the same branch. All functions are collective.
class Agreement {
 public:
  explicit Agreement(Ranks& ranks) : ranks_(ranks) {}

  /// Returns the largest number of all ranks. A number that is not finite somewhere is infinite everywhere.
  double largest(double own);
  double smallest(double own) { return -largest(-own); }
  double sum(double own);
  bool any(bool own) { return largest(own ? 1.0 : 0.0) > 0.0; }
  bool all(bool own) { return !any(!own); }
  /// Returns the worst outcome of all ranks, as the first rank that has it explains it. `numbers` become the largest
  /// ones.
  Outcome agree(Outcome own, std::span<double> numbers = {});
  /// Returns the text of the first rank that has one.
  std::string first_text(std::string own);

  /// Runs work() -> Outcome and agrees on its outcome. What it throws on some rank is thrown on all. Work that makes
  /// collective calls must not throw on some ranks alone.
  template <class Work>
  Outcome together(const Work& work, std::span<double> numbers = {}) {
    Report report;
    try {
      Outcome found = work();
      report = {static_cast<int>(found.status), std::move(found.what)};
    } catch (const InputError& error) {
      report = {input_error, error.where() + separator + error.what()};
    } catch (const std::exception& error) {
      report = {other_error, error.what()};
    }
    return conclude(std::move(report), numbers);
  }

 private:
  static constexpr int input_error = 100, other_error = 101;
  static constexpr char separator = '\x1f';
  struct Report {
    int code = 0;  // a Status, or one of those above
    std::string what;
  };
  Outcome conclude(Report own, std::span<double> numbers);

  Ranks& ranks_;
};

}  // namespace tanor::detail
