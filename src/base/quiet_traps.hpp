#pragma once

#include <cfenv>
#include <memory>
#include <utility>

namespace tanor {

/// Switches the thread's floating-point traps off while it lives. A host that has traps on then does not notice our
/// infinities and NaN, which we test for ourselves, nor the flags that they leave behind. It costs next to nothing
/// where no trap is on.
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

/// Makes a new object while the traps are off.
template <class T, class... Arguments>
std::unique_ptr<T> make_quietly(Arguments&&... arguments) {
  const QuietTraps quiet;
  return std::make_unique<T>(std::forward<Arguments>(arguments)...);
}

}  // namespace tanor
