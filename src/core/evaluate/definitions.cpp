#include "evaluate/definitions.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "evaluate/dual.hpp"
#include "system/members.hpp"
#include "system/tuples.hpp"

namespace tanor::detail {

namespace {

/// The result of recording a definition. A function of time that moves becomes a variable. One recording serves all
/// clocks and outlives them.
struct Recording {
  RecordedDefinition definition;
  std::optional<Traced> parameter;
};
struct TracingClock {
  double t;
  Recording* recording;

  Traced operator()(const ScalarFunction& function) const {
    if (function.is_constant()) return function(t).value();
    recording->definition.functions.push_back(function);
    return Traced::variable(recording->definition.expression);
  }
  TripleOf<Traced> operator()(const VectorFunction& function) const {
    return {(*this)(function.components[0]), (*this)(function.components[1]), (*this)(function.components[2])};
  }
};

/// The number of each member from a parameter. A function that all members share is evaluated once.
template <class T>
class Given {
 public:
  Given(const Parameter& parameter, std::span<const double> initial, const ClockOf<T>& clock)
      : parameter_(parameter), initial_(initial), clock_(clock) {
    if (parameter.functions.size() == 1) shared_ = clock(parameter.functions[0]);
  }
  T operator[](std::size_t k) const {
    if (parameter_.is_initial()) return T(initial_[k]);
    if (parameter_.functions.size() == 1) return shared_;
    if (!parameter_.functions.empty()) return clock_(parameter_.functions[k]);
    return T(parameter_.constants[parameter_.constants.size() == 1 ? 0 : k]);
  }

 private:
  const Parameter& parameter_;
  std::span<const double> initial_;
  ClockOf<T> clock_;
  T shared_{};
};

/// Records a parameter. Unless all members share it, one variable stands for the number of each.
Traced take_down(const Parameter& parameter, const TracingClock& clock) {
  if (parameter.functions.size() == 1) return clock(parameter.functions[0]);
  if (parameter.constants.size() == 1) return parameter.constants[0];
  clock.recording->definition.has_parameter = true;
  return *clock.recording->parameter;
}

const Parameter no_parameter = 0.0;

/// Returns the parameter of a group, or a constant 0 if its kind has none.
template <class Group>
const Parameter& parameter_of(const Group& group) {
  if constexpr (requires { KindOf<Group>::parameter; }) return group.*KindOf<Group>::parameter;
  return no_parameter;
}

/// Evaluates xi of the members of a group at one instant from the definition of its kind.
template <class Group, class T>
class Rows {
 public:
  Rows(const Group& group, const ClockOf<T>& clock, std::span<const double> initial)
      : group_(group), definition_(group, clock), numbers_(parameter_of(group), initial, clock) {}

  /// `at(point)` returns the position of a point.
  template <class At>
  auto xi(std::size_t k, const At& at) const {
    return definition_.xi(MemberPlaces{member_points(group_, k), at}, numbers_[k], k);
  }

 private:
  const Group& group_;
  typename KindOf<Group>::template Definition<T> definition_;
  Given<T> numbers_;
};

// ---- points ----

/// Points on the curve r + e v + e^2/2 w.
struct Along {
  const double *r, *v, *w;

  TripleOf<SecondDual> operator()(Index i) const {
    const auto [x, y, z] = load(r, i);
    const auto [vx, vy, vz] = load(v, i);
    const auto [wx, wy, wz] = load(w, i);
    return {second_dual(x, vx, wx), second_dual(y, vy, wy), second_dual(z, vz, wz)};
  }
};

/// Points on the line r + e u, to first order, with u = move(point).
template <class Move>
struct Straight {
  const double* r;
  Move move;

  TripleOf<Dual<double>> operator()(Index i) const {
    const auto [x, y, z] = load(r, i);
    const auto [ux, uy, uz] = move(i);
    return {{x, ux}, {y, uy}, {z, uz}};
  }
};
template <class Move>
Straight(const double*, Move) -> Straight<Move>;

/// Returns the tuples of a user's group, one after the other.
std::vector<Index> flatten(const UserConstraints& user) {
  std::vector<Index> points;
  for (const auto& tuple : user.tuples) points.insert(points.end(), tuple.begin(), tuple.end());
  return points;
}

/// Returns the gradient of member `first + k` of a user's group times w of its points.
double along_gradient(const UserConstraints& group, const TupleValues& values, std::size_t k, const double* w) {
  const std::vector<Index>& tuple = group.tuples[values.first + k];
  double sum = 0.0;
  for (std::size_t p = 0; p < tuple.size(); ++p) {
    sum += dot(load(values.gradient + k * values.size, p), load(w, tuple[p]));
  }
  return sum;
}

}  // namespace

Definitions::Definitions(const System& system, double t0, const double* positions)
    : system_(system),
      starts_(system.constraints.size()),
      first_outside_(system.supports.empty() ? std::numeric_limits<Index>::max() : find_first_outside(system)) {
  const PlacesIn at{positions == nullptr ? system.positions.data() : positions};
  for (std::size_t g = 0; g < starts_.size(); ++g) {
    std::visit(
        [&]<class Group>(const Group& group) {
          Start& start = starts_[g];
          start.first_row = num_rows_;
          num_rows_ += num_members(group) * rows_per_member<Group>();
          if constexpr (requires { KindOf<Group>::parameter; }) {
            if (!parameter_of(group).is_initial()) return;
            const typename KindOf<Group>::template Definition<double> definition(group, ClockOf<double>{t0});
            for (std::size_t k = 0; k < num_members(group); ++k)
              start.values.push_back(definition.measure(MemberPlaces{member_points(group, k), at}, k));
          }
        },
        system.constraints[g]);
  }
}

namespace {

/// Records the rows of a member as functions of its points and its number. See Definitions::record for `axis`.
template <class Group>
std::optional<RecordedDefinition> take_down(const Group& group, std::size_t member, std::optional<LineAxis> axis) {
  Recording recording;
  Expression& expression = recording.definition.expression;
  const std::size_t num_points = member_points(group, member).size();
  std::vector<TripleOf<Traced>> r;
  for (std::size_t p = 0; p < num_points; ++p) {
    const Traced x = Traced::variable(expression), y = Traced::variable(expression);
    r.push_back({x, y, Traced::variable(expression)});
  }
  recording.parameter = Traced::variable(expression);
  try {
    const TracingClock clock{0.0, &recording};
    using Definition = typename KindOf<Group>::template Definition<Traced>;
    const auto definition = [&] {
      if constexpr (requires { KindOf<Group>::turning; })
        return Definition(group, clock, axis);
      else
        return Definition(group, clock);
    }();
    const Traced number = take_down(parameter_of(group), clock);
    for (const Traced& xi : definition.xi(r, number, member)) expression.results.push_back(xi.number_in(expression));
  } catch (const detail::NotTraceable&) {
    return std::nullopt;
  }
  // The parameter's variable stands before those of the functions. It moves to the end, or is removed if it is not
  // read.
  const auto parameter = expression.variables.begin() + static_cast<std::ptrdiff_t>(3 * num_points);
  std::rotate(parameter, parameter + 1, expression.variables.end());
  if (!recording.definition.has_parameter) expression.variables.pop_back();
  return recording.definition;
}

}  // namespace

std::optional<RecordedDefinition> Definitions::record(std::size_t g, std::optional<LineAxis> axis,
                                                      std::size_t member) const {
  return std::visit(
      [&]<class Group>(const Group& group) -> std::optional<RecordedDefinition> {
        if (num_members(group) == 0) return std::nullopt;
        if constexpr (std::is_same_v<Group, UserConstraints>) {
          if (group.kernel.expression == nullptr) return std::nullopt;
          return RecordedDefinition{*group.kernel.expression, {ScalarFunction::formula("t")}, false};
        } else {
          return take_down(group, member, axis);
        }
      },
      system_.constraints[g]);
}

ScalarFunction Definitions::parameter(std::size_t g, std::size_t k) const {
  return std::visit(
      [&]<class Group>(const Group& group) -> ScalarFunction {
        return number_of(parameter_of(group), k, [&] { return starts_[g].values[k]; });
      },
      system_.constraints[g]);
}

template <class T, class At, class Use, class UseTuples>
void Definitions::for_each_row(const Parallel& parallel, double t, const double* r, const double* v, const At& at,
                               const Use& use, const UseTuples& use_tuples) const {
  for (std::size_t g = 0; g < starts_.size(); ++g) {
    const Start& start = starts_[g];
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (std::is_same_v<Group, UserConstraints>) {
            const std::vector<Index> points = flatten(group);
            const Parallel serial(1);
            const Parallel& loop = group.kernel.thread_safe ? parallel : serial;
            loop.for_ranges(num_members(group), [&](std::size_t begin, std::size_t end) {
              for_each_chunk(group.kernel, points, begin, end, t, r, v,
                             [&](const TupleValues& values) { use_tuples(start.first_row, group, values); });
            });
          } else {
            const Rows<Group, T> rows(group, ClockOf<T>{t}, start.values);
            parallel.for_ranges(num_members(group), [&](std::size_t begin, std::size_t end) {
              for (std::size_t k = begin; k < end; ++k) {
                if (member_points(group, k)[0] >= first_outside_) continue;
                std::size_t row = start.first_row + k * rows_per_member<Group>();
                for (const T& xi : rows.xi(k, at)) use(row++, xi);
              }
            });
          }
        },
        system_.constraints[g]);
  }
}

void Definitions::taylor(const Parallel& parallel, double t, std::span<const double> r, std::span<const double> v,
                         std::span<const double> w, std::span<double> xi, std::span<double> rate,
                         std::span<double> second) const {
  for_each_row<SecondDual>(
      parallel, t, r.data(), v.data(), Along{r.data(), v.data(), w.data()},
      [&](std::size_t row, const SecondDual& now) {
        xi[row] = now.v.v;
        rate[row] = now.v.d;
        second[row] = now.d.d;
      },
      [&](std::size_t first_row, const UserConstraints& group, const TupleValues& values) {
        for (std::size_t k = 0; k < values.count; ++k) {
          if (group.tuples[values.first + k][0] >= first_outside_) continue;
          const std::size_t row = first_row + values.first + k;
          xi[row] = values.xi[k];
          rate[row] = values.rate[k];
          second[row] = values.phi[k] + along_gradient(group, values, k, w.data());
        }
      });
}

void Definitions::transposed(const Parallel& parallel, double t, std::span<const double> r, std::span<const double> u,
                             std::span<double> y) const {
  for_each_row<Dual<double>>(
      parallel, t, r.data(), nullptr, Straight{r.data(), [&](Index i) { return load(u.data(), i); }},
      [&](std::size_t row, const Dual<double>& xi) { y[row] = xi.d; },
      [&](std::size_t first_row, const UserConstraints& group, const TupleValues& values) {
        for (std::size_t k = 0; k < values.count; ++k) {
          if (group.tuples[values.first + k][0] >= first_outside_) continue;
          y[first_row + values.first + k] = along_gradient(group, values, k, u.data());
        }
      });
}

template <class Use>
void Definitions::for_each_gradient(double t, std::span<const double> r, const Use& use) const {
  for (std::size_t g = 0; g < starts_.size(); ++g) {
    const Start& start = starts_[g];
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (std::is_same_v<Group, UserConstraints>) {
            for_each_chunk(group.kernel, flatten(group), 0, num_members(group), t, r.data(), nullptr,
                           [&](const TupleValues& values) {
                             for (std::size_t k = 0; k < values.count; ++k) {
                               const std::size_t member = values.first + k;
                               for (std::size_t p = 0; p < group.tuples[member].size(); ++p) {
                                 use(start.first_row + member, group.tuples[member][p],
                                     load(values.gradient + k * values.size, p));
                               }
                             }
                           });
          } else {
            using Number = Dual<double>;
            constexpr auto num_rows = static_cast<std::size_t>(rows_per_member<Group>());
            const Rows<Group, Number> rows(group, ClockOf<Number>{t}, start.values);
            for (std::size_t k = 0; k < num_members(group); ++k) {
              for (const Index point : member_points(group, k)) {
                const auto along = [&](const Vec3& axis) -> std::array<Number, num_rows> {
                  return rows.xi(k, Straight{r.data(), [&](Index i) { return i == point ? axis : Vec3{}; }});
                };
                const std::array x = along({1.0, 0.0, 0.0}), y = along({0.0, 1.0, 0.0}), z = along({0.0, 0.0, 1.0});
                for (std::size_t m = 0; m < num_rows; ++m)
                  use(start.first_row + k * num_rows + m, point, Vec3{x[m].d, y[m].d, z[m].d});
              }
            }
          }
        },
        system_.constraints[g]);
  }
}

void Definitions::for_each_reaction(double t, std::span<const double> r, std::span<const double> lambda,
                                    const UseReaction& use) const {
  for_each_gradient(t, r, [&](std::size_t row, Index point, const Vec3& gradient) {
    if (point < first_outside_) use(row, point, lambda[row] * gradient);
  });
}

void Definitions::reactions(double t, std::span<const double> r, std::span<const double> lambda,
                            std::span<double> eta) const {
  std::ranges::fill(eta, 0.0);
  for_each_reaction(t, r, lambda,
                    [&](std::size_t, Index point, const Vec3& force) { add_to(eta.data(), point, force); });
}

}  // namespace tanor::detail
