#include "host/group_names.hpp"

#include <algorithm>

namespace tanor::detail {

namespace {

/// The first character of a group's name in a part: "\x1f3" is the host's group 3.
constexpr char mark = '\x1f';

}  // namespace

std::string part_name_of_group(std::size_t group) {
  return mark + std::to_string(group);
}

std::string with_host_names(const Inventory& inventory, std::span<const ConstraintId> members,
                            const std::string& text) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find(mark, at);
    result += text.substr(at, begin - at);
    if (begin == std::string::npos) break;
    const std::size_t open = text.find('[', begin), close = text.find(']', begin);
    at = text.find_first_not_of("0123456789", begin + 1);
    const auto group = std::stoul(text.substr(begin + 1));
    const auto is_there = [&](ConstraintId id) { return inventory.group_number(id) == group; };
    const auto first = std::ranges::find_if(members, is_there);
    if (open != at || first == members.end()) {
      result += inventory.group_name(group);
      continue;
    }
    result += inventory.member_name(*(first + static_cast<std::ptrdiff_t>(std::stoul(text.substr(open + 1)))));
    at = close + 1;
  }
  return result;
}

}  // namespace tanor::detail
