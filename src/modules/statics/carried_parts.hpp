#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <tanor/system.hpp>

#include "base/numbers.hpp"
#include "base/vec3.hpp"
#include "system/members.hpp"
#include "system/operations.hpp"

namespace tanor::detail {

/// Lists the fields of a part with a function of time that fails a test.
template <class Group, class Test>
std::vector<std::string> list_failing_fields(const Group& group, const Test& passes) {
  std::vector<std::string> names;
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    const Value& value = group.*field.value;
    bool pass = true;
    if constexpr (std::is_same_v<Value, VectorFunction>) pass = std::ranges::all_of(value.components, passes);
    if constexpr (std::is_same_v<Value, Parameter>) pass = std::ranges::all_of(value.functions, passes);
    if (!pass) names.emplace_back(field.name);
  });
  return names;
}
template <class Test>
std::vector<std::string> list_failing_fields(const Support& support, const Test& passes) {
  if (std::ranges::all_of(support.displacement.components, passes)) return {};
  return {"motion"};
}

/// Returns "normal, offset", the fields of a part that depend on time, or "formula".
template <class Part>
std::string name_moving_fields(const Part& part) {
  std::vector<std::string> names = list_failing_fields(part, &ScalarFunction::is_constant);
  if constexpr (requires { part.kernel.depends_on_time; }) {
    if (part.kernel.depends_on_time) names.emplace_back("formula");
  }
  std::string result;
  for (const std::string& name : names) result += (result.empty() ? "" : ", ") + name;
  return result;
}

/// Calls visit(where, name, part) for each support, each group of constraints and each force of a system.
template <class Visit>
void for_each_part(const System& system, const Visit& visit) {
  for (std::size_t k = 0; k < system.supports.size(); ++k) {
    const Support& support = system.supports[k];
    const std::string number = std::to_string(k);
    visit("/supports/" + number, support.name.empty() ? "support" + number : support.name, support);
  }
  const auto visit_list = [&](const char* list, const auto& entries, const auto& name_of) {
    for (std::size_t k = 0; k < entries.size(); ++k)
      std::visit([&](const auto& each) { visit(list + std::to_string(k), name_of(system, k), each); }, entries[k]);
  };
  visit_list("/constraints/", system.constraints, constraint_name);
  visit_list("/forces/", system.forces, force_name);
}

/// Returns the places of all points at the start, each coordinate moved by at most `by`, m, so that nothing stands
/// still by accident. Each number is another configuration. Triples of sines at one step lie in a plane, so that even
/// and odd numbers have steps of their own.
inline std::vector<Vec3> disturb(const System& system, std::size_t number, double by) {
  const double step = number % 2 == 0 ? 2.399963 : 1.1;
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < system.num_points(); ++i) {
    const std::size_t k = number * system.positions.size() + 3 * i;
    const Vec3 aside{irregular(k, step), irregular(k + 1, step), irregular(k + 2, step)};
    places.push_back(load(system.positions.data(), i) + by * aside);
  }
  return places;
}

/// Puts the supports to where they are at t.
inline void put_supports(const System& system, double t, std::vector<Vec3>* places) {
  for (const Support& support : system.supports) {
    const auto now = support.displacement(t);
    for (const Index point : support.points)
      (*places)[static_cast<std::size_t>(point)] =
          load(system.positions.data(), point) + Vec3{now[0].value(), now[1].value(), now[2].value()};
  }
}

/// Evaluates an expression at its variables.
template <class Number>
std::vector<Number> evaluate(const Expression& expression, const std::vector<Number>& variables) {
  std::vector<Number> values, results;
  perform_all(
      expression, [&](std::size_t i) { return variables[i]; }, &values);
  for (const int result : expression.results) results.push_back(values[static_cast<std::size_t>(result)]);
  return results;
}

/// Lists the numbers that tell whether the parts of a system stand still in a frame: they are constant exactly if a
/// part is the same at all times for what the frame carries along. A view says how they are seen, at all times or at
/// one instant with their rates:
///
///   view(function)             a function of time, as View::Number
///   view.carry(point, start)   the place of a point that the frame carries along, from one of two starts, 0 or 1
///   view.turn_back(a)          a vector as it is seen in the frame
///   view.time()
///
/// Kernels must have expressions.
template <class View>
class CarriedParts {
 public:
  using Number = typename View::Number;

  CarriedParts(const System& system, const View& view) : system_(system), view_(view) {}

  /// Calls add(numbers) for each member of a part.
  template <class Add>
  void list(const Support& support, const Add& add) const {
    const TripleOf<Number> moved = view_(support.displacement);
    for (const Index point : support.points) {
      const double* const start = system_.positions.data() + 3 * point;
      add_vector(triple_of<Number>(Vector3{start[0], start[1], start[2]}) + moved - view_.carry(point, 0), add);
    }
  }

  template <class Group, class Add>
  requires requires { KindOf<Group>::rows; }
  void list(const Group& group, const Add& add) const {
    const typename KindOf<Group>::template Definition<Number> now(group, view_);
    const auto carry = [this](Index point) { return view_.carry(point, 0); };
    for (std::size_t k = 0; k < num_members(group); ++k) {
      Number number;
      if constexpr (requires { KindOf<Group>::parameter; }) number = number_of(group.*KindOf<Group>::parameter, k);
      add(std::span<const Number>(now.xi(MemberPlaces(member_points(group, k), carry), number, k)));
    }
  }
  /// The two unit vectors of a line are its frame's up to a turn about it; the distance from it is not.
  template <class Add>
  void list(const Lines& lines, const Add& add) const {
    const TripleOf<Number> origin = view_(lines.origin), d = view_(lines.direction);
    for (const Index point : lines.points) {
      const TripleOf<Number> a = view_.carry(point, 0) - origin;
      const Number along = dot(a, d);
      add(std::span<const Number>({dot(a, a) - along * along / dot(d, d)}));
    }
  }
  template <class Add>
  void list(const UserConstraints& group, const Add& add) const {
    for (const std::vector<Index>& tuple : group.tuples)
      add(std::span<const Number>(evaluate(*group.kernel.expression, tuple, {}, 0)));
  }

  /// Forces between points follow them.
  template <class Force, class Add>
  void list(const Force&, const Add&) const {}
  template <class Add>
  void list(const Gravity& gravity, const Add& add) const {
    add_vector(view_.turn_back(triple_of<Number>(gravity.acceleration)), add);
  }
  template <class Add>
  void list(const ConstantForce& given, const Add& add) const {
    add_vector(view_.turn_back(view_(given.force)), add);
  }
  template <class Add>
  void list(const FormulaForce& formula, const Add& add) const {
    const auto list_tuple = [&](const auto& tuple) {
      std::vector<double> v(3 * tuple.size());  // of no account where it is not read
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = irregular(i);
      const std::vector<Number> f = evaluate(*formula.kernel.expression, tuple, v, 0);
      for (std::size_t i = 0; i < f.size(); i += 3) add_vector(view_.turn_back({f[i], f[i + 1], f[i + 2]}), add);
    };
    for (const Index point : formula.points) list_tuple(std::array{point});
    for (const auto& tuple : formula.tuples) list_tuple(tuple);
  }
  /// An energy may change by the same amount everywhere.
  template <class Add>
  void list(const Potential& potential, const Add& add) const {
    for (std::size_t k = 0; k < potential.points.size(); ++k) {
      std::vector<double> constants;
      for (const std::vector<double>& each : potential.constants) constants.push_back(each[each.size() == 1 ? 0 : k]);
      const auto energy = [&](std::size_t start) {
        return evaluate(*potential.kernel.expression, potential.points[k], constants, start)[0];
      };
      add(std::span<const Number>({energy(0) - energy(1)}));
    }
  }

 private:
  template <class Add>
  static void add_vector(const TripleOf<Number>& a, const Add& add) {
    add(std::span<const Number>({a.x, a.y, a.z}));
  }
  Number number_of(const Parameter& parameter, std::size_t k) const {
    if (parameter.functions.empty()) return 0.0;
    return view_(parameter.functions[parameter.functions.size() == 1 ? 0 : k]);
  }
  /// Returns the results of an expression of the coordinates of points, more constants, and time.
  template <class Tuple>
  std::vector<Number> evaluate(const Expression& expression, const Tuple& tuple, const std::vector<double>& more,
                               std::size_t start) const {
    std::vector<Number> variables;
    for (const Index point : tuple) {
      const TripleOf<Number> r = view_.carry(point, start);
      variables.insert(variables.end(), {r.x, r.y, r.z});
    }
    variables.insert(variables.end(), more.begin(), more.end());
    variables.push_back(view_.time());
    return detail::evaluate(expression, variables);
  }

  const System& system_;
  const View& view_;
};

}  // namespace tanor::detail
