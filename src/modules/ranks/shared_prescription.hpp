#pragma once

#include <exception>
#include <span>
#include <utility>

#include "dynamics/equations_of_motion.hpp"
#include "ranks/agreement.hpp"

namespace tanor::detail {

/// The prescribed motion of a rank's part. Ranks go to a new time without a word to each other. What one of them throws
/// there is remembered, and thrown on all by the next agreement.
class SharedPrescription {
 public:
  /// Both arguments outlive it. Collective.
  SharedPrescription(EquationsOfMotion& own, Agreement& agreement)
      : own_(own), agreement_(agreement), is_settled_first_(agreement.any(own.is_prescribed_together())) {}

  void prescribe(double t, double* x, double* v) {
    try {
      own_.prescribe(t, x, v);
    } catch (...) {
      if (!failure_) failure_ = std::current_exception();
    }
  }

  /// Agrees on the outcome of work(), and on what `prescribe` has thrown. Work that is collective itself begins on all
  /// ranks or on none, so that they agree on the latter first. Collective.
  template <class Work>
  Outcome together(const Work& work, std::span<double> numbers = {}) {
    const auto settle = [&] {
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    };
    if (is_settled_first_) {
      (void)agreement_.together([&] {
        settle();
        return Outcome{};
      });
    }
    return agreement_.together(
        [&] {
          settle();
          return work();
        },
        numbers);
  }

 private:
  EquationsOfMotion& own_;
  Agreement& agreement_;
  const bool is_settled_first_;
  std::exception_ptr failure_;  // none since the ranks last agreed if null
};

}  // namespace tanor::detail
