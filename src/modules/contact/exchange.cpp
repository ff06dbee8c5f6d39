#include "contact/exchange.hpp"

namespace tanor::detail {

std::vector<std::size_t> Exchange::choose(const std::vector<std::size_t>& wrong, const std::vector<bool>& open) {
  constexpr int most_patience = 10;
  if (wrong.empty()) {
    *this = {};
    return {};
  }
  if (wrong.size() < fewest_) {
    fewest_ = wrong.size();
    patience_ = most_patience;
    seen_.clear();
    return wrong;
  }
  if (patience_ > 0) {
    --patience_;
    return wrong;
  }
  is_stuck_ = !seen_.insert(open).second;
  return {wrong.back()};
}

}  // namespace tanor::detail
