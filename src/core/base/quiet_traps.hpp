#pragma once

#include <cfenv>
#include <memory>
#include <utility>

namespace tanor::detail {

/// Switches the floating-point traps of the thread off for its lifetime. A host with enabled traps then notices neither
/// our infinities and NaN, which we test for ourselves, nor the flags that they leave behind. It costs next to nothing
/// if no trap is enabled.
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

/// Constructs a new object with the traps switched off.
template <class T, class... Arguments>
std::unique_ptr<T> make_quietly(Arguments&&... arguments) {
  const QuietTraps quiet;
  return std::make_unique<T>(std::forward<Arguments>(arguments)...);
}

}  // namespace tanor::detail
