#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <tanor/expression.hpp>

#include "base/pack.hpp"

namespace tanor::detail {

/// All numbers from `low` to `high`, in eight lanes. A computed interval holds every result of numbers from the
/// operands, up to rounding, which is not directed.
struct Intervals {
  Pack<> low, high;
};

/// Counts how often an expression may change its course while its variables run through intervals.
///
/// Sums and products of smooth numbers are smooth. A function is narrow if its argument runs through more than the
/// function's own scale: exp, sin and cosh change over an argument of 1, quotients, roots and logarithms while it
/// changes by a factor sqrt(e), tanh and arctan only near 0, and abs, min, max and sqrt where their argument passes 0.
/// `count` returns the largest of these counts. An expression without such functions is never narrow.
class Narrowness {
 public:
  explicit Narrowness(const Expression& expression);

  /// Returns false if the expression has sums and products alone.
  bool is_possible() const { return num_to_count_ > 0; }
  std::size_t num_variables() const { return variables_.size(); }
  std::size_t num_results() const { return results_.size(); }
  /// Returns false if `count` does not read variable i.
  bool asks_for(std::size_t i) const { return counts_[static_cast<std::size_t>(variables_[i])] != 0; }

  /// Returns the count in each lane, which is infinite if a kink or a pole may lie among the numbers.
  std::array<double, num_lanes> count(const Intervals* variables) const;
  /// Evaluates the expression itself.
  void evaluate(const double* variables, double* results) const;

  /// Returns the number of operations at which the expression or its derivatives may jump.
  std::size_t num_turns() const { return turns_.size(); }
  /// Writes for each of these the number that changes its sign there: a of abs, a - b of min and max, and y of atan2,
  /// whose cut lies where y = 0 and x < 0.
  void measure_turns(const double* variables, double* values) const;

 private:
  const std::vector<double>& evaluate_all(const double* variables) const;

  std::vector<Expression::Instruction> instructions_;  // equal ones once; c of sinh/cosh: 1 + its argument,
                                                       // of max(|a|, a) and the like: 1, else 0
  std::vector<int> variables_, results_;
  std::vector<char> counts_;        // [instruction] not 0 if `count` needs it
  std::vector<std::size_t> turns_;  // instructions
  std::size_t num_to_count_ = 0;    // number of functions among those that `count` needs
};

}  // namespace tanor::detail
