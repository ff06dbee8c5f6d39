#pragma once

#include <functional>
#include <span>
#include <string>
#include <utility>

#include <tanor/error.hpp>
#include <tanor/ranks.hpp>

#include "dynamics/team.hpp"

namespace tanor::detail {

/// Decisions that ranks take together, so that every rank takes the same branch. All functions are collective.
class Agreement : public Team {
 public:
  explicit Agreement(Ranks& ranks) : ranks_(ranks) {}

  double largest(double own) override;
  double sum(double own);
  /// Returns the worst outcome of all ranks, as the first rank that has it explains it. `numbers` become the largest
  /// ones.
  Outcome agree(Outcome own, std::span<double> numbers = {});
  std::string first_text(std::string own) override;

  Outcome together(const std::function<Outcome()>& work) override { return together(work, {}); }
  /// Runs work() -> Outcome and agrees on its outcome. What it throws on some rank is thrown on all. Work that makes
  /// collective calls must not throw on some ranks alone.
  template <class Work>
  Outcome together(const Work& work, std::span<double> numbers) {
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
