#pragma once

#include <cstddef>
#include <vector>

#include <tanor/expression.hpp>

namespace tanor::detail {

/// The members that stand side by side in a SeriesLane, which is a view of doubles at any address.
inline constexpr std::size_t series_width = 8;
using SeriesLane =
    double __attribute__((vector_size(series_width * sizeof(double)), aligned(sizeof(double)), may_alias));

/// The number of members in a lane; a plain double holds one.
template <class Lane>
inline constexpr std::size_t width_of = sizeof(Lane) / sizeof(double);
inline double& member_of(SeriesLane& lane, std::size_t m) {
  return reinterpret_cast<double*>(&lane)[m];
}
inline double member_of(const SeriesLane& lane, std::size_t m) {
  return lane[m];
}
inline double& member_of(double& lane, std::size_t) {
  return lane;
}
inline double member_of(const double& lane, std::size_t) {
  return lane;
}

/// Runs an expression on series in time, coefficient by coefficient, `series_width` members at once. Coefficient k of
/// every instruction follows from the coefficients up to k of those before it (Griewank & Walther, table 13.2), and
/// coefficient k of every adjoint from the coefficients up to k of the values and of the adjoints behind it.
///
/// The caller keeps one member's O(order) numbers of each instruction: `num_lanes(order)` lanes, which are SeriesLane,
/// or double for a member that is alone.
class SeriesProgram {
 public:
  SeriesProgram() = default;
  SeriesProgram(const Expression& expression, bool with_adjoints);

  std::size_t num_variables() const { return expression_.variables.size(); }
  std::size_t num_results() const { return expression_.results.size(); }
  /// Returns true if no product or function has variables for which `counts` is true; their adjoints never change.
  bool is_linear_in(const std::vector<char>& counts) const;

  std::size_t num_lanes(int order) const {
    return (num_instructions() + num_adjoints_ + num_quotients_) * stride(order);
  }

  /// Returns coefficients 0 … order of variable i; `result` returns those of result m.
  template <class Lane>
  Lane* variable(Lane* lanes, int order, std::size_t i) const {
    return lanes + number(expression_.variables[i]) * stride(order);
  }
  template <class Lane>
  const Lane* result(const Lane* lanes, int order, std::size_t m) const {
    return lanes + number(expression_.results[m]) * stride(order);
  }
  /// Returns the adjoint of variable i, which is the sum over the results of (d result/d variable) seed.
  template <class Lane>
  const Lane* adjoint(const Lane* lanes, int order, std::size_t i) const {
    return lanes + (num_instructions() + number(expression_.variables[i])) * stride(order);
  }

  /// Evaluates coefficient k of everything, from that of the variables.
  template <class Lane>
  void evaluate(Lane* lanes, int order, int k) const;
  /// Evaluates coefficient k of all adjoints, from that of the seeds, one for each result. Values are known up to k.
  template <class Lane>
  void differentiate(Lane* lanes, int order, int k, const Lane* seeds) const;

 private:
  static std::size_t number(int instruction) { return static_cast<std::size_t>(instruction); }
  static std::size_t stride(int order) { return static_cast<std::size_t>(order) + 1; }
  std::size_t num_instructions() const { return expression_.instructions.size(); }

  Expression expression_;
  std::size_t num_adjoints_ = 0, num_quotients_ = 0;
  std::vector<int> quotient_;  // [instruction] its slot among the quotients; -1: it needs none
};

}  // namespace tanor::detail
