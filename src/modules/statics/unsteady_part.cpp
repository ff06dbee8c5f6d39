#include "statics/unsteady_part.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/numbers.hpp"
#include "statics/moving_fields.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

using Sum = ExponentialPolynomial;

Sum since(double t) {
  return Sum::time() + t;
}

/// Evaluates functions of time at all times since t.
struct WholeClock {
  double t;

  Sum operator()(const ScalarFunction& function) const {
    if (function.is_constant()) return function(t).value();
    const std::shared_ptr<const Expression> expression = function.expression();
    return expression ? evaluate(*expression, std::array{since(t)})[0] : Sum::unknown();
  }
  TripleOf<Sum> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

bool is_constant(const TripleOf<Sum>& a) {
  return a.x.is_constant() && a.y.is_constant() && a.z.is_constant();
}

bool is_known(const ScalarFunction& function) {
  return WholeClock{0.0}(function).is_known();
}

/// Returns the first field of a group with an unknown function of time; empty if there is none.
template <class Group>
std::string name_unknown_field(const Group& group) {
  std::string name;
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    const Value& value = group.*field.value;
    bool known = true;
    if constexpr (std::is_same_v<Value, VectorFunction>) known = std::ranges::all_of(value.components, is_known);
    if constexpr (std::is_same_v<Value, Parameter>) known = std::ranges::all_of(value.functions, is_known);
    if (!known && name.empty()) name = field.name;
  });
  return name;
}

std::string name_unknown_field(const Support& support) {
  return std::ranges::all_of(support.displacement.components, is_known) ? "" : "motion";
}

/// The test of one system in one frame.
class SteadinessTest {
 public:
  SteadinessTest(const System& system, const SteadyFrame& frame, double t, double scene_size)
      : system_(system), frame_(frame), clock_{t} {
    constexpr double part = 0.1;  // disturbs configurations, so that nothing stands still by accident
    const std::size_t size = system.positions.size();
    const auto place = [&](std::size_t i, std::size_t first) {
      const Vec3 aside{irregular(first), irregular(first + 1), irregular(first + 2)};
      return load(system.positions.data(), i) + part * scene_size * aside;
    };
    for (std::size_t i = 0; i < system.num_points(); ++i) {
      places_.push_back(place(i, 3 * i));
      beside_.push_back(place(i, size + 3 * i));
    }
    for (const Support& support : system.supports) {
      const auto now = support.displacement(t);
      for (const Index point : support.points) {
        const auto i = static_cast<std::size_t>(point);
        places_[i] = beside_[i] =
            load(system.positions.data(), i) + Vec3{now[0].value(), now[1].value(), now[2].value()};
      }
    }
  }

  std::optional<UnsteadyPart> find() const {
    std::optional<UnsteadyPart> result;
    for_each_part(system_, [&](const std::string& where, const std::string& name, const auto& part) {
      if (result) return;
      if constexpr (requires { holds(part); }) {
        if (!holds(part)) result = UnsteadyPart{where, leaves(name)};
      } else if (const std::string complaint = complain(part); !complaint.empty()) {
        result = UnsteadyPart{where, name + complaint};
      }
    });
    return result;
  }

 private:
  using Places = std::vector<Vec3>;

  std::string leaves(const std::string& name) const {
    return "nothing rests: no frame that turns with a constant spin or accelerates evenly carries along all that "
           "supports, constraints and forces prescribe; " +
           name + " leaves " + (frame_.moves() ? "the frame " + frame_.describe() : "the frame at rest");
  }
  template <class Group>
  bool may_change(const Group& group) const {
    return frame_.moves() || !name_moving_fields(group).empty();
  }

  bool holds(const Support& support) const {
    const TripleOf<Sum> moved = clock_(support.displacement);
    return std::ranges::all_of(support.points, [&](Index point) {
      const auto i = static_cast<std::size_t>(point);
      return is_constant(triple_of<Sum>(vector_at(i)) + moved - frame_.carry(places_[i]));
    });
  }
  Vector3 vector_at(std::size_t i) const {
    return {system_.positions[3 * i], system_.positions[3 * i + 1], system_.positions[3 * i + 2]};
  }

  // ---- constraints ----

  template <class Group>
  requires requires { KindOf<Group>::rows; }
  bool holds(const Group& group) const {
    if (!may_change(group)) return true;
    const typename KindOf<Group>::template Definition<Sum> now(group, clock_);
    const auto carry = [this](Index point) { return frame_.carry(places_[static_cast<std::size_t>(point)]); };
    for (std::size_t k = 0; k < num_members(group); ++k) {
      Sum number;
      if constexpr (requires { KindOf<Group>::parameter; }) number = number_of(group.*KindOf<Group>::parameter, k);
      const auto xi = now.xi(MemberPlaces(member_points(group, k), carry), number, k);
      if (!std::ranges::all_of(xi, &Sum::is_constant)) return false;
    }
    return true;
  }
  /// The two unit vectors of a line are its frame's up to a turn about it; the distance from it is not.
  bool holds(const Lines& lines) const {
    if (!may_change(lines)) return true;
    const TripleOf<Sum> origin = clock_(lines.origin), d = clock_(lines.direction);
    return std::ranges::all_of(lines.points, [&](Index point) {
      const TripleOf<Sum> a = frame_.carry(places_[static_cast<std::size_t>(point)]) - origin;
      const Sum along = dot(a, d);
      return (dot(a, a) - along * along / dot(d, d)).is_constant();
    });
  }
  bool holds(const UserConstraints& group) const {
    if (!may_change(group)) return true;
    return group.kernel.expression && std::ranges::all_of(group.tuples, [&](const std::vector<Index>& tuple) {
             return evaluate_at(places_, *group.kernel.expression, tuple, {})[0].is_constant();
           });
  }
  Sum number_of(const Parameter& parameter, std::size_t k) const {
    if (parameter.functions.empty()) return 0.0;
    return clock_(parameter.functions[parameter.functions.size() == 1 ? 0 : k]);
  }

  /// Returns the results of an expression of the coordinates of points that the frame carries along, more constants,
  /// and time.
  template <class Tuple>
  std::vector<Sum> evaluate_at(const Places& places, const Expression& expression, const Tuple& tuple,
                               const std::vector<double>& more) const {
    std::vector<Sum> variables;
    for (const Index point : tuple) {
      const TripleOf<Sum> r = frame_.carry(places[static_cast<std::size_t>(point)]);
      variables.insert(variables.end(), {r.x, r.y, r.z});
    }
    variables.insert(variables.end(), more.begin(), more.end());
    variables.push_back(since(clock_.t));
    return evaluate(expression, variables);
  }

  // ---- forces: what is wrong with one, or nothing ----

  std::string changes(bool is_steady) const {
    if (is_steady) return {};
    return " changes with time" + (frame_.moves() ? " in the frame " + frame_.describe() : "") +
           ", so that nothing rests";
  }
  std::string moved() const { return " acts on what moves, as all does that rests in the frame " + frame_.describe(); }
  static std::string opaque() {
    return " is not known to stand still at all times: its formula is not known, only numbers of it";
  }

  /// Forces between points follow them.
  template <class Force>
  std::string complain(const Force&) const {
    return {};
  }
  std::string complain(const Gravity& gravity) const {
    return changes(is_constant(frame_.turn_back(triple_of<Sum>(gravity.acceleration))));
  }
  std::string complain(const ConstantForce& given) const {
    return changes(is_constant(frame_.turn_back(clock_(given.force))));
  }
  std::string complain(const Drag&) const { return frame_.moves() ? moved() : ""; }
  std::string complain(const PairForces& pairs) const {
    if (!frame_.turns() || pairs.box == Vector3{}) return {};
    return " is periodic and does not turn with the frame " + frame_.describe();
  }
  std::string complain(const FormulaForce& formula) const {
    const ForceKernel& kernel = formula.kernel;
    if (!may_change(formula)) return {};
    if (frame_.moves() && kernel.depends_on_velocity) return moved();
    if (!kernel.expression) return opaque();
    const auto is_steady = [&](const auto& tuple) {
      std::vector<double> v(3 * tuple.size());  // of no account where it is not read
      for (std::size_t i = 0; i < v.size(); ++i) v[i] = irregular(i);
      const std::vector<Sum> f = evaluate_at(places_, *kernel.expression, tuple, v);
      for (std::size_t i = 0; i < f.size(); i += 3) {
        if (!is_constant(frame_.turn_back({f[i], f[i + 1], f[i + 2]}))) return false;
      }
      return true;
    };
    return changes(std::ranges::all_of(formula.points, [&](Index point) { return is_steady(std::array{point}); }) &&
                   std::ranges::all_of(formula.tuples, is_steady));
  }
  /// An energy may change by the same amount everywhere.
  std::string complain(const Potential& potential) const {
    if (!may_change(potential)) return {};
    if (!potential.kernel.expression) return opaque();
    for (std::size_t k = 0; k < potential.points.size(); ++k) {
      std::vector<double> constants;
      for (const std::vector<double>& each : potential.constants) constants.push_back(each[each.size() == 1 ? 0 : k]);
      const auto energy = [&](const Places& places) {
        return evaluate_at(places, *potential.kernel.expression, potential.points[k], constants)[0];
      };
      if (!(energy(places_) - energy(beside_)).is_constant()) return changes(false);
    }
    return {};
  }

  const System& system_;
  SteadyFrame frame_;
  WholeClock clock_;
  Places places_, beside_;
};

}  // namespace

std::optional<UnsteadyPart> find_unknown_function(const System& system) {
  std::optional<UnsteadyPart> result;
  for_each_part(system, [&](const std::string& where, const std::string& name, const auto& part) {
    const std::string field = result ? "" : name_unknown_field(part);
    if (field.empty()) return;
    result = UnsteadyPart{where, name + " (" + field +
                                     ") is not known to move steadily: neither a polynomial of t nor sines and "
                                     "cosines of constant frequency, as all motions of steady frames are"};
  });
  return result;
}

std::optional<UnsteadyPart> find_unsteady_part(const System& system, const SteadyFrame& frame, double t,
                                               double scene_size) {
  return SteadinessTest(system, frame, t, scene_size).find();
}

}  // namespace tanor::detail
