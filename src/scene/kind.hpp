#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scene/context.hpp"

namespace tanor::scene {

/// One kind of constraint, force or generator: its name, the keys beside `kind`, and how it is read.
template <class Entry>
struct Kind {
  std::string_view name;
  std::vector<std::string_view> keys;
  Entry (*read)(const Cursor& entry, const Context& context);
};

/// Reads {"kind": …}; `planned` are kinds of the contract that this version does not have yet.
template <class Entry>
Entry read_kind(const Cursor& entry, const std::vector<Kind<Entry>>& kinds,
                const std::vector<std::string_view>& planned, const Context& context) {
  std::vector<std::string_view> names;
  for (const Kind<Entry>& kind : kinds) names.push_back(kind.name);
  const Kind<Entry>& kind = kinds[entry["kind"].choice_index(names, planned)];

  std::vector<std::string_view> keys = {"kind"};
  keys.insert(keys.end(), kind.keys.begin(), kind.keys.end());
  return kind.read(entry.object(keys), context);
}

}  // namespace tanor::scene
