#pragma once

#include <array>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "scene/imported.hpp"

namespace tanor::scene {

/// Collects the edges of a file as bonds, each once, although faces and lists name many of them twice.
class Edges {
 public:
  void add(std::int32_t i, std::int32_t j) {
    const auto low = static_cast<std::uint64_t>(i < j ? i : j), high = static_cast<std::uint64_t>(i < j ? j : i);
    if (known_.insert(high << 32 | low).second) bonds_.push_back({1, {i, j}});
  }
  std::vector<Imported::Bond> take() { return std::move(bonds_); }

 private:
  std::unordered_set<std::uint64_t> known_;
  std::vector<Imported::Bond> bonds_;
};

}  // namespace tanor::scene
