#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "scene/document.hpp"

namespace tanor::scene {

/// Names for one line of a message: each once, in the order in which they were added, and not too many of them.
class NameList {
 public:
  void add(std::string_view name) {
    constexpr std::size_t most = 20;
    if (std::ranges::find(names_, name) != names_.end()) return;
    if (names_.size() < most)
      names_.emplace_back(name);
    else
      is_cut_ = true;
  }
  bool empty() const { return names_.empty(); }
  /// Returns "vn", "vt", …
  std::string quote_all() const {
    std::string list;
    for (const std::string& name : names_) list += (list.empty() ? "" : ", ") + quote(name);
    return is_cut_ ? list + ", …" : list;
  }
  std::string join(const std::string& between) const {
    std::string list;
    for (const std::string& name : names_) list += (list.empty() ? "" : between) + name;
    return list;
  }

 private:
  std::vector<std::string> names_;
  bool is_cut_ = false;
};

}  // namespace tanor::scene
