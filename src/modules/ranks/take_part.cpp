#include <tanor/ranks.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/text.hpp"
#include "dynamics/decisions.hpp"
#include "system/chosen_members.hpp"
#include "system/loops.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"
#include "system/strengths.hpp"

namespace tanor {
using namespace detail;

SharedRows::~SharedRows() = default;
Ranks::~Ranks() = default;
std::unique_ptr<SharedRows> Ranks::make_shared_rows(std::size_t, std::span<const std::size_t>) {
  return nullptr;
}

namespace {

/// True if the group means all points, as an empty list of single points does.
template <class Group>
bool means_all_points(const Group& group) {
  if constexpr (requires { KindOf<Group>::members; }) {
    if constexpr (has_single_points<Group>) return list_of(group).empty();
    return false;
  }
  return true;
}

/// Takes one rank's part out of a system.
class PartTaker {
 public:
  PartTaker(const System& system, std::span<const int> owner, Ranks& ranks)
      : whole_(system), owner_(owner.begin(), owner.end()), ranks_(ranks), local_(system.num_points(), -1) {
    if (owner.size() != system.num_points())
      throw InputError("", text(owner.size()) + " owners for " + text(system.num_points()) + " points");
    if (ranks.size() > 1) refuse_breaks(system, "members break on one rank alone; take one, or leave it out");
    for (const Support& support : system.supports)
      for (const Index point : support.points) owner_[static_cast<std::size_t>(point)] = nobody;
    for (const int rank : owner_) {
      if (rank >= ranks.size())
        throw InputError("", "rank " + text(rank) + " owns points; there are " + text(ranks.size()) + " ranks");
    }
  }

  RankSystem take() {
    list_points();
    take_constraints();
    take_forces();
    take_friction();
    take_coordinates();
    take_points();
    list_shared_neighbourhoods();
    return std::move(result_);
  }

 private:
  static constexpr int nobody = -1;
  int rank() const { return ranks_.rank(); }
  int owner(Index point) const { return owner_[static_cast<std::size_t>(point)]; }
  Index local(Index point) const { return local_[static_cast<std::size_t>(point)]; }

  /// Returns the ranks that own points of a member, in ascending order.
  std::vector<int> owners_of(std::span<const Index> points) const {
    std::vector<int> result;
    for (const Index point : points)
      if (owner(point) != nobody) result.push_back(owner(point));
    std::ranges::sort(result);
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
  }
  /// True if this rank has a member with these owners. Members between supports alone are the first rank's.
  bool has(const std::vector<int>& owners) const {
    return owners.empty() ? rank() == 0 : std::ranges::binary_search(owners, rank());
  }

  void add_point(Index point) {
    if (local(point) >= 0) return;
    local_[static_cast<std::size_t>(point)] = static_cast<Index>(result_.points.size());
    result_.points.push_back(point);
  }

  /// Lists own points in their order, then supports and guests that members need, and which points are guests on which
  /// rank.
  void list_points() {
    const std::size_t num_points = whole_.num_points();
    for (std::size_t i = 0; i < num_points; ++i)
      if (owner_[i] == rank()) add_point(static_cast<Index>(i));
    result_.num_owned = result_.points.size();
    std::vector<std::set<Index>> sent(static_cast<std::size_t>(ranks_.size())), received(sent.size());
    const auto visit_member = [&](std::span<const Index> points) {
      const std::vector<int> owners = owners_of(points);
      if (!has(owners)) return;
      for (const Index point : points) {
        if (owner(point) == nobody) needed_supports_.insert(point);
        if (owner(point) >= 0 && owner(point) != rank()) received[static_cast<std::size_t>(owner(point))].insert(point);
        for (const int other : owners)
          if (owner(point) == rank() && other != rank()) sent[static_cast<std::size_t>(other)].insert(point);
      }
    };
    for_each_member(whole_, [&](std::span<const Index> points, int) { visit_member(points); });
    for_each_tuple(whole_, visit_member);
    const auto visit_single_points = [&]<class Group>(const Group& group) {
      if constexpr (std::is_same_v<Group, PairForces>) {
        const std::vector<Index> points = points_of(whole_, group);
        if (!has_cutoff(group) || owners_of(points).size() <= 1) visit_member(points);
      } else if constexpr (requires { KindOf<Group>::members; }) {
        if (!has_single_points<Group>) return;  // these are tuples, see above
        for (std::size_t k = 0; k < num_members(group); ++k) visit_member(member_points(group, k));
      }
    };
    for (const Force& force : whole_.forces) std::visit(visit_single_points, force);
    for (const Coordinates& coordinates : whole_.coordinates)
      if (const auto* const chain = std::get_if<ChainAngles>(&coordinates))
        visit_member(KindOf<ChainAngles>::tied_points(*chain));
    if (rank() == 0) {  // supports that no member needs
      for (std::size_t i = 0; i < num_points; ++i)
        if (owner_[i] == nobody) needed_supports_.insert(static_cast<Index>(i));
    }
    for (const Index point : needed_supports_) add_point(point);
    for (std::size_t r = 0; r < received.size(); ++r) {
      if (received[r].empty() && sent[r].empty()) continue;
      Part::Link& link = result_.part.links.emplace_back(Part::Link{static_cast<int>(r), {}, {}});
      for (const Index point : received[r]) {
        add_point(point);
        link.received.push_back(local(point));
        result_.part.guests.push_back(local(point));
      }
      for (const Index point : sent[r]) link.sent.push_back(local(point));
    }
    result_.part.ranks = &ranks_;
    result_.part.may_lose_rank = closes_loops(whole_);
  }

  template <class Group>
  Group with_local_points(Group group) const {
    const auto rename = [&](Index& point) { point = local(point); };
    if constexpr (has_single_points<Group> && requires { group.tuples; }) {
      for (std::vector<Index>& points : group.tuples) std::ranges::for_each(points, rename);
    }
    for (auto& member : group.*KindOf<Group>::members) {
      if constexpr (has_single_points<Group>)
        rename(member);
      else
        std::ranges::for_each(member, rename);
    }
    return group;
  }

  void take_constraints() {
    std::size_t equation = 0;
    for (std::size_t g = 0; g < whole_.constraints.size(); ++g) {
      std::visit(
          [&]<class Group>(const Group& group) {
            constexpr auto rows = static_cast<std::size_t>(rows_per_member<Group>());
            std::vector<std::size_t> members;
            for (std::size_t k = 0; k < num_members(group); ++k, equation += rows) {
              const std::vector<int> owners = owners_of(member_points(group, k));
              const bool is_here = has(owners);
              if (is_here) members.push_back(k);
              for (std::size_t row = 0; row < rows; ++row) note_equation(equation + row, owners, is_here);
            }
            if (members.empty()) return;
            Group own = with_local_points(with_members(group, members));
            own.name = constraint_name(whole_, g);
            result_.system.constraints.emplace_back(std::move(own));
            names_.insert(constraint_name(whole_, g));
          },
          whole_.constraints[g]);
    }
  }

  void note_equation(std::size_t equation, const std::vector<int>& owners, bool is_here) {
    Part& part = result_.part;
    const std::size_t place = owners.size() > 1 ? part.num_shared_rows++ : 0;
    if (!is_here) return;
    if (owners.size() > 1) part.shared_rows.push_back({result_.equations.size(), place, owners.front() == rank()});
    result_.equations.push_back(equation);
  }

  void take_forces() {
    for (std::size_t f = 0; f < whole_.forces.size(); ++f) {
      std::visit([&](const auto& group) { take_force(group, f); }, whole_.forces[f]);
    }
  }

  template <class Group>
  void take_force(const Group& group, std::size_t f) {
    const std::string where = "/forces/" + text(f);
    const bool is_on_all = means_all_points(group);
    const std::string name = force_name(whole_, f);
    if constexpr (std::is_same_v<Group, PairForces>) return take_pairs(group, name, where);
    if constexpr (joins_points<Group>()) {
      if (!has_single_points<Group> || !tuples_of(group).empty()) return take_tuples(group, name, where);
    }
    Group own = group;
    own.name = name;
    if constexpr (requires { KindOf<Group>::members; }) {
      if (!is_on_all) {
        own = with_members_if(own, [&](std::size_t k) { return has(owners_of(member_points(group, k))); });
        if (list_of(own).empty()) return;
        own = with_local_points(std::move(own));
      } else if constexpr (has_single_points<Group>) {
        for (std::size_t i = 0; i < result_.num_owned; ++i)  // guests belong to others
          (own.*KindOf<Group>::members).push_back(static_cast<Index>(i));
        if (list_of(own).empty()) return;
      }
    }
    result_.system.forces.emplace_back(std::move(own));
  }

  /// Takes tuples with own points. If other ranks have some, too, the first of them counts the energy.
  template <class Group>
  void take_tuples(const Group& group, const std::string& name, const std::string& where) {
    std::vector<std::size_t> counted_here, counted_elsewhere;
    for (std::size_t k = 0; k < tuples_of(group).size(); ++k) {
      const std::span<const Index> points(tuples_of(group)[k]);
      const std::vector<int> owners = owners_of(points);
      if (owners.size() > 1) {
        ++result_.part.num_shared_tuples;
        if (std::ranges::any_of(points, [&](Index point) { return owner(point) == nobody; }))
          throw InputError(where, name + "[" + text(k) + "] joins a support to points of several ranks");
      }
      if (!has(owners)) continue;
      const bool is_first = owners.empty() || owners.front() == rank();
      (is_first ? counted_here : counted_elsewhere).push_back(k);
    }
    add_tuples(group, name, counted_here);
    if (counted_elsewhere.empty()) return;
    result_.part.energies_counted_elsewhere.push_back(result_.system.forces.size());
    add_tuples(group, name + " (to other ranks)", counted_elsewhere);
  }
  template <class Group>
  void add_tuples(const Group& group, const std::string& name, const std::vector<std::size_t>& chosen) {
    if (chosen.empty()) return;
    Group own;
    if constexpr (requires { own.tuples; })
      choose(chosen, group.tuples.size(), &(own = group).tuples);
    else
      own = with_members(group, chosen);
    own.name = name;
    result_.system.forces.emplace_back(with_local_points(std::move(own)));
  }

  /// Takes all pairs of one rank's points. If several ranks have points, takes the pairs of own points, and shares the
  /// others. Without a cutoff these are pairs with guests.
  void take_pairs(const PairForces& group, const std::string& name, const std::string& where) {
    PairForces own = group;
    own.name = name;
    own.points = points_of(whole_, group);
    const std::vector<int> owners = owners_of(own.points);
    if (owners.size() > 1) require_moving(own, name, where);
    if (owners.size() > 1 && has_cutoff(own)) {
      std::erase_if(own.points, [&](Index point) { return owner(point) != rank(); });
      share_pairs(own);
    } else {
      result_.part.num_shared_tuples += count_shared(own.points);
      if (!has(owners)) return;
      if (owners.size() > 1) result_.part.energies_counted_elsewhere.push_back(result_.system.forces.size());
    }
    if (own.points.empty()) return;
    result_.system.forces.emplace_back(with_local_points(std::move(own)));
  }

  /// Returns the number of pairs of these points that are on different ranks.
  std::size_t count_shared(std::span<const Index> points) const {
    std::vector<std::size_t> counts(static_cast<std::size_t>(ranks_.size()), 0);
    std::size_t before = 0, pairs = 0;
    for (const Index point : points) {
      if (owner(point) == nobody) continue;
      std::size_t& here = counts[static_cast<std::size_t>(owner(point))];
      pairs += before++ - here++;
    }
    return pairs;
  }

  /// Throws if a support takes part. What it carries is counted once, by a rank that has all of it.
  void require_moving(const PairForces& pairs, const std::string& name, const std::string& where) const {
    if (std::ranges::any_of(pairs.points, [&](Index point) { return owner(point) == nobody; }))
      throw InputError(where, name + " join supports to points of several ranks; take one rank");
  }

  /// Shares pairs. `own` are the pairs of own points alone, by their numbers in the whole system.
  void share_pairs(const PairForces& own) {
    Part::SharedPairs shared{with_local_points(own), own.points, {}};
    std::vector<Index> place(whole_.num_points(), -1);
    for (std::size_t k = 0; k < own.points.size(); ++k)
      place[static_cast<std::size_t>(own.points[k])] = static_cast<Index>(k);
    const auto exclude = [&](Index here, Index there) {
      if (place[static_cast<std::size_t>(here)] >= 0 && owner(there) != rank())
        shared.excluded.push_back({place[static_cast<std::size_t>(here)], there});
    };
    for (const Constraint& constraint : whole_.constraints) {
      const Rods* const rods = own.exclude_rods ? std::get_if<Rods>(&constraint) : nullptr;
      if (rods == nullptr) continue;
      for (const auto& [a, b] : rods->pairs) {
        exclude(a, b);
        exclude(b, a);
      }
    }
    result_.part.shared_pairs.push_back(std::move(shared));
  }

  void take_friction() {
    for (std::size_t f = 0; f < whole_.friction.size(); ++f) {
      std::visit(
          [&](auto law) {
            law.name = friction_name(whole_, f);
            std::erase_if(law.at, [&](const std::string& name) { return !names_.contains(name); });
            if (!law.at.empty()) result_.system.friction.emplace_back(std::move(law));
          },
          whole_.friction[f]);
    }
    if (has_contacts(whole_)) require_whole_islands("/friction", "there is friction");
  }

  /// Takes coordinates of own points. Those that tie points to one another are whole.
  void take_coordinates() {
    for (std::size_t k = 0; k < whole_.coordinates.size(); ++k) {
      std::visit(
          [&]<class Group>(const Group& group) {
            Group own = with_members_if(group, [&](std::size_t m) { return has_whole(member_points(group, m), k); });
            if constexpr (requires { KindOf<Group>::tied_points(group); }) (void)has_whole(group.points, k);
            if (list_of(own).empty()) return;
            own = with_local_points(std::move(own));
            own.name = coordinates_name(whole_, k);
            if constexpr (requires { own.anchor; }) own.anchor = local(own.anchor);
            result_.system.coordinates.emplace_back(std::move(own));
          },
          whole_.coordinates[k]);
    }
    if (!whole_.coordinates.empty()) require_whole_islands("/coordinates", "there are coordinates");
  }

  /// Returns true if this rank owns the points. Throws if several do.
  bool has_whole(std::span<const Index> points, std::size_t coordinates) const {
    const std::vector<int> owners = owners_of(points);
    if (owners.size() > 1)
      throw InputError("/coordinates/" + text(coordinates),
                       coordinates_name(whole_, coordinates) + ": its points lie on several ranks");
    return has(owners);
  }

  void require_whole_islands(const std::string& where, const std::string& why) const {
    if (result_.part.is_cut())
      throw InputError(where, "where " + why +
                                  ", all islands lie whole on their ranks; here constraints or forces join points of "
                                  "several");
  }

  void take_points() {
    System& own = result_.system;
    own.name = whole_.name;
    own.units = whole_.units;
    own.positions = rows_of(whole_.positions, result_.points, 3);
    own.velocities = rows_of(whole_.velocities, result_.points, 3);
    own.masses = rows_of(whole_.masses, result_.points, 1);
    for (const Support& support : whole_.supports) {
      Support here{support.name, {}, support.displacement};
      for (const Index point : support.points)
        if (local(point) >= 0) here.points.push_back(local(point));
      if (!here.points.empty()) own.supports.push_back(std::move(here));
    }
    if (!result_.part.guests.empty()) own.supports.push_back({"points of other ranks", result_.part.guests, {}});
  }

  /// Finds neighbourhoods on the whole system, since their lengths decide how small an error is.
  void list_shared_neighbourhoods() {
    Part& part = result_.part;
    if (!part.is_cut()) return;
    const Neighbourhoods all = find_neighbourhoods(whole_, 0.0);
    std::vector<int> first_owner(all.size(), nobody);
    std::vector<Index> number(all.size(), -1);
    for (std::size_t i = 0; i < whole_.num_points(); ++i) {
      if (all.of_point[i] < 0) continue;
      const auto k = static_cast<std::size_t>(all.of_point[i]);
      if (first_owner[k] == nobody) first_owner[k] = owner_[i];
      if (first_owner[k] != owner_[i] && number[k] < 0)
        number[k] = static_cast<Index>(part.num_shared_neighbourhoods++);
    }
    for (const Index point : result_.points) {
      const Index k = all.of_point[static_cast<std::size_t>(point)];
      part.shared_neighbourhood.push_back(k < 0 ? -1 : number[static_cast<std::size_t>(k)]);
    }
  }

  const System& whole_;
  std::vector<int> owner_;
  Ranks& ranks_;
  std::vector<Index> local_;  // [point of the whole system] -1 if not here
  std::set<Index> needed_supports_;
  std::set<std::string> names_;  // names of groups of constraints that are here
  RankSystem result_;
};

}  // namespace

RankSystem take_part(const System& system, std::span<const int> owner, Ranks& ranks) {
  return PartTaker(system, owner, ranks).take();
}

RankSystem join_parts(System own, Ranks& ranks) {
  Decisions all(&ranks);
  const bool has_coordinates = all.any(!own.coordinates.empty());
  if (has_coordinates && !all.all(!own.coordinates.empty()))
    throw InputError("/coordinates", "are given on some ranks alone; every point that moves is covered, or none is");
  const Share points = all.share(own.num_points()), equations = all.share(num_equations(own));
  constexpr auto most = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  if (points.all() > most)
    throw InputError("", text(points.all()) + " points on all ranks together; their numbers end at " + text(most));
  RankSystem result;
  result.num_owned = own.num_points();
  result.points.resize(own.num_points());
  std::iota(result.points.begin(), result.points.end(), static_cast<Index>(points.first));
  result.equations.resize(num_equations(own));
  std::iota(result.equations.begin(), result.equations.end(), equations.first);
  result.part.ranks = &ranks;
  result.system = std::move(own);
  return result;
}

}  // namespace tanor
