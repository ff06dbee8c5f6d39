#pragma once

#include <cfenv>
#include <memory>
#include <utility>

namespace tanor {

/// While it lives the thread's floating-point traps are off: a host that has them on sees infinities and NaN of ours,
/// which we test for, as little as the flags that they leave behind. Costs next to nothing where none is on.
class QuietTraps {
 public:
#if defined(__GLIBC__)
  QuietTraps() : enabled_(fegetexcept()) {
    if (enabled_ > 0) fedisableexcept(enabled_);
  }
  ~QuietTraps() {
    if (enabled_ <= 0) return;
    std::feclearexcept(enabled_);
    feenableexcept(enabled_);
  }
#else
  QuietTraps() = default;
#endif
  QuietTraps(const QuietTraps&) = delete;
  QuietTraps& operator=(const QuietTraps&) = delete;

 private:
  [[maybe_unused]] const int enabled_{};
};

/// A new object, made without traps.
template <class T, class... Arguments>
std::unique_ptr<T> make_quietly(Arguments&&... arguments) {
  const QuietTraps quiet;
  return std::make_unique<T>(std::forward<Arguments>(arguments)...);
}

}  // namespace tanor
