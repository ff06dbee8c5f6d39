#pragma once

#include <cstddef>
#include <set>
#include <vector>

namespace tanor::detail {

/// Chooses which of the wrong rows change sides. All of them do while they become fewer, and for some rounds more; then
/// only the last one does until they are fewer than ever (Murty 1974; Judice & Pires 1994). With a positive definite
/// stiffness no set recurs; if one does, `is_stuck`.
class Exchange {
 public:
  std::vector<std::size_t> choose(const std::vector<std::size_t>& wrong, const std::vector<bool>& open);
  bool is_stuck() const { return is_stuck_; }

 private:
  std::size_t fewest_ = ~std::size_t{0};
  int patience_ = 0;
  bool is_stuck_ = false;
  std::set<std::vector<bool>> seen_;  // sets met while one row changes at a time
};

}  // namespace tanor::detail
