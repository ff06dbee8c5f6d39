#include "host/inventory.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "system/value_checks.hpp"

namespace tanor::detail {

namespace {

/// The first character of a group's name in a part: "\x1f3" is the host's group 3.
constexpr char mark = '\x1f';

/// Returns the Parameter of a kind that has one, else null.
template <class Kind>
auto* parameter_of(Kind& group) {
  if constexpr (requires { KindOf<std::remove_const_t<Kind>>::parameter; })
    return &(group.*KindOf<std::remove_const_t<Kind>>::parameter);
  else
    return static_cast<std::conditional_t<std::is_const_v<Kind>, const Parameter, Parameter>*>(nullptr);
}

Parameter* parameter_of(Constraint* constraint) {
  return std::visit([](auto& group) { return parameter_of(group); }, *constraint);
}

/// Returns the values with these numbers, or all values if members share one.
template <class Value>
std::vector<Value> pick_values(const std::vector<Value>& values, std::size_t num_members,
                               const std::vector<Index>& numbers) {
  if (values.size() != num_members) return values;
  std::vector<Value> result;
  for (const Index k : numbers) result.push_back(values[static_cast<std::size_t>(k)]);
  return result;
}

}  // namespace

// ---- what there is ----

ConstraintId Inventory::add(Constraint constraint, std::vector<std::array<int, 3>> images) {
  const ConstraintId first = next_id();
  const std::size_t count = shape_of(constraint).members;
  std::string name = std::visit([](const auto& group) { return group.name; }, constraint);
  if (!name.empty()) names_.insert(name);
  if (name.empty()) name = std::string(kind_name(constraint)) + text(groups_.size());
  if (Parameter* const parameter = parameter_of(&constraint); parameter != nullptr && parameter->constants.size() == 1)
    parameter->constants.resize(count, parameter->constants[0]);
  Constraint shell = constraint;
  std::visit(
      []<class Kind>(Kind& group) {
        (group.*KindOf<Kind>::members).clear();
        if constexpr (std::is_same_v<Kind, Rods>) group.offsets.clear();
        if (Parameter* const own = parameter_of(group)) *own = {};
      },
      shell);
  has_images_ = has_images_ || !images.empty();
  group_of_.resize(group_of_.size() + count, static_cast<Index>(groups_.size()));
  groups_.push_back({std::move(constraint), std::move(shell), first, count, std::move(name), std::move(images)});
  number_rows(first);
  return first;
}

void Inventory::remove(std::span<const ConstraintId> ids) {
  std::vector<ConstraintId> ascending(ids.begin(), ids.end());
  std::ranges::sort(ascending);
  Index rows = 0;
  for (std::size_t k = 0; k < ascending.size(); ++k) {
    const ConstraintId id = ascending[k];
    Group& group = groups_[group_number(id)];
    group_of_[static_cast<std::size_t>(id)] = ~group_of_[static_cast<std::size_t>(id)];
    rows += static_cast<Index>(shape_of(group.shell).rows_per_member);
    const ConstraintId end = k + 1 < ascending.size() ? ascending[k + 1] : next_id();
    for (auto later = static_cast<std::size_t>(id) + 1; later <= static_cast<std::size_t>(end); ++later)
      first_row_[later] -= rows;
    if (--group.num_left > 0) continue;
    group.all = group.shell;
    group.images.clear();
    group.driven.clear();
    names_.erase(group.name);
  }
}

void Inventory::require(ConstraintId id) const {
  if (has(id)) return;
  throw InputError(
      "", "there is no constraint with the id " + text(id) + (id >= 0 && id < next_id() ? "; it was removed" : ""));
}

std::span<const Index> Inventory::points(ConstraintId id) const {
  const Group& group = group_of(id);
  const auto number = static_cast<std::size_t>(id - group.first);
  return std::visit([&](const auto& kind) { return member_points(kind, number); }, group.all);
}

// ---- rows ----

void Inventory::number_rows(ConstraintId from) {
  first_row_.resize(group_of_.size() + 1);
  Index row = first_row_[static_cast<std::size_t>(from)];
  Index last_group = -1, rows = 0;
  for (auto id = static_cast<std::size_t>(from); id < group_of_.size(); ++id) {
    first_row_[id] = row;
    const Index group = group_of_[id];
    if (group < 0) continue;
    if (group != std::exchange(last_group, group))
      rows = static_cast<Index>(shape_of(groups_[static_cast<std::size_t>(group)].shell).rows_per_member);
    row += rows;
  }
  first_row_.back() = row;
}

ConstraintId Inventory::id_of_row(std::size_t row) const {
  if (row >= num_rows()) throw InputError("", "there is no row " + text(row));
  const auto next = std::upper_bound(first_row_.begin(), first_row_.end(), static_cast<Index>(row));
  return static_cast<ConstraintId>(next - first_row_.begin()) - 1;
}

std::string Inventory::member_name(ConstraintId id) const {
  return group_of(id).name + "[" + text(member_number(id)) + "]";
}

std::string Inventory::row_name(std::size_t row) const {
  const ConstraintId id = id_of_row(row);
  const std::string name = member_name(id);
  return num_rows(id) == 1 ? name : name + "." + text(row - first_row(id));
}

std::string Inventory::part_name(std::size_t group) {
  return mark + std::to_string(group);
}

std::string Inventory::with_host_names(std::span<const ConstraintId> members, const std::string& text) const {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find(mark, at);
    result += text.substr(at, begin - at);
    if (begin == std::string::npos) break;
    const std::size_t open = text.find('[', begin), close = text.find(']', begin);
    at = text.find_first_not_of("0123456789", begin + 1);
    const auto group = std::stoul(text.substr(begin + 1));
    const auto is_there = [&](ConstraintId id) { return group_number(id) == group; };
    const auto first = std::ranges::find_if(members, is_there);
    if (open != at || first == members.end()) {
      result += group_name(group);
      continue;
    }
    result += member_name(*(first + static_cast<std::ptrdiff_t>(std::stoul(text.substr(open + 1)))));
    at = close + 1;
  }
  return result;
}

// ---- lengths ----

void Inventory::check_length(ConstraintId id, double length, double rate) const {
  require(id);
  const std::string where = row_name(first_row(id));
  if (!is_in_range(rate)) throw InputError(where, "the rate " + text(rate) + " is not finite");
  std::visit(
      [&]<class Kind>(const Kind&) {
        if constexpr (requires { KindOf<Kind>::parameter; }) {
          const auto check = [&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.value), Parameter Kind::*>) {
              if (field.value == KindOf<Kind>::parameter) check_number(length, field.data.range, where, field.name);
            }
          };
          std::apply([&](const auto&... field) { (check(field), ...); }, KindOf<Kind>::fields);
          if constexpr (requires { KindOf<Kind>::parameter_range; })
            check_number(length, KindOf<Kind>::parameter_range, where, "number");
        } else {
          throw InputError(where, "a constraint of the kind " + std::string(KindOf<Kind>::name) + " has no length");
        }
      },
      group_of(id).shell);
}

bool Inventory::set_length(ConstraintId id, double length, double rate) {
  Group& group = groups_[group_number(id)];
  const auto number = static_cast<std::size_t>(id - group.first);
  if (!group.driven.empty() && group.driven[number] != nullptr) {
    *group.driven[number] = {length, rate};
    return true;
  }
  Parameter& parameter = *parameter_of(&group.all);
  if (rate == 0.0 && parameter.functions.empty()) {
    parameter.constants[number] = length;
    return false;
  }
  drive(&group, number);
  *group.driven[number] = {length, rate};
  return false;
}

/// Makes the length a function of time that returns what `set_length` has set last.
void Inventory::drive(Group* group, std::size_t number) {
  const std::size_t count = shape_of(group->all).members;
  group->driven.resize(count);
  group->driven[number] = std::make_shared<DrivenLength>();
  Parameter& parameter = *parameter_of(&group->all);
  if (parameter.functions.size() == 1) parameter.functions.resize(count, parameter.functions[0]);
  for (const double constant : std::exchange(parameter.constants, {})) parameter.functions.emplace_back(constant);
  const auto now = [driven = std::shared_ptr<const DrivenLength>(group->driven[number])](const Jet<2>&) {
    Jet<2> result(driven->length);
    result.c[1] = driven->rate;
    return result;
  };
  parameter.functions[number] = ScalarFunction::custom(std::function<Jet<2>(const Jet<2>&)>(now));
}

bool Inventory::drives_some(const Group& group, const std::vector<Index>& numbers) {
  const auto is_driven = [&](Index k) { return group.driven[static_cast<std::size_t>(k)] != nullptr; };
  return !group.driven.empty() && std::ranges::any_of(numbers, is_driven);
}

/// In memory, rods whose lengths move stand behind those whose lengths do not. If one rod is driven, all of them are
/// put among the former, so that it does not matter to which groups they belong.
void Inventory::let_move(Constraint& constraint) {
  if (Rods* const rods = std::get_if<Rods>(&constraint)) {
    for (const double constant : std::exchange(rods->length.constants, {}))
      rods->length.functions.emplace_back(constant);
  }
}

// ---- members together ----

std::vector<std::array<int, 3>> Inventory::take_images(std::span<const ConstraintId> ids) const {
  std::vector<std::array<int, 3>> result;
  if (!has_images_) return result;
  for_each_run(ids, [&](const Group& group, const std::vector<Index>& numbers) {
    const std::size_t rows = shape_of(group.shell).rows_per_member;
    for (const Index k : numbers)
      result.insert(result.end(), rows,
                    group.images.empty() ? std::array<int, 3>{} : group.images[static_cast<std::size_t>(k)]);
  });
  return result;
}

Constraint Inventory::pick(const Group& from, const std::vector<Index>& numbers) {
  Constraint result = from.shell;
  std::visit(
      [&]<class Kind>(Kind& group) {
        const Kind& all = std::get<Kind>(from.all);
        const std::size_t count = num_members(all);
        group.*KindOf<Kind>::members = pick_values(list_of(all), count, numbers);
        if constexpr (std::is_same_v<Kind, Rods>) group.offsets = pick_values(all.offsets, count, numbers);
        Parameter* const own = parameter_of(group);
        if (own == nullptr) return;
        own->constants = pick_values(parameter_of(all)->constants, count, numbers);
        own->functions = pick_values(parameter_of(all)->functions, count, numbers);
        const auto is_constant = [](const ScalarFunction& function) { return function.is_constant(); };
        if (own->functions.empty() || !std::ranges::all_of(own->functions, is_constant)) return;
        for (const ScalarFunction& constant : std::exchange(own->functions, {}))
          own->constants.push_back(constant(0.0).value());
      },
      result);
  return result;
}

}  // namespace tanor::detail
