#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <tanor/solver_options.hpp>

namespace tanor::detail {

/// The size and the cost of a factor, all parts together.
struct FactorSummary {
  std::size_t parts = 0;                        ///< groups of islands with a factor of their own
  std::size_t pattern_nonzeros = 0;             ///< in the lower triangle of the matrix
  std::size_t factor_nonzeros = 0;              ///< in the factor L
  double flops = 0.0;                           ///< of one factorization
  std::vector<Ordering> orderings{};            ///< of sparse factors, each once
  std::vector<Factorization> factorizations{};  ///< likewise

  /// Returns true if a factorization costs no more than two solves.
  bool is_cheap() const {
    constexpr double solves = 2.0, flops_a_nonzero = 4.0;  // of one solve
    return flops <= solves * flops_a_nonzero * static_cast<double>(factor_nonzeros);
  }
  /// Adds the parts of `other`.
  void include(const FactorSummary& other) {
    parts += other.parts;
    pattern_nonzeros += other.pattern_nonzeros;
    factor_nonzeros += other.factor_nonzeros;
    flops += other.flops;
    for (const Ordering each : other.orderings) add_new(each, &orderings);
    for (const Factorization each : other.factorizations) add_new(each, &factorizations);
  }

  template <class Value>
  static void add_new(Value value, std::vector<Value>* list) {
    if (std::find(list->begin(), list->end(), value) == list->end()) list->push_back(value);
  }
};

}  // namespace tanor::detail
