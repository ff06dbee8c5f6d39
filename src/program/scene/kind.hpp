#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "scene/along.hpp"
#include "scene/entries.hpp"

namespace tanor::scene {

/// One kind of constraint, force or generator: its name, the keys beside `kind`, and the function that reads it.
template <class Entry>
struct Kind {
  std::string_view name;
  std::vector<std::string_view> keys;
  Entry (*read)(const Cursor& entry, const Context& context);
  bool has_several_rows = false;  ///< each member has several equations, and no side
};

/// Reads {"kind": …}; `planned` are kinds that this version does not support yet.
template <class Entry>
Entry read_kind(const Cursor& entry, const std::vector<Kind<Entry>>& kinds,
                const std::vector<std::string_view>& planned, const Context& context) {
  std::vector<std::string_view> names;
  for (const Kind<Entry>& kind : kinds) names.push_back(kind.name);
  const Kind<Entry>& kind = kinds[entry["kind"].choice_index(names, planned)];

  if (kind.has_several_rows && entry["side"])
    entry["side"].complain(fmt::format(
        "found with a {}, whose members have two rows; a constraint to one side has one row a member", kind.name));
  std::vector<std::string_view> keys = {"kind"};
  keys.insert(keys.end(), kind.keys.begin(), kind.keys.end());
  return kind.read(entry.object(keys), context);
}

// ---- kinds whose fields are plain data ----

/// Parts of a Group that its fields do not describe. `keys` are all keys, if there are more than the fields' names.
/// read(entry, context, &group) reads the rest after the fields, and check_law(entry, law) refuses what an energy's law
/// does not read beside the fields.
template <class Group>
struct Extra {};

/// Reads the names of constraints: "wire" or ["ball", "hoop"].
std::vector<std::string> read_guides(const Cursor& at);

inline void read_members(const Cursor& list, const Context& context, std::vector<std::vector<Index>>* tuples) {
  for (const Cursor tuple : list.list("a list of lists of points")) {
    std::vector<Index>& points = tuples->emplace_back();
    for (const Cursor point : tuple.list("a list of points")) points.push_back(context.point(point));
  }
}
inline void read_members(const Cursor& list, const Context& context, std::vector<Index>* points) {
  *points = context.points(list);
}
template <std::size_t N>
void read_members(const Cursor& list, const Context& context, std::vector<std::array<Index, N>>* tuples) {
  *tuples = context.tuples<N>(list);
}

/// True for energies whose members may be given by rods in sequence, along which they lie.
template <class Group>
concept MayLieAlong = HasEnergy<Group> && requires(const Cursor& along, const Context& context, Group group) {
  read_along(along, context, &(group.*KindOf<Group>::members));
};

/// Reads the members one by one, or "along" for those of rods in sequence.
template <class Group>
void read_members_of(const Cursor& entry, const Context& context, Group* group) {
  auto* const members = &(group->*KindOf<Group>::members);
  const Cursor list = entry[list_name<Group>()];
  if constexpr (MayLieAlong<Group>) {
    const Cursor along = entry["along"];
    if (along && list) along.complain(fmt::format(R"(found beside "{}"; one of both is right)", list_name<Group>()));
    if (along) return read_along(along, context, members);
  }
  if (list || !requires { Extra<Group>::members_are_optional; }) read_members(list, context, members);
}

/// Refuses a key that the law does not read, because it would have no effect.
inline void refuse_key_of_other_laws(const Cursor& entry, std::string_view key) {
  if (entry[key])
    entry[key].complain(fmt::format("found beside the law \"{}\", which does not read it", entry["law"].string()));
}

/// Reads the law of an energy, on which depends what else it has.
template <HasEnergy Group>
void read_law(const Cursor& entry, Group* group) {
  group->law = entry["law"].choice<decltype(group->law)>();
  const auto numbers = KindOf<Group>::law_numbers(*group);
  for_each_field<Group>([&](const auto& field) {
    const auto is_it = [&](const LawNumber& number) { return std::string_view(number.name) == field.name; };
    if (std::ranges::none_of(numbers, is_it)) refuse_key_of_other_laws(entry, field.name);
  });
  if constexpr (requires { Extra<Group>::check_law(entry, group->law); }) Extra<Group>::check_law(entry, group->law);
}

/// Reads a number. It must be in the given range if this has a text for the reader.
inline double read_number(const Cursor& cursor, const ValueRange& range) {
  if (range.wanted && !(cursor.is_number() && range.complaint(cursor.number()) == nullptr)) cursor.fail(range.wanted);
  return cursor.number();
}

/// Returns true if a number of a group may be "initial". In energies the law decides which ones may.
template <class Group>
bool may_be_initial([[maybe_unused]] const Group& group, [[maybe_unused]] std::string_view field) {
  if constexpr (HasEnergy<Group>) {
    for (const LawNumber& number : KindOf<Group>::law_numbers(group)) {
      if (number.name == field) return number.may_be_initial;
    }
  }
  return true;
}

/// Reads one field of a group whose members are known; an absent field keeps its default value.
template <class Group, class Value>
void read_field(const Cursor& cursor, const Context& context, const FieldOf<Group, Value>& field, Group* group) {
  const FieldData& data = field.data;
  Value& value = group->*field.value;
  if (!cursor && !data.is_required) return;
  if constexpr (std::is_same_v<Value, Parameter>) {
    const std::size_t num_members = (group->*KindOf<Group>::members).size();
    if (!may_be_initial(*group, field.name))
      value.constants = context.numbers(cursor, num_members);
    else
      value =
          data.is_constant ? context.constant_parameter(cursor, num_members) : context.parameter(cursor, num_members);
  } else if constexpr (std::is_same_v<Value, VectorFunction>) {
    value = context.vector_function(cursor);
  } else if constexpr (std::is_same_v<Value, Vector3>) {
    value = cursor.vector3();
  } else if constexpr (std::is_same_v<Value, std::array<Vector3, 2>>) {
    const std::vector<Vector3> vectors = context.vectors(cursor);
    if (vectors.size() != value.size()) cursor.fail("2 vectors [x, y, z]");
    std::ranges::copy(vectors, value.begin());
  } else if constexpr (std::is_same_v<Value, Index>) {
    value = context.point(cursor);
  } else if constexpr (std::is_same_v<Value, std::vector<Vector3>>) {
    value = context.vectors(cursor);
    const std::size_t num_members = (group->*KindOf<Group>::members).size();
    std::string_view one = list_name<Group>();
    one.remove_suffix(1);
    if (value.size() != num_members) cursor.fail(fmt::format("{} vectors, one a {}", num_members, one));
  } else if constexpr (std::is_same_v<Value, std::vector<double>>) {
    if (data.is_each) return void(value = context.numbers(cursor, (group->*KindOf<Group>::members).size()));
    for (const Cursor number : cursor.list("a list of numbers")) value.push_back(number.number());
  } else if constexpr (std::is_same_v<Value, std::optional<OneSide>>) {
    value = cursor.choice<OneSide>();
  } else {
    static_assert(std::is_same_v<Value, double> || std::is_same_v<Value, std::optional<double>>);
    value = read_number(cursor, data.range);
  }
}

/// True for constraints with several equations a member, which have no side.
template <class Group>
constexpr bool has_several_rows = false;
template <class Group>
requires requires {
  KindOf<Group>::rows;
}
constexpr bool has_several_rows<Group> = KindOf<Group>::rows > 1;

template <class Group>
std::vector<std::string_view> list_keys() {
  if constexpr (requires { Extra<Group>::keys; }) return {Extra<Group>::keys.begin(), Extra<Group>::keys.end()};
  std::vector<std::string_view> keys = {"name"};
  if constexpr (requires(Group group) { group.at; }) keys.emplace_back("at");
  if constexpr (requires { KindOf<Group>::members; }) keys.emplace_back(list_name<Group>());
  if constexpr (MayLieAlong<Group>) keys.emplace_back("along");
  if constexpr (HasEnergy<Group>) keys.emplace_back("law");
  for_each_field<Group>([&](const auto& field) { keys.emplace_back(field.name); });
  return keys;
}

template <class Group>
Group read_group(const Cursor& entry, const Context& context) {
  Group group;
  group.name = entry["name"].string("");
  if constexpr (requires { Extra<Group>::read_alone; }) {
    Extra<Group>::read(entry, context, &group);
  } else {
    if constexpr (HasEnergy<Group>) read_law(entry, &group);
    if constexpr (requires { group.at; }) group.at = read_guides(entry["at"]);
    if constexpr (requires { KindOf<Group>::members; }) read_members_of(entry, context, &group);
    for_each_field<Group>([&](const auto& field) { read_field(entry[field.name], context, field, &group); });
    if constexpr (requires { Extra<Group>::read(entry, context, &group); }) Extra<Group>::read(entry, context, &group);
  }
  return group;
}

/// All kinds in a list of <tanor/kinds.hpp> that scene files can contain.
template <class Entry>
struct KindsOf;
template <class... Groups>
struct KindsOf<std::variant<Groups...>> {
  using Entry = std::variant<Groups...>;

  static std::vector<Kind<Entry>> list() {
    std::vector<Kind<Entry>> kinds;
    (append<Groups>(&kinds), ...);
    return kinds;
  }

 private:
  template <class Group>
  static void append(std::vector<Kind<Entry>>* kinds) {
    if constexpr (!requires { Extra<Group>::is_left_out; }) {
      const auto read = [](const Cursor& entry, const Context& context) -> Entry {
        return read_group<Group>(entry, context);
      };
      kinds->push_back({KindOf<Group>::name, list_keys<Group>(), read, has_several_rows<Group>});
    }
  }
};

template <class Entry>
std::vector<Entry> read_entries(const Cursor& list, std::string_view wanted, const Context& context) {
  static const std::vector<Kind<Entry>> kinds = KindsOf<Entry>::list();
  std::vector<Entry> entries;
  for (const Cursor entry : list.optional_list(wanted)) entries.push_back(read_kind(entry, kinds, {}, context));
  return entries;
}

}  // namespace tanor::scene
