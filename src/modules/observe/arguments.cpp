#include "observe/arguments.hpp"

#include <algorithm>
#include <charconv>

#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "system/chosen_members.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\n\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\n\r") - first + 1);
}

/// Returns the number that is all of a text.
template <class Number>
std::optional<Number> read_number(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stop != end) return {};
  return number;
}

/// Returns the numbers of "[1, 2, 3]", or nothing if the text is no such list.
template <class Number>
std::optional<std::vector<Number>> read_list(std::string_view text) {
  if (text.size() < 2 || text.front() != '[' || text.back() != ']') return {};
  std::vector<Number> numbers;
  text = text.substr(1, text.size() - 2);
  while (true) {
    const std::size_t comma = std::min(text.find(','), text.size());
    const std::optional<Number> number = read_number<Number>(trim(text.substr(0, comma)));
    if (!number) return {};
    numbers.push_back(*number);
    if (comma == text.size()) return numbers;
    text.remove_prefix(comma + 1);
  }
}

const char* word_for(Thing::List list) {
  return list == Thing::List::Constraints ? "constraints" : list == Thing::List::Supports ? "supports" : "forces";
}

}  // namespace

std::string place_in_system(const Thing& thing) {
  const std::string place = std::string(word_for(thing.list)) + "/" + text(thing.index);
  return thing.member ? place + "/" + text(*thing.member) : place;
}

void Arguments::require(std::size_t least, std::size_t most, std::string_view wanted) const {
  if (list.size() < least || list.size() > most)
    throw TextFault{place, std::string(quantity) +
                               (most > 0 ? " takes (" + std::string(wanted) + ")" : " takes nothing in its brackets")};
}

std::string quoted_name(const std::string& name) {
  if (name.find_first_of(",()[]") == std::string::npos && name == trim(name) && !name.empty() && name[0] != '\'')
    return name;
  std::string quoted = "'";
  for (const char c : name) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

Arguments read_arguments(std::string_view text, std::string_view quantity, std::size_t begin, std::size_t* place) {
  Arguments arguments{quantity, begin, {}};
  std::size_t at = *place + 1, first = at, depth = 0;
  Quotes quotes;
  quotes.hold('(');
  const auto take = [&](std::size_t end) {
    const std::string_view all = text.substr(first, end - first);
    const std::string_view inner = trim(all);
    const std::size_t start = inner.empty() ? first : static_cast<std::size_t>(inner.data() - text.data());
    std::string name(inner);
    const bool is_quoted = inner.size() >= 2 && inner.front() == '\'' && inner.back() == '\'';
    if (is_quoted) {
      name = inner.substr(1, inner.size() - 2);
      for (std::size_t k = 0; (k = name.find("''", k)) != std::string::npos; ++k) name.erase(k, 1);
    }
    arguments.list.push_back({std::move(name), start, is_quoted});
    first = end + 1;
  };
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (quotes.hold(c)) continue;
    if (c == '(' || c == '[') ++depth;
    if (c == ',' && depth == 0) take(at);
    if (c == ']' || c == ')') {
      if (depth > 0) {
        --depth;
      } else if (c == ')') {
        if (!arguments.list.empty() || !trim(text.substr(first, at - first)).empty()) take(at);
        *place = at + 1;
        return arguments;
      }
    }
  }
  throw TextFault{*place, "the bracket of " + std::string(quantity) + " is not closed"};
}

std::size_t Things::list_size(Thing::List list) const {
  if (list == Thing::List::Constraints) return system_.constraints.size();
  return list == Thing::List::Supports ? system_.supports.size() : system_.forces.size();
}

std::string Things::list_name(Thing::List list, std::size_t index) const {
  if (list == Thing::List::Constraints) return constraint_name(system_, index);
  if (list == Thing::List::Forces) return force_name(system_, index);
  const std::string& own = system_.supports[index].name;
  return own.empty() ? "support" + text(index) : own;
}

std::string Things::name(const Thing& thing) const {
  const std::string name = list_name(thing.list, thing.index);
  if (!thing.member) return name;
  const std::span<const std::size_t> left = numbers(thing);
  return name + "[" + text(left.empty() ? *thing.member : left[*thing.member]) + "]";
}

std::span<const std::size_t> Things::numbers(const Thing& thing) const {
  if (host_ == nullptr || thing.list != Thing::List::Constraints) return {};
  return host_->groups[thing.index].left;
}

/// Returns the place of the member with a number in names.
std::size_t Things::place_of(std::size_t number, const Thing& thing, const Argument& argument) const {
  const std::span<const std::size_t> left = numbers(thing);
  const std::size_t count = left.empty() ? num_members(thing) : host_->groups[thing.index].size;
  if (number >= count) argument.fail(name(thing) + " has " + text_of_count(count, "member") + ", counted from 0");
  if (left.empty()) return number;
  const auto place = std::ranges::lower_bound(left, number);
  if (place == left.end() || *place != number) argument.fail(name(thing) + "[" + text(number) + "] was removed");
  return static_cast<std::size_t>(place - left.begin());
}

void Things::require_forces(const Arguments& arguments) const {
  if (host_ == nullptr) return;
  throw TextFault{arguments.place, std::string(arguments.quantity) +
                                       " needs each of the forces, and a host gives their sum on each point alone"};
}

std::vector<bool> Things::find_absent(const Thing& of) const {
  std::vector<bool> absent(absent_.empty() ? 0 : num_members(of));
  for (const Thing& each : absent_) {
    if (each.list != of.list || each.index != of.index) continue;
    if (each.member)
      absent[*each.member] = true;
    else
      absent.assign(absent.size(), true);
  }
  return absent;
}

bool Things::is_absent(const Thing& thing) const {
  if (absent_.empty()) return false;
  const std::vector<bool> absent = find_absent(thing);
  return thing.member ? absent[*thing.member] : std::ranges::count(absent, false) == 0;
}

System Things::what_is_left() const {
  System left = system_;
  left.friction.clear();
  left.coordinates.clear();
  if (absent_.empty()) return left;
  const auto erase = [this](Thing::List list, auto* entries) {
    for (std::size_t index = 0; index < entries->size(); ++index) {
      std::visit(
          [&]<class Group>(Group& group) {
            if constexpr (requires { KindOf<Group>::members; }) {
              const std::vector<bool> absent = find_absent({list, index});
              std::vector<std::size_t> kept;
              for (std::size_t k = 0; k < absent.size(); ++k)
                if (!absent[k]) kept.push_back(k);
              if (kept.size() == absent.size()) return;
              if (kept.empty()) group = with_members(group, {0});  // a single one leaves numbers of the kind's law
              group = with_members(group, kept);
            }
          },
          (*entries)[index]);
    }
  };
  erase(Thing::List::Constraints, &left.constraints);
  erase(Thing::List::Forces, &left.forces);
  for (std::size_t s = 0; s < left.supports.size(); ++s) {
    std::size_t k = 0;
    const std::vector<bool> absent = find_absent({Thing::List::Supports, s});
    std::erase_if(left.supports[s].points, [&](Index) { return absent[k++]; });
  }
  return left;
}

std::size_t Things::num_members(const Thing& thing) const {
  if (thing.list == Thing::List::Supports) return system_.supports[thing.index].points.size();
  if (thing.list == Thing::List::Constraints) return shape_of(system_.constraints[thing.index]).members;
  return std::visit(
      []<class Group>(const Group& group) -> std::size_t {
        if constexpr (requires { KindOf<Group>::members; })
          return detail::num_members(group);
        else
          return 0;
      },
      system_.forces[thing.index]);
}

const Things::Names& Things::names() const {
  if (names_ != nullptr) return *names_;
  const auto found = std::make_shared<Names>();
  for (const Thing::List list : {Thing::List::Constraints, Thing::List::Supports, Thing::List::Forces})
    for (std::size_t k = 0; k < list_size(list); ++k) found->things[list_name(list, k)].push_back({list, k});
  for (std::size_t k = 0; k < system_.supports.size(); ++k)
    for (std::size_t m = 0; m < system_.supports[k].points.size(); ++m)
      found->supports.emplace(system_.supports[k].points[m], Thing{Thing::List::Supports, k, m});
  std::size_t row = 0;
  for (const Constraint& constraint : system_.constraints) {
    found->first_rows.push_back(row);
    const GroupShape shape = shape_of(constraint);
    row += shape.members * shape.rows_per_member;
  }
  return *(names_ = found);
}

std::vector<Thing> Things::find_all(const std::string& name, std::initializer_list<Thing::List> lists) const {
  std::vector<Thing> found;
  if (const auto all = names().things.find(name); all != names().things.end())
    for (const Thing::List list : lists)
      std::ranges::copy_if(all->second, std::back_inserter(found),
                           [&](const Thing& each) { return each.list == list; });
  return found;
}

Thing Things::find(const Argument& argument, std::initializer_list<Thing::List> lists) const {
  const auto find_name = [&](const std::string& name) -> std::optional<Thing> {
    const std::vector<Thing> found = find_all(name, lists);
    if (found.size() > 1)
      argument.fail("'" + name + "' is the name of " + place_in_system(found[0]) + " and of " +
                    place_in_system(found[1]) + "; give one of them another");
    return found.empty() ? std::nullopt : std::optional(found[0]);
  };
  if (const auto found = find_name(argument.text)) return *found;
  std::string name = argument.text;
  if (const std::size_t bracket = name.rfind('['); bracket != std::string::npos && name.back() == ']') {
    const std::string inside = name.substr(bracket + 1, name.size() - bracket - 2);
    const auto member = read_number<std::size_t>(inside);
    name.resize(bracket);
    if (std::optional<Thing> found = find_name(name)) {
      if (!member) argument.fail("'" + inside + "' is no number of a member; those of " + name + " are counted from 0");
      found->member = place_of(*member, *found, argument);
      return *found;
    }
  }
  if (host_ != nullptr && std::ranges::count(host_->removed, name) > 0) argument.fail("'" + name + "' was removed");
  std::vector<std::string> known;
  std::string words;
  for (const Thing::List list : lists) {
    words += (words.empty() ? "" : " or ") + std::string(word_for(list));
    for (std::size_t k = 0; k < list_size(list); ++k) known.push_back(list_name(list, k));
  }
  std::string have;
  constexpr std::size_t most_named = 8;
  for (std::size_t k = 0; k < std::min(known.size(), most_named); ++k) have += (k > 0 ? ", " : "") + known[k];
  argument.fail(
      "no " + words + " are named '" + name + "'" + suggest(name, known) +
      (known.empty() ? "; there are none" : "; there are " + have + (known.size() > most_named ? ", …" : "")));
}

std::vector<Index> Things::points(const Argument& argument) const {
  const auto check = [&](Index point) {
    if (point < 0 || static_cast<std::size_t>(point) >= system_.num_points())
      argument.fail("there is no point " + text(point) + "; they are 0 to " + text(system_.num_points() - 1));
  };
  const std::string_view plain = argument.is_name ? std::string_view() : argument.text;
  if (const auto number = read_number<Index>(plain)) return check(*number), std::vector{*number};
  if (auto list = read_list<Index>(plain)) {
    for (const Index point : *list) {
      check(point);
      if (std::ranges::count(*list, point) > 1) argument.fail("it names point " + text(point) + " twice");
    }
    return *list;
  }
  if (plain == "all") {
    std::vector<Index> all(system_.num_points());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Index>(i);
    return all;
  }
  if (argument.text.empty()) argument.fail("points are missing: a number, [0, 4, 7], a name of supports, or all");
  const Thing thing = find(argument, {Thing::List::Supports});
  const std::vector<Index>& points = system_.supports[thing.index].points;
  return thing.member ? std::vector{points[*thing.member]} : points;
}

Index Things::point(const Argument& argument) const {
  const std::vector<Index> found = points(argument);
  if (found.size() != 1) argument.fail("one point is wanted, these are " + text(found.size()));
  return found[0];
}

std::optional<Vec3> Things::vector(const Argument& argument) const {
  const auto list = read_list<double>(argument.text);
  if (!list) return {};
  if (list->size() != 3) argument.fail("a vector has three numbers, [x, y, z]");
  return Vec3{(*list)[0], (*list)[1], (*list)[2]};
}

Vec3 Things::axis(const Argument& argument) const {
  if (argument.text == "x") return {1.0, 0.0, 0.0};
  if (argument.text == "y") return {0.0, 1.0, 0.0};
  if (argument.text == "z") return {0.0, 0.0, 1.0};
  const std::optional<Vec3> given = vector(argument);
  if (!given) argument.fail("an axis is x, y, z or [a, b, c]");
  if (!(norm(*given) > 0.0)) argument.fail("the axis is zero");
  return (1.0 / norm(*given)) * *given;
}

std::string Things::name_point(Index point) const {
  const auto found = names().supports.find(point);
  if (found == names().supports.end()) return "point " + text(point);
  const Thing &member = found->second, whole{member.list, member.index};
  return name(num_members(whole) == 1 ? whole : member);
}

}  // namespace tanor::detail
