#pragma once

#include <span>
#include <vector>

#include "contact/gaps.hpp"

namespace tanor::detail {

/// One-sided rows of islands in which rows depend on others, so that S has no inverse and forces are not unique. A
/// small compliance, the same in all rows of an island, makes one answer of
///
///   0 <= p  _|_  (S + c) p + b >= 0,
///
/// that of the least |lambda| among all with p >= 0 as c vanishes (Tikhonov). Rows that contradict others, as the
/// longer one of two ropes on a line, are open there. Islands of more than 1000 rows are left alone, for S is dense.
class DependentRows {
 public:
  /// All arguments must outlive this object.
  DependentRows(const Model& model, ConstrainedSystem& system, Gaps& gaps);

  /// Returns true if a row of `which` [one-sided row] is in such an island.
  bool have(std::span<const char> which) const;
  /// Sets what rows do when all of these one-sided ones are open: b = (1 + e) K'v [row] before an impact, …
  void set_rates(std::vector<double> b);
  /// … or K'w + phi at (r, v) with the accelerations w [3n] and multipliers [row] then.
  void set_accelerations(const double* r, const double* v, const double* w, std::vector<double> multipliers);
  /// Ropes of different length on one line do the same where points rest, and differ as soon as these move. Takes b of
  /// a moment later in islands whose points rest where rows may close; w are the accelerations with those found now.
  /// Returns true if there are any.
  bool look_ahead(const double* r, const double* v, const double* w, std::span<const char> may_close);
  /// Chooses the closed ones of the rows that may close, whose K is present. Returns all [one-sided row]; those of
  /// other islands are as they may be.
  std::vector<char> choose(std::span<const char> may_close) const;

 private:
  struct Island;
  std::vector<char> mark_islands(std::span<const char> which) const;
  std::vector<Island> collect(std::span<const char> may_close) const;

  const Model& model_;
  ConstrainedSystem& system_;
  Gaps& gaps_;
  std::vector<std::size_t> island_;               // [row]
  std::vector<double> b_, multipliers_, free_w_;  // [row], [row], [3n]; the last two are empty at impacts
};

}  // namespace tanor::detail
