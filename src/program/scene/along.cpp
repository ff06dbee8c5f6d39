#include "scene/along.hpp"

#include <string>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

namespace tanor::scene {
namespace {

const Rods& find_rods(const Cursor& along, const Context& context) {
  const std::string& wanted = along.string();
  std::string names;
  for (const Constraint& constraint : context.constraints) {
    const Rods* const rods = std::get_if<Rods>(&constraint);
    if (rods == nullptr) continue;
    if (rods->name == wanted) {
      if (!rods->offsets.empty()) along.complain("some of these rods join images in a periodic box, energies do not");
      return *rods;
    }
    names += (names.empty() ? "\"" : ", \"") + rods->name + "\"";
  }
  along.fail(names.empty() ? "the name of rods, of which there are none" : "the name of rods: " + names);
}

/// The points of rods with their neighbours, in the order in which the rods name them.
class Sequence {
 public:
  Sequence(const Cursor& along, const Context& context) : rods_(find_rods(along, context)) {
    context.take_room(rods_.pairs.size());
    for (const auto& [i, j] : rods_.pairs) {
      join(along, i, j);
      join(along, j, i);
    }
  }

  const std::vector<std::array<Index, 2>>& pairs() const { return rods_.pairs; }
  const std::vector<Index>& points() const { return points_; }
  bool is_inside(Index point) const { return neighbours_.at(point)[1] >= 0; }
  const std::array<Index, 2>& neighbours(Index point) const { return neighbours_.at(point); }
  Index other_neighbour(Index point, Index than) const {
    const auto& [a, b] = neighbours_.at(point);
    return a == than ? b : a;
  }

 private:
  void join(const Cursor& along, Index point, Index neighbour) {
    const auto [entry, is_new] = neighbours_.try_emplace(point, std::array<Index, 2>{neighbour, -1});
    if (is_new) {
      points_.push_back(point);
    } else if (entry->second[1] < 0) {
      entry->second[1] = neighbour;
    } else {
      along.complain(fmt::format(
          "three or more of these rods meet at point {}: which of them are in sequence is not clear there", point));
    }
  }

  const Rods& rods_;
  std::vector<Index> points_;
  std::unordered_map<Index, std::array<Index, 2>> neighbours_;  // -1 if there is no second one
};

template <class Members>
void expect_some(const Cursor& along, const Members& members, const char* what) {
  if (members.empty()) along.complain(fmt::format("no {} of these rods are in sequence", what));
}

}  // namespace

void read_along(const Cursor& along, const Context& context, std::vector<std::array<Index, 3>>* triples) {
  const Sequence sequence(along, context);
  for (const Index point : sequence.points()) {
    if (!sequence.is_inside(point)) continue;
    const auto& [before, behind] = sequence.neighbours(point);
    triples->push_back({before, point, behind});
  }
  expect_some(along, *triples, "two");
}

void read_along(const Cursor& along, const Context& context, std::vector<std::array<Index, 4>>* quadruples) {
  const Sequence sequence(along, context);
  for (const auto& [i, j] : sequence.pairs()) {
    if (!sequence.is_inside(i) || !sequence.is_inside(j)) continue;
    const Index before = sequence.other_neighbour(i, j), behind = sequence.other_neighbour(j, i);
    if (before == behind)
      along.complain(fmt::format(
          "three of these rods close a triangle of points {}, {} and {}, where there is no dihedral", before, i, j));
    quadruples->push_back({before, i, j, behind});
  }
  expect_some(along, *quadruples, "three");
}

}  // namespace tanor::scene
