#include "system/contacts.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "system/members.hpp"

namespace tanor::detail {

bool law_sticks(const Friction& friction) {
  const auto ask = []<class Law>(const Law& law) {
    if constexpr (requires { KindOf<Law>::sticks(law); }) return KindOf<Law>::sticks(law);
    return false;
  };
  return std::visit(ask, friction);
}

double static_coefficient_of(const Friction& friction) {
  const auto ask = []<class Law>(const Law& law) {
    if constexpr (requires { KindOf<Law>::static_coefficient(law); }) return KindOf<Law>::static_coefficient(law);
    return 0.0;
  };
  return std::visit(ask, friction);
}

bool reads_full_reaction(const Friction& friction) {
  const auto ask = []<class Law>(const Law& law) {
    if constexpr (requires { KindOf<Law>::reads_full_reaction(law); }) return KindOf<Law>::reads_full_reaction(law);
    return false;
  };
  return std::visit(ask, friction);
}

static bool is_without_effect(const Friction& friction) {
  const auto ask = []<class Law>(const Law& law) {
    if constexpr (requires { KindOf<Law>::is_without_effect(law); }) return KindOf<Law>::is_without_effect(law);
    return false;
  };
  return std::visit(ask, friction);
}

std::vector<Contact> list_contacts(const System& system) {
  std::vector<Contact> result;
  if (system.friction.empty()) return result;

  // A point of a guide with its rows there.
  struct Guided {
    Index point, first_row;
    int num_rows;
  };
  std::map<std::string, std::vector<Guided>, std::less<>> guides;
  Index row = 0;
  for (std::size_t g = 0; g < system.constraints.size(); ++g) {
    std::visit(
        [&]<class Group>(const Group& group) {
          auto& members = guides[constraint_name(system, g)];
          for (std::size_t k = 0; k < num_members(group); ++k) {
            const std::span<const Index> points = member_points(group, k);
            if (points.size() == 1) members.push_back({points[0], row, rows_per_member<Group>()});
            row += rows_per_member<Group>();
          }
        },
        system.constraints[g]);
  }

  const std::vector<char> is_support = find_supports(system);
  for (std::size_t f = 0; f < system.friction.size(); ++f) {
    const Friction& friction = system.friction[f];
    if (is_without_effect(friction)) continue;
    std::map<Index, std::vector<Index>> rows_of_point;
    for (const std::string& name : std::visit([](const auto& entry) { return entry.at; }, friction)) {
      for (const Guided& guided : guides[name]) {
        for (int k = 0; k < guided.num_rows; ++k) rows_of_point[guided.point].push_back(guided.first_row + k);
      }
    }
    for (auto& [point, rows] : rows_of_point) {
      if (is_support[static_cast<std::size_t>(point)] || rows.size() > 2) continue;
      result.push_back({static_cast<Index>(f), point, std::move(rows), law_sticks(friction)});
    }
  }
  return result;
}

}  // namespace tanor::detail
