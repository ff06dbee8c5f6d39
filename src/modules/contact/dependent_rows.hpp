#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dynamics/constrained_system.hpp"

namespace tanor::detail {

/// An instant at which one-sided rows depend on others. K is that of all rows that may be closed.
struct DependentProblem {
  std::span<const char> may_close;        ///< [one-sided row]
  std::span<const double> b;              ///< [row] what they do when one-sided ones are open: K'w + phi, or (1 + e) K'v
  std::span<const double> multipliers{};  ///< [row] those of the others then; empty: 0
};

/// Chooses the closed rows of islands in which rows depend on others, so that S has no inverse and forces are not
/// unique. A small compliance, the same in all of their rows, makes one answer of
///
///   0 <= p  _|_  (S + c) p + b >= 0,
///
/// that of the least |lambda| among all with p >= 0 as c vanishes (Tikhonov). Rows that contradict others, as the
/// longer one of two ropes on a line, are open there. Returns [one-sided row] which ones are closed, as many of
/// `may_close` as lie in other islands, or nothing if no one-sided row is in such an island, or too many rows are.
std::optional<std::vector<char>> close_dependent_rows(const Model& model, const ConstrainedSystem& system,
                                                      const DependentProblem& problem);

}  // namespace tanor::detail
